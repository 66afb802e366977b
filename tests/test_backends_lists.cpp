// The conformance tests are spread over test_backends_*.cpp: together they cover every factor of the library.
#include <gtest/gtest.h>

#include "samples.hpp"

namespace holdfast::testing {
namespace {

// Every list that a test_backends_*.cpp runs over. A factor that is added to samples.hpp must appear here, and in one of them.
using Covered = Concat<LinearFactors, OnPairs<Range>, OnPairs<RangeBall>, OnPairs<RangeBearingBall>, OnPairs<MissingDistance>,
                       OnPairs<MissingDistanceBall>, OnPairs<VonMisesBearing>, OnPoses<VonMisesBearingBody>, OnPoses<RelativePoint>,
                       OnPairs<PositionStep>, OnSomePairs<RangeBearing>, OnSomePairs<BearingRay>, OnAll<Prior>, OnAll<Between>>;

TEST(Conformance, CoversEveryFactor) { EXPECT_TRUE((std::is_same_v<Covered, AllFactors>)); }

}  // namespace
}  // namespace holdfast::testing
