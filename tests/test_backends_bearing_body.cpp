#include "test_backends.hpp"

namespace holdfast::testing {
using BearingBodyOnPoses = OnPoses<VonMisesBearingBody>;
HOLDFAST_CONFORMANCE_TESTS(BearingBodyOnPoses)
}  // namespace holdfast::testing
