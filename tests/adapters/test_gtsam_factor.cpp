// A factor of ours as GTSAM's own code sees it: what it is equal to, and what messages call it.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <gtsam/inference/Symbol.h>

#include <holdfast/adapters/gtsam/graph.hpp>
#include <holdfast/factors/between.hpp>
#include <holdfast/factors/range.hpp>

#include "tests/problems.hpp"

namespace holdfast::testing {
namespace {

using gtsam::Symbol;
using ::testing::HasSubstr;
using RangeToPoint = Range<Pose2, Point2>;

const gtsam::KeyVector kKeys{Symbol('x', 7), Symbol('l', 2)};

gtsam::NonlinearFactor::shared_ptr range(double distance, double sigma, const Loss& loss = Huber{2}, double weight = 1,
                                         const gtsam::KeyVector& keys = kKeys) {
  return gtsam_factor(RangeToPoint{distance, sigma}, keys, loss, weight);
}

TEST(GtsamFactorEquals, ComparesKeysMeasurementNoiseLossAndWeight) {
  const auto factor = range(1, 0.5);
  EXPECT_TRUE(factor->equals(*range(1, 0.5)));
  EXPECT_FALSE(factor->equals(*range(9, 0.5)));
  EXPECT_FALSE(factor->equals(*range(1, 0.6)));
  EXPECT_FALSE(factor->equals(*range(1, 0.5, Huber{3})));
  EXPECT_FALSE(factor->equals(*range(1, 0.5, Cauchy{2})));
  EXPECT_FALSE(factor->equals(*range(1, 0.5, one_sided(Huber{2}))));
  EXPECT_FALSE(factor->equals(*range(1, 0.5, Huber{2}, 0.9)));
  EXPECT_FALSE(factor->equals(*range(1, 0.5, Huber{2}, 1, {Symbol('x', 7), Symbol('l', 3)})));
}

TEST(GtsamFactorEquals, TakesDoublesWithinTheTolerance) {
  const auto factor = range(1, 0.5);
  EXPECT_TRUE(factor->equals(*range(1 + 1e-10, 0.5)));
  EXPECT_FALSE(factor->equals(*range(1 + 1e-8, 0.5)));
  EXPECT_TRUE(factor->equals(*range(1.1, 0.4, Huber{2.1}, 1.1), 0.11));
  EXPECT_FALSE(factor->equals(*range(1.1, 0.4), 0.09));
}

TEST(GtsamFactorEquals, ComparesMatrices) {
  const auto between = [](double x, double sigma) {
    return gtsam_factor(Between<Pose2>::from_sigmas(Pose2(x, 0, 0), Vector<3>(1, 1, sigma)), {1, 2});
  };
  EXPECT_TRUE(between(1, 2)->equals(*between(1, 2)));
  EXPECT_FALSE(between(1, 2)->equals(*between(2, 2)));
  EXPECT_FALSE(between(1, 2)->equals(*between(1, 3)));
  EXPECT_FALSE(between(1, 2)->equals(*range(1, 1, Squared{}, 1, {1, 2})));
}

/// Lists no fields: nobody knows its numbers.
struct Unlisted {
  double x;
  using Variables = variables<Point2>;
  static constexpr int residual_dim = 1;
  Vector<1> operator()(const Point2& p, Jacobians<Unlisted>* J = nullptr) const {
    if (J != nullptr) J->all << 1, 0;
    return Vector<1>(p.value[0] - x);
  }
};

TEST(GtsamFactorEquals, OfATypeWithoutFieldsItIsEqualToItsClonesAlone) {
  const auto factor = gtsam_factor(Unlisted{1}, {5});
  EXPECT_TRUE(factor->equals(*factor));
  EXPECT_TRUE(factor->equals(*factor->clone()));
  EXPECT_FALSE(factor->equals(*gtsam_factor(Unlisted{1}, {5})));
}

TEST(GtsamFactorEquals, ComparesConstants) {
  Graph graph;
  graph.add(RangeToPoint{1, 0.5}, {Key('x', 7), Key('l', 2)});
  graph.fix(Key('l', 2));
  Values here, there;
  here.insert(Key('l', 2), Point2(1, 2));
  there.insert(Key('l', 2), Point2(1, 3));
  const auto in_gtsam = to_gtsam(graph, here);
  EXPECT_TRUE(in_gtsam.equals(to_gtsam(graph, here)));
  EXPECT_FALSE(in_gtsam.equals(to_gtsam(graph, there)));
}

TEST(GtsamFactorEquals, OfAPriorOfRunTimeSizeComparesItsRows) {
  const auto in_gtsam = [](double b) {
    LinearPrior prior;
    prior.add_variable(Key('x', 1), Point2(1, 2));
    prior.rows = 1;
    prior.A = {1, 0};
    prior.b = {b};
    Graph graph;
    graph.add(prior);
    return std::make_pair(std::make_shared<Graph>(graph), b);
  };
  const auto one = in_gtsam(3), same = in_gtsam(3), other = in_gtsam(4);
  EXPECT_TRUE(to_gtsam(*one.first, Values()).equals(to_gtsam(*same.first, Values())));
  EXPECT_FALSE(to_gtsam(*one.first, Values()).equals(to_gtsam(*other.first, Values())));
}

template <class E, class Run>
std::string message_of(const Run& run) {
  try {
    run();
  } catch (const E& error) {
    return error.what();
  }
  return "nothing was thrown";
}

TEST(GtsamFactorMessages, NameTheGraphsKeys) {
  EXPECT_THAT(message_of<BadNumber>([] { range(1, -0.5); }), HasSubstr("Range(x7, l2)"));
  EXPECT_THAT(message_of<BadNumber>([] { range(1, 0.5, Huber{2}, -1); }), HasSubstr("Range(x7, l2)"));
  EXPECT_THAT(message_of<BadKey>([] { range(1, 0.5, Huber{2}, 1, {Symbol('x', 7), Symbol('x', 7)}); }), HasSubstr("x7"));
  EXPECT_THAT(message_of<BadKey>([] { range(1, 0.5, Huber{2}, 1, {Symbol('x', 7)}); }), HasSubstr("Range ties 2 variables, not 1"));
  EXPECT_EQ(static_cast<const GtsamFactor&>(*range(1, 0.5)).term().batch().describe(0), "Range(x7, l2)");
}

TEST(GtsamFactorMessages, OfAWholeGraphNameItsKeys) {
  Graph graph;
  graph.add(RangeToPoint{1, 0.5}, {Key('x', 7), Key('l', 2)});
  const gtsam::NonlinearFactorGraph theirs = to_gtsam(graph, Values());
  EXPECT_EQ(static_cast<const GtsamFactor&>(*theirs[0]).term().batch().describe(0), "Range(x7, l2)");
}

}  // namespace
}  // namespace holdfast::testing
