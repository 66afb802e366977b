#include "test_backends.hpp"

namespace holdfast::testing {
using RangeBearingOnSomePairs = OnSomePairs<RangeBearing>;
using BearingRayOnSomePairs = OnSomePairs<BearingRay>;
HOLDFAST_CONFORMANCE_TESTS(RangeBearingOnSomePairs)
HOLDFAST_CONFORMANCE_TESTS(BearingRayOnSomePairs)
}  // namespace holdfast::testing
