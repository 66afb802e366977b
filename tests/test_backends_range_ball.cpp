#include "test_backends.hpp"

namespace holdfast::testing {
using RangeBallOnPairs = OnPairs<RangeBall>;
HOLDFAST_CONFORMANCE_TESTS(RangeBallOnPairs)
}  // namespace holdfast::testing
