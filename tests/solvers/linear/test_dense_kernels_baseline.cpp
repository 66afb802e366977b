// The same facts of the kernels for processors without AVX2: their source is compiled into this program, and the library's stays out.
#define HOLDFAST_WITHOUT_AVX2
#include "solvers/linear/dense_kernels.cpp"
#include "tests/solvers/linear/test_dense_kernels.cpp"
