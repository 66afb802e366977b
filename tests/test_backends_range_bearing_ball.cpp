#include "test_backends.hpp"

namespace holdfast::testing {
using RangeBearingBallOnPairs = OnPairs<RangeBearingBall>;
HOLDFAST_CONFORMANCE_TESTS(RangeBearingBallOnPairs)
}  // namespace holdfast::testing
