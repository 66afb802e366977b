#include "test_backends.hpp"

namespace holdfast::testing {
using PositionStepOnPairs = OnPairs<PositionStep>;
HOLDFAST_CONFORMANCE_TESTS(PositionStepOnPairs)
}  // namespace holdfast::testing
