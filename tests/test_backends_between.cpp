#include "test_backends.hpp"

namespace holdfast::testing {
using BetweenOnAll = OnAll<Between>;
HOLDFAST_CONFORMANCE_TESTS(BetweenOnAll)
}  // namespace holdfast::testing
