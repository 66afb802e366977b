#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <holdfast/graph/observability.hpp>
#include <holdfast/solvers/linear/internal/normal_equations.hpp>
#include <holdfast/solvers/marginals.hpp>

#include "tests/problems.hpp"

namespace holdfast::testing {
namespace {

using Eigen::MatrixXd;

constexpr Agent A('A'), B('B'), L('L');

/// H⁻¹ in Resolved's tangent, from the factors one by one.
struct Dense {
  Resolved resolved;
  MatrixXd covariance;

  Dense(const Graph& graph, const Values& values) : resolved(graph, values) {
    std::vector<int> order;
    for (std::size_t v = 0; v < resolved.variables().size(); ++v)
      if (resolved.variables()[v].offset >= 0) order.push_back(static_cast<int>(v));
    NormalEquations normal(graph, resolved, order);
    normal.linearize(graph, resolved, values, Curvature::irls);
    const BlockPattern& p = normal.pattern();
    MatrixXd H = MatrixXd::Zero(p.scalar_size(), p.scalar_size());
    for (int c = 0; c < p.size(); ++c)
      for (int k = p.column_begin[c]; k < p.column_begin[c + 1]; ++k)
        H.block(p.offsets[p.rows[k]], p.offsets[c], p.dims[p.rows[k]], p.dims[c]) =
            Eigen::Map<const MatrixXd>(&normal.H()[p.block_begin[k]], p.dims[p.rows[k]], p.dims[c]);
    covariance = MatrixXd(H.selfadjointView<Eigen::Lower>()).inverse();
  }
  const Resolved::Variable& at(Key key) const {
    return *std::find_if(resolved.variables().begin(), resolved.variables().end(), [&](const auto& v) { return v.key == key; });
  }
  MatrixXd joint(Key a, Key b) const {
    const Resolved::Variable &va = at(a), &vb = at(b);
    MatrixXd C(va.dim + vb.dim, va.dim + vb.dim);
    C << covariance.block(va.offset, va.offset, va.dim, va.dim), covariance.block(va.offset, vb.offset, va.dim, vb.dim),
        covariance.block(vb.offset, va.offset, vb.dim, va.dim), covariance.block(vb.offset, vb.offset, vb.dim, vb.dim);
    return C;
  }
};

void expect_near(const std::vector<double>& C, const MatrixXd& expected, const std::string& what) {
  ASSERT_EQ(C.size(), static_cast<std::size_t>(expected.size())) << what;
  EXPECT_LT((Eigen::Map<const MatrixXd>(C.data(), expected.rows(), expected.cols()) - expected).norm(), 1e-9 * expected.norm()) << what;
}

void expect_like_dense(const Graph& graph, const Values& values) {
  const Marginals marginals(graph, values);
  const Dense dense(graph, values);
  EXPECT_TRUE(marginals.unobservable().empty());
  for (const Resolved::Variable& a : dense.resolved.variables()) {
    if (a.offset < 0) continue;
    expect_near(marginals.covariance(a.key), dense.covariance.block(a.offset, a.offset, a.dim, a.dim), a.key.str());
    for (const Resolved::Variable& b : dense.resolved.variables())
      if (b.offset >= 0) expect_near(marginals.joint(a.key, b.key), dense.joint(a.key, b.key), a.key.str() + " " + b.key.str());
  }
}

TEST(Marginals, AreTheBlocksOfTheDenseInverse) {
  for (const std::uint64_t seed : {1, 2, 3}) {
    for (const Loss& loss : {Loss(Squared{}), Loss(Cauchy{1})}) {
      const SmallProblem plane = slam<Pose2>(seed, 40, 0.1, loss), space = slam<Pose3>(seed, 25, 0.1, loss);
      expect_like_dense(plane.graph, plane.start);
      expect_like_dense(space.graph, space.start);
    }
    const SmallProblem chain = tracking<Motion2>(seed, 30, 0.1, Huber{2}), full = range_balls<Point3>(seed, 15, Squared{});
    expect_like_dense(chain.graph, chain.start);
    expect_like_dense(full.graph, full.start);
  }
  const SmallProblem large = slam<Pose2>(4, 150, 0.1), wide = range_balls<Point3>(5, 40, Squared{});  // a front of 120
  expect_like_dense(large.graph, large.truth);
  expect_like_dense(wide.graph, wide.start);
}

/// Points on a line with a prior of sigma0 on the first and steps of sigma.
SmallProblem random_walk(int points, double sigma0, double sigma) {
  SmallProblem walk;
  for (int k = 0; k < points; ++k) {
    walk.start.insert(A(k), Point2(k, 0.0));
    if (k == 0) walk.graph.add(Prior<Point2>::from_sigmas(Point2(0, 0), {sigma0, sigma0}), {A(0)});
    if (k > 0) walk.graph.add(PositionStep<Point2, Point2>{sigma}, {A(k - 1), A(k)});
  }
  return walk;
}

TEST(Marginals, OfARandomWalkGrowByTheVarianceOfAStep) {
  const SmallProblem walk = random_walk(200, 0.3, 0.5);
  const Marginals marginals(walk.graph, walk.start);
  for (int k = 0; k < 200; ++k) {
    const double variance = 0.09 + k * 0.25;
    EXPECT_LT((marginals.covariance<Point2>(A(k)) - variance * Matrix<2, 2>::Identity()).norm(), 1e-9 * variance) << k;
  }
  const Matrix<4, 4> joint = marginals.joint<Point2, Point2>(A(150), A(10));  // what they share is the way to the first
  EXPECT_NEAR(joint(0, 2), 0.09 + 10 * 0.25, 1e-9);
  EXPECT_NEAR(joint(3, 1), 0.09 + 10 * 0.25, 1e-9);
  EXPECT_NEAR(joint(0, 3), 0, 1e-9);
}

TEST(Marginals, HoldForSigmasFarApart) {
  for (const double sigma : {1e-6, 1e6}) {
    const SmallProblem walk = random_walk(50, sigma, 1e3 * sigma);
    const double variance = sigma * sigma * (1 + 49e6);
    EXPECT_NEAR(Marginals(walk.graph, walk.start).covariance<Point2>(A(49))(0, 0), variance, 1e-6 * variance);
  }
}

TEST(Marginals, TellAWeakReferenceOfAStiffChainFromNone) {
  SmallProblem chain;
  for (int k = 0; k < 2000; ++k) {
    chain.start.insert(A(k), Motion2());
    if (k > 0) chain.graph.add(WhiteAcceleration<Motion2>::continuous(0.01, 1e-6), {A(k - 1), A(k)});  // informations up to 1e13
  }
  EXPECT_EQ(Marginals(chain.graph, chain.start).unobservable().size(), 2000u);
  for (int k = 0; k < 2000; k += 10) chain.graph.add(Prior<Motion2>::from_sigmas(Motion2(), Vector<4>::Ones()), {A(k)});
  EXPECT_TRUE(Marginals(chain.graph, chain.start).unobservable().empty());
}

/// What check() finds free, and whether Marginals agree.
bool is_free(const SmallProblem& problem) {
  const Resolved resolved(problem.graph, problem.start);
  bool found = false;
  for (const GraphComponent& component : observability(problem.graph, resolved, problem.start))
    found = found || !component.gauge.empty() || !component.directions.empty();
  EXPECT_EQ(found, !Marginals(problem.graph, problem.start).unobservable().empty());
  return found;
}

// A chain of n points a step of 1 apart with a prior of information e on the first: z = (1, …, 1) has zᵀ H z = e, and zᵀ diag(H) z is
// 2 (n − 1). By its last pivot alone, which is e, a chain of two is free at 1e-14, and one of 2,000 is not at 1e-12.
TEST(Marginals, AndTheCheckOfAGraphHaveOneRuleForWhatIsFree) {
  const auto chain = [](int points, double information) { return random_walk(points, 1 / std::sqrt(information), 1); };
  EXPECT_FALSE(is_free(chain(2, 2e-14)));
  EXPECT_FALSE(is_free(chain(2, 1e-14)));
  EXPECT_TRUE(is_free(chain(2, 1e-17)));
  EXPECT_FALSE(is_free(chain(2000, 1e-10)));
  EXPECT_TRUE(is_free(chain(2000, 1e-12)));
}

TEST(Unobservable, IsAtMostOnePartInAThousandMillionMillions) {
  EXPECT_TRUE(holdfast::detail::is_unobservable(1e-15, 1));
  EXPECT_FALSE(holdfast::detail::is_unobservable(1.01e-15, 1));
  EXPECT_TRUE(holdfast::detail::is_unobservable(1e-12, 1000));
  EXPECT_TRUE(holdfast::detail::is_unobservable(0, 0));
  EXPECT_TRUE(holdfast::detail::is_unobservable(-1e-16, 1));
  EXPECT_TRUE(holdfast::detail::is_unobservable(NAN, 1));
}

TEST(Marginals, OfAFixedVariableAreZero) {
  SmallProblem walk = random_walk(5, 1, 0.5);
  walk.graph.fix(A(2));
  const Marginals marginals(walk.graph, walk.start);
  EXPECT_TRUE(marginals.covariance<Point2>(A(2)).isZero(0));
  EXPECT_NEAR(marginals.covariance<Point2>(A(4))(0, 0), 0.5, 1e-12);  // two steps from a constant
  const Matrix<4, 4> joint = marginals.joint<Point2, Point2>(A(2), A(3));
  EXPECT_TRUE((joint.topRows<2>().isZero(0)));
  EXPECT_NEAR(joint(2, 2), 0.25, 1e-12);
  EXPECT_NEAR((marginals.joint<Point2, Point2>(A(1), A(3))(0, 2)), 0, 1e-12);

  const SmallProblem slam_problem = slam<Pose3>(7, 15, 0.1);
  Graph graph = slam_problem.graph;
  graph.fix(A(5));
  graph.fix(L(1));
  expect_like_dense(graph, slam_problem.start);

  for (int k = 0; k < 5; ++k) walk.graph.fix(A(k));
  EXPECT_TRUE((Marginals(walk.graph, walk.start).joint<Point2, Point2>(A(0), A(1)).isZero(0)));
}

TEST(Marginals, NameAPartWithoutAReferenceAndAnswerForTheOthers) {
  SmallProblem problem = slam<Pose2>(5, 20, 0.1);
  const Marginals alone(problem.graph, problem.start);
  Pose2 x;
  for (int i = 0; i < 200; ++i, x = x * Pose2(1, 0.3, 0.1)) {  // 200 more poses that float
    problem.start.insert(B(i), x);
    if (i > 0) problem.graph.add(Between<Pose2>::from_sigmas(Pose2(1, 0.3, 0.1), {0.1, 0.1, 0.05}), {B(i - 1), B(i)});
  }
  const Marginals both(problem.graph, problem.start);
  EXPECT_EQ(both.unobservable().size(), 200u);
  EXPECT_FALSE(both.is_observable(B(7)));
  for (int i = 0; i < 20; ++i) EXPECT_LT((both.covariance<Pose2>(A(i)) - alone.covariance<Pose2>(A(i))).norm(), 1e-12);
  try {
    both.joint(A(3), B(7));
    FAIL();
  } catch (const UnobservableError& error) {
    EXPECT_EQ(error.keys(), std::vector<Key>{B(7)});
    EXPECT_NE(std::string(error.what()).find("B7"), std::string::npos);
  }
}

TEST(Marginals, FindTheGaugeOfALargeMapFarFromTheOrigin) {
  SmallProblem problem;
  Pose2 x(3e3, -5e3, 1);
  for (int i = 0; i < 3000; ++i, x = x * Pose2(1, 0, 1e-3)) {
    problem.start.insert(A(i), x);
    if (i > 0) problem.graph.add(Between<Pose2>::from_sigmas(Pose2(1, 0, 1e-3), {0.01, 0.01, 0.001}), {A(i - 1), A(i)});
  }
  EXPECT_EQ(Marginals(problem.graph, problem.start).unobservable().size(), 3000u);
  problem.graph.add(Prior<Point2>::from_sigmas(Point2(0, 0), {1, 1}), {L(0)});
  problem.graph.add(Prior<Pose2>::from_sigmas(problem.start.at<Pose2>(A(10)), {1, 1, 1}), {A(10)});
  problem.start.insert(L(0), Point2(0, 0));
  const Marginals tied(problem.graph, problem.start);
  EXPECT_TRUE(tied.unobservable().empty());
  EXPECT_LT((tied.covariance<Pose2>(A(10)) - Matrix<3, 3>::Identity()).norm(), 1e-2);  // rounding: 3e13 m² of lever against a prior of 1
}

TEST(Marginals, TellWhatAFreeDirectionMovesFromWhatItLeaves) {
  Graph graph;  // L1 can turn about L0, which is known
  Values values;
  values.insert(L(0), Point2(1, 2));
  values.insert(L(1), Point2(3, 2));
  graph.add(Prior<Point2>::from_sigmas(Point2(1, 2), {0.1, 0.2}), {L(0)});
  graph.add(Range<Point2, Point2>{2, 0.1}, {L(0), L(1)});
  const Marginals marginals(graph, values);
  EXPECT_EQ(marginals.unobservable(), std::vector<Key>{L(1)});
  EXPECT_NEAR(marginals.covariance<Point2>(L(0))(0, 0), 0.01, 1e-15);
  EXPECT_NEAR(marginals.covariance<Point2>(L(0))(1, 1), 0.04, 1e-15);
  EXPECT_THROW(marginals.covariance(L(1)), UnobservableError);

  graph.fix(L(0));  // a single point with a single range
  EXPECT_THROW(Marginals(graph, values).covariance(L(1)), UnobservableError);
}

TEST(Marginals, CountATermWithoutWeightAsNone) {
  Graph graph;
  Values values;
  values.insert(L(0), Point2(0, 0));
  values.insert(L(1), Point2(9, 9));
  graph.add(Prior<Point2>::from_sigmas(Point2(0, 0), {1, 1}), {L(0)}, Squared{}, 0.0);
  graph.add(Prior<Point2>::from_sigmas(Point2(0, 0), {1, 1}), {L(1)}, TruncatedSquares{3});  // an outlier: ρ' = 0
  EXPECT_EQ(Marginals(graph, values).unobservable(), (std::vector<Key>{L(0), L(1)}));
}

TEST(Marginals, RefuseWhatTheyCannotKnow) {
  SmallProblem walk = random_walk(3, 1, 1);
  walk.start.insert(B(0), Point2(0, 0));
  const Marginals marginals(walk.graph, walk.start);
  EXPECT_THROW(marginals.covariance(B(0)), BadKey);  // no factor touches it
  EXPECT_THROW(marginals.is_observable(B(1)), BadKey);
  EXPECT_THROW(marginals.covariance<Pose2>(A(0)), BadType);
  EXPECT_THROW((marginals.joint<Point2, Point3>(A(0), A(1))), BadType);
  EXPECT_THROW(Marginals(Graph{}, walk.start), BadProblem);
  const SmallProblem ranges = slam<Pose2>(1, 5, 0);
  Values broken = ranges.start;
  broken.at<Pose2>(A(1)).p[0] = NAN;
  EXPECT_THROW(Marginals(ranges.graph, broken), BadNumber);
}

}  // namespace
}  // namespace holdfast::testing
