// Which measurements are believed: the weight of a residual, the verdict at ½, and what the report says of each.
#include <gtest/gtest.h>

#include <holdfast/graph/linear_prior.hpp>
#include <holdfast/solvers/outlier_report.hpp>

#include "tests/problems.hpp"

namespace holdfast::testing {
namespace {

constexpr Agent A('A'), L('L');

using Verdict = MeasurementReport::Verdict;

double weight_of(const Loss& loss, double r) { return relative_weight(loss, &r, 1); }
bool rejects(const Loss& loss, double r) { return is_rejected(weight_of(loss, r)); }

TEST(RelativeWeight, IsOneAtZeroForEveryLoss) {
  for (int kind = 0; kind < kLossKinds; ++kind) EXPECT_DOUBLE_EQ(weight_of(default_loss(kind), 0), 1) << default_loss(kind).str();
}

// ρ' by hand.
TEST(RelativeWeight, IsTheSlopeOverTheSlopeAtZero) {
  EXPECT_DOUBLE_EQ(weight_of(Squared{}, 1e9), 1);
  EXPECT_DOUBLE_EQ(weight_of(Huber{2}, -8), 0.25);
  EXPECT_DOUBLE_EQ(weight_of(Cauchy{2}, 2), 0.5);
  EXPECT_DOUBLE_EQ(weight_of(TruncatedSquares{2}, 2.1), 0);
  EXPECT_DOUBLE_EQ(weight_of(StudentT{3}, 3), 0.25);                       // 4 / 12 over 4 / 3
  EXPECT_NEAR(weight_of(Absolute{0.1}, 1), 0.1 / std::sqrt(1.01), 1e-15);  // 1 / √1.01 over 1 / 0.1
}

TEST(RelativeWeight, OfABlockIsThatOfItsNorm) {
  const double r[] = {3, 4};
  EXPECT_DOUBLE_EQ(relative_weight(Huber{1}, r, 2), 0.2);
  EXPECT_DOUBLE_EQ(relative_weight(StudentT{5}, r, 2), 5.0 / 30);  // ν / (ν + s), whatever d is
}

TEST(RelativeWeight, OfComponentsIsTheLeast) {
  const double r[] = {3, -4, 0.1};
  EXPECT_DOUBLE_EQ(relative_weight(per_component(Huber{1}), r, 3), 0.25);
}

// Also where ρ'(0) is not 1.
TEST(RelativeWeight, IsOneOnTheHarmlessSide) {
  for (int kind = 0; kind < kLossKinds; ++kind) {
    const Loss loss = one_sided(default_loss(kind));
    EXPECT_DOUBLE_EQ(weight_of(loss, 50), 1) << loss.str();
    EXPECT_DOUBLE_EQ(weight_of(loss, -50), weight_of(default_loss(kind), -50)) << loss.str();
  }
}

TEST(Rejected, IsBelowAHalf) {
  EXPECT_FALSE(is_rejected(0.5));
  EXPECT_TRUE(is_rejected(std::nextafter(0.5, 0)));
  EXPECT_FALSE(rejects(Huber{2}, 4));
  EXPECT_TRUE(rejects(Huber{2}, 4.0001));
  EXPECT_FALSE(rejects(Cauchy{3}, -3));
  EXPECT_TRUE(rejects(Cauchy{3}, -3.0001));
  EXPECT_FALSE(rejects(StudentT{4}, 2));  // ‖r‖² = ν
  EXPECT_TRUE(rejects(StudentT{4}, 2.0001));
  EXPECT_FALSE(rejects(Absolute{0.1}, 0.1732));  // √3 widths
  EXPECT_TRUE(rejects(Absolute{0.1}, 0.1733));
}

/// Points at (0, 0) and (3, 4) with a range of 9 m between them: 4 sigmas off, at Huber 2 a weight of exactly ½.
struct AtTheBoundary {
  Graph graph;
  Values values;
  FactorId range;

  AtTheBoundary() {
    values.insert(A(0), Point2(0, 0));
    values.insert(L(1), Point2(3, 4));
    graph.add(Prior<Point2>::from_sigmas(Point2(0, 0), Vector<2>(1, 1)), {A(0)});
    range = graph.add(Range<Point2, Point2>{9, 1}, {A(0), L(1)}, Huber{2});
  }
  MeasurementReport report(const std::unordered_map<Key, double>& times = {}) const {
    for (const MeasurementReport& one : outlier_report(graph, values, times))
      if (one.factor == "Range") return one;
    ADD_FAILURE() << "no range";
    return {};
  }
};

TEST(OutlierReport, BelievesAtAHalfAndNotBelow) {
  AtTheBoundary problem;
  EXPECT_DOUBLE_EQ(problem.report().weight, 0.5);
  EXPECT_EQ(problem.report().verdict, Verdict::inlier);
  problem.graph.at<Range<Point2, Point2>>(problem.range).distance = 9.001;
  EXPECT_LT(problem.report().weight, 0.5);
  EXPECT_EQ(problem.report().verdict, Verdict::outlier);
}

TEST(OutlierReport, NamesFactorKeysAndResidual) {
  AtTheBoundary problem;
  problem.graph.at<Range<Point2, Point2>>(problem.range).sigma = 0.5;
  const MeasurementReport one = problem.report();
  EXPECT_EQ(one.id.number, problem.range.number);
  EXPECT_EQ(one.keys, (std::vector<Key>{A(0), L(1)}));
  EXPECT_EQ(one.whitened, std::vector<double>{-8});  // predicted − measured, over sigma
  EXPECT_EQ(one.raw, std::vector<double>{-4});       // [m]
}

TEST(OutlierReport, HasTheLatestTimeOfTheKeys) {
  const AtTheBoundary problem;
  EXPECT_TRUE(std::isnan(problem.report().time));
  EXPECT_EQ(problem.report({{A(0), 3.5}}).time, 3.5);
  EXPECT_EQ(problem.report({{A(0), 3.5}, {L(1), 4.5}}).time, 4.5);
  EXPECT_EQ(problem.report({{A(0), 5.5}, {L(1), 4.5}}).time, 5.5);
}

TEST(OutlierReport, SaysWhichResidualIsNoNumber) {
  AtTheBoundary problem;
  for (const double bad : {static_cast<double>(NAN), 1e200}) {  // the square of the second overflows
    problem.values.at<Point2>(L(1)).value[0] = bad;
    EXPECT_EQ(problem.report().verdict, Verdict::not_finite);
  }
  EXPECT_STREQ(to_string(Verdict::not_finite), "not finite");
  EXPECT_STREQ(to_string(Verdict::inlier), "inlier");
  EXPECT_STREQ(to_string(Verdict::outlier), "outlier");
}

TEST(OutlierReport, LeavesOutWhatWasMarginalised) {
  AtTheBoundary problem;
  LinearPrior prior;
  prior.rows = 1;
  const Point2 at(0, 0);
  prior.add_variable(A(0), Pool<Point2>::prototype(), at.value.data());
  prior.A = {1, 0};
  prior.b = {100};
  problem.graph.add(prior);
  EXPECT_EQ(outlier_report(problem.graph, problem.values).size(), 2u);
}

}  // namespace
}  // namespace holdfast::testing
