// Our factors in GTSAM's graphs, its optimizers as back-ends, and iSAM2.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <gtsam/inference/LabeledSymbol.h>
#include <gtsam/inference/Symbol.h>
#include <gtsam/nonlinear/ISAM2.h>
#include <gtsam/nonlinear/PriorFactor.h>
#include <gtsam/slam/BetweenFactor.h>

#include <holdfast/adapters/files/problem.hpp>
#include <holdfast/adapters/gtsam/backend.hpp>
#include <holdfast/adapters/gtsam/graph.hpp>
#include <holdfast/graph/files/files.hpp>

#include "tests/adapters/data_files.hpp"
#include "tests/problems.hpp"

namespace holdfast::testing {
namespace {

using ::testing::HasSubstr;
constexpr Agent A('A'), X('x');

TEST(GtsamValues, GoInAndComeOut) {
  Values values;
  const gtsam::Pose3 pose(gtsam::Rot3::Ypr(0.3, -0.4, 0.5), gtsam::Point3(1, 2, 3));
  values.insert(A(3), pose);
  values.insert(A(4), gtsam::Pose2(1, 2, 3));
  values.insert(A(5), gtsam::Point2(5, 6));
  EXPECT_TRUE(values.at<gtsam::Pose3>(A(3)).equals(pose, 1e-14));
  EXPECT_NEAR(values.at<Pose2>(A(4)).angle(), 3, 1e-15);
  const gtsam::Values theirs = to_gtsam(values);
  EXPECT_TRUE(theirs.at<gtsam::Pose3>(gtsam::Symbol('A', 3)).equals(pose, 1e-14));
  const Values back = from_gtsam(theirs);
  EXPECT_LT(largest_difference(values, back), 1e-14);
  gtsam::Values twofold;
  twofold.insert(gtsam::Symbol('m', 1), gtsam::Vector6(gtsam::Vector6::Zero()));
  EXPECT_THROW(from_gtsam(twofold), BadType);
}

TEST(GtsamKeys, AreTheSameBits) {
  const gtsam::Key symbol = gtsam::Symbol('r', 7), labeled = gtsam::LabeledSymbol('x', 'B', 12);
  EXPECT_EQ(holdfast_key(symbol), Key('r', 7));
  EXPECT_EQ(holdfast_key(labeled), Agent('x', 'B' << 16)(12));
  EXPECT_EQ(gtsam::LabeledSymbol(gtsam_key(Agent('x', 'B' << 16)(12))).label(), 'B');
  for (const gtsam::Key key : {symbol, labeled, gtsam::Key(5), ~gtsam::Key(0)}) EXPECT_EQ(gtsam_key(holdfast_key(key)), key);
}

/// The Jacobian is with respect to GTSAM's own retract.
template <class V>
void expect_tangent() {
  using G = GtsamVariable<V>;
  std::mt19937_64 rng(1);
  for (int i = 0; i < 20; ++i) {
    const V x = random_variable<V>(rng);
    const auto theirs = G::theirs(x);
    for (int c = 0; c < V::dim; ++c) {
      const Eigen::VectorXd step = 1e-6 * Eigen::VectorXd::Unit(V::dim, c);
      const V up = G::ours(gtsam::traits<typename G::type>::Retract(theirs, step));
      const V down = G::ours(gtsam::traits<typename G::type>::Retract(theirs, -step));
      EXPECT_LT(((x.local(up) - x.local(down)) / 2e-6 - G::tangent(x).col(c)).norm(), 1e-7);
    }
  }
}
TEST(GtsamVariable, TangentIsGtsams) {
  expect_tangent<Pose2>();
  expect_tangent<Pose3>();
  expect_tangent<Motion3>();
}

TEST(GtsamFactor, DefaultLossAndWeightAreTheFactorsOwn) {
  const auto measurement = HuberMeasurement<Point2>::of_position({9, 1}, {0, 0}, Matrix<2, 2>::Identity(), 0.5);
  gtsam::Values values;
  values.insert(7, gtsam::Point2(0, 0));
  Graph graph;
  graph.add(measurement, {holdfast_key(7)});
  EXPECT_NEAR(gtsam_factor(measurement, {7})->error(values), graph.cost(from_gtsam(values)), 1e-12);
}

template <class Problem>
void expect_same_optimum(const Problem& problem) {
  Values ours = problem.start;
  ASSERT_TRUE(solve("irls", problem.graph, ours).usable());
  for (const char* backend : {"gtsam-lm", "gtsam-gn"}) {
    SCOPED_TRACE(backend);
    Values theirs = problem.start;
    const Summary summary = solve(backend, problem.graph, theirs);
    ASSERT_TRUE(summary.usable()) << summary.str();
    const double cost = problem.graph.cost(ours);
    EXPECT_NEAR(problem.graph.cost(theirs), cost, 1e-7 * cost);
    EXPECT_NEAR(summary.cost, problem.graph.cost(theirs), 1e-12 * cost);
  }
}

TEST(GtsamBackend, ReachesTheSameOptimum) {
  register_gtsam_backends();
  expect_same_optimum(slam<Pose2>(3, 12, 0.1, Cauchy{2}, 0.05));
  expect_same_optimum(slam<Pose3>(4, 12, 0.1, per_component(Huber{2}), 0.05));
  auto fixed = slam<Pose3>(5, 10, 0.1, Huber{2}, 0.05);
  fixed.graph.fix(A(0));
  fixed.graph.fix(Key('L', 1));
  expect_same_optimum(fixed);
  expect_same_optimum(tracking<Motion2>(6, 12, 0.1, per_component(Huber{2})));
}

TEST(GtsamBackend, SaysWhyItFails) {
  register_gtsam_backends();
  Graph graph;
  graph.add(Between<Point2>::from_sigmas(Point2(1, 0), Vector<2>(0.1, 0.1)), {A(0), A(1)});  // free gauge
  Values values;
  values.insert(A(0), Point2(0, 0));
  values.insert(A(1), Point2(0, 1));
  const Values before = values;
  const Summary summary = make_backend("gtsam-gn")->solve(graph, values);
  EXPECT_EQ(summary.termination, Termination::failed);
  EXPECT_TRUE(same_bits(before, values));
}

TEST(GtsamIsam2, AddsOurFactorsStepByStep) {
  const auto problem = slam<Pose2>(7, 12, 0.05, Huber{2}, 0.02);
  gtsam::ISAM2Params params;
  params.relinearizeThreshold = 1e-6;
  params.relinearizeSkip = 1;
  gtsam::ISAM2 isam(params);
  const gtsam::NonlinearFactorGraph all = to_gtsam(problem.graph, problem.start);
  const gtsam::Values start = to_gtsam(problem.start);
  std::set<gtsam::Key> known;
  std::vector<bool> added(all.size());
  for (int k = 0; k < 12; ++k) {  // a pose, the landmark it sees, and every factor whose variables are there
    gtsam::NonlinearFactorGraph factors;
    gtsam::Values values;
    for (const gtsam::Key key : {gtsam_key(A(k)), gtsam_key(Key('L', k % 3))})
      if (known.insert(key).second) values.insert(key, start.at(key));
    for (std::size_t f = 0; f < all.size(); ++f)
      if (!added[f] && std::all_of(all[f]->begin(), all[f]->end(), [&](gtsam::Key key) { return known.count(key) != 0; })) {
        added[f] = true;
        factors.push_back(all[f]);
      }
    isam.update(factors, values);
  }
  for (int i = 0; i < 30; ++i) isam.update();
  Values ours = problem.start, theirs = problem.start;
  solve("irls", problem.graph, ours);
  write_back(isam.calculateBestEstimate(), theirs);
  const double cost = problem.graph.cost(ours);
  EXPECT_NEAR(problem.graph.cost(theirs), cost, 1e-5 * cost);
}

TEST(GtsamGraph, NativePoseFactorsBecomeOurs) {
  gtsam::NonlinearFactorGraph theirs;
  std::mt19937_64 rng(8);
  const gtsam::Pose3 measured(gtsam::Rot3::Ypr(0.3, 0.2, 0.1), gtsam::Point3(1, 2, 3));
  const gtsam::Matrix66 cov = random_covariance<6>(rng);
  theirs.emplace_shared<gtsam::BetweenFactor<gtsam::Pose3>>(1, 2, measured, gtsam::noiseModel::Gaussian::Covariance(cov));
  theirs.emplace_shared<gtsam::PriorFactor<gtsam::Pose3>>(1, measured, gtsam::noiseModel::Gaussian::Covariance(cov));
  const gtsam::Matrix33 cov2 = random_covariance<3>(rng);
  theirs.emplace_shared<gtsam::BetweenFactor<gtsam::Pose2>>(3, 4, gtsam::Pose2(1, 2, 0.3), gtsam::noiseModel::Gaussian::Covariance(cov2));
  const Graph ours = from_gtsam(theirs);
  gtsam::Values values;
  values.insert(1, measured.retract(1e-4 * gtsam::Vector6::Random()));
  values.insert(2, values.at<gtsam::Pose3>(1) * measured.retract(1e-4 * gtsam::Vector6::Random()));
  values.insert(3, gtsam::Pose2(1, 1, 1));
  values.insert(4, gtsam::Pose2(3, 1, 2.5));  // far off: in the plane it is exact
  EXPECT_NEAR(ours.cost(from_gtsam(values)) / theirs.error(values), 1, 1e-9);
  theirs.emplace_shared<gtsam::BetweenFactor<gtsam::Point2>>(5, 6, gtsam::Point2(1, 2), gtsam::noiseModel::Unit::Create(2));
  EXPECT_THROW(from_gtsam(theirs), BadOption);
}

TEST(GtsamGraph, EveryFileGoesThereAndBack) {
  const std::vector<std::string> files = data_files();
  if (files.empty()) GTEST_SKIP() << kNoFiles;
  for (const std::string& file : files) {
    SCOPED_TRACE(file);
    const Problem problem = make_problem(read_dataset(file), {Huber{2}});
    const Graph back = from_gtsam(to_gtsam(problem.graph, problem.start));
    const Values values = from_gtsam(to_gtsam(problem.start));
    EXPECT_EQ(back.size(), problem.graph.size());
    EXPECT_EQ(back.fixed(), problem.graph.fixed());
    EXPECT_EQ(values.keys(), problem.start.keys());
    const double cost = problem.graph.cost(problem.start);
    EXPECT_NEAR(back.cost(problem.start), cost, 1e-12 * cost);
    EXPECT_NEAR(back.cost(values), cost, 1e-9 * cost);
  }
}

}  // namespace
}  // namespace holdfast::testing
