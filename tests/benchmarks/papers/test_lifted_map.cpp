// Paper C's problem with all its auxiliaries against the same with y and Ω eliminated.
#include <gtest/gtest.h>

#include <cmath>
#include <holdfast/benchmarks/papers/lifted_map.hpp>
#include <holdfast/benchmarks/papers/missing_map.hpp>

namespace holdfast::bench {
namespace {

NetworkOptions ten_steps(Course course) {
  NetworkOptions options;
  options.course = course;
  options.steps = 10;
  options.whole_network = false;
  return options;
}

template <int S>
double size_of(const Tracks<S>& tracks) {
  return largest_difference<S>(tracks, Tracks<S>(tracks.size(), std::vector<Vector<S>>(tracks[0].size(), Vector<S>::Zero())));
}

template <int S>
void expect_same_optimum(Course course, Missing missing) {
  const Network<S> network = make_network<S>(ten_steps(course), 5);
  LiftedMap<S> lifted(network, missing);
  lifted.minimize(LiftedSteps::restarted, 20000, [](const auto&) { return false; });
  const Tracks<S> eliminated = missing_map(network, {MissingMap::Previous::free, missing}, "irls");
  EXPECT_LT(largest_difference<S>(lifted.tracks(), eliminated), 1e-6 * size_of<S>(eliminated)) << to_string(course);
}

TEST(LiftedMap, HasTheOptimumOfTheEliminatedForm) {
  for (const Missing missing : {Missing::nothing, Missing::coupled}) {
    for (const Course course : {Course::linear, Course::spiral, Course::non_formation}) expect_same_optimum<2>(course, missing);
    expect_same_optimum<3>(Course::helix, missing);
  }
}

// (35) is a sum over all priors: it exceeds L, and the momentum (1 − √(m/L)) / (1 + √(m/L)) is negative.
TEST(LiftedMap, ThePrintedConstants) {
  const Network<2> network = make_network<2>(ten_steps(Course::linear), 5);
  const LiftedMap<2> lifted(network, Missing::nothing);
  int lost = 0;
  for (const auto& step : network.steps)
    for (const auto& packet : step.packets) lost += !packet.received;
  EXPECT_NEAR(lifted.printed_m(), 30 / std::pow(network.longest_step, 2) + 4 * lost, 1e-9);
  EXPECT_GE(lifted.printed_L(), lifted.largest_eigenvalue());
  EXPECT_GT(lifted.printed_m(), lifted.printed_L());
}

// Each y on the ball of its own Ω, with Ω left alone, stalls at a point that is no optimum where Ω is coupled.
TEST(LiftedMap, ThePrintedProjectionStallsWhereOmegaIsCoupled) {
  const Network<2> network = make_network<2>(ten_steps(Course::linear), 5);
  LiftedMap<2> lifted(network, Missing::coupled);
  lifted.minimize(LiftedSteps::printed, 20000, [](const auto&) { return false; });
  const Tracks<2> eliminated = missing_map(network, {MissingMap::Previous::free, Missing::coupled}, "irls");
  EXPECT_GT(largest_difference<2>(lifted.tracks(), eliminated), 1e-4 * size_of<2>(eliminated));
}

TEST(LiftedMap, TheConeByHand) {
  Vector<2> y(3, 4);
  double omega = 1;
  LiftedMap<2>::project_on_cone(y, omega);  // ‖y‖ = 5: half way, 3
  EXPECT_NEAR(omega, 3, 1e-15);
  EXPECT_LT((y - Vector<2>(1.8, 2.4)).norm(), 1e-15);
  LiftedMap<2>::project_on_cone(y, omega);  // on it: stays
  EXPECT_NEAR(omega, 3, 1e-15);
  omega = -4;
  LiftedMap<2>::project_on_cone(y, omega);  // below the opposite cone: its tip
  EXPECT_EQ(omega, 0);
  EXPECT_EQ(y.norm(), 0);
}

}  // namespace
}  // namespace holdfast::bench
