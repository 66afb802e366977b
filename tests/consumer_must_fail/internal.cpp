// Reaches for a header that only the library itself may include.
#include <holdfast/solvers/linear/internal/block_cholesky.hpp>

int main() { return 0; }
