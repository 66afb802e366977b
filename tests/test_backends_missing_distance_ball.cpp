#include "test_backends.hpp"

namespace holdfast::testing {
using MissingDistanceBallOnPairs = OnPairs<MissingDistanceBall>;
HOLDFAST_CONFORMANCE_TESTS(MissingDistanceBallOnPairs)
}  // namespace holdfast::testing
