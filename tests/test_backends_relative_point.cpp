#include "test_backends.hpp"

namespace holdfast::testing {
using RelativePointOnPoses = OnPoses<RelativePoint>;
HOLDFAST_CONFORMANCE_TESTS(RelativePointOnPoses)
}  // namespace holdfast::testing
