#include "test_backends.hpp"

namespace holdfast::testing {
HOLDFAST_CONFORMANCE_TESTS(LinearFactors)
}  // namespace holdfast::testing
