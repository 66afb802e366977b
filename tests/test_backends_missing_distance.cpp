#include "test_backends.hpp"

namespace holdfast::testing {
using MissingDistanceOnPairs = OnPairs<MissingDistance>;
HOLDFAST_CONFORMANCE_TESTS(MissingDistanceOnPairs)
}  // namespace holdfast::testing
