#include "test_backends.hpp"

namespace holdfast::testing {
using PriorOnAll = OnAll<Prior>;
HOLDFAST_CONFORMANCE_TESTS(PriorOnAll)
}  // namespace holdfast::testing
