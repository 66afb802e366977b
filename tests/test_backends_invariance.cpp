// What no back-end may depend on: where the world's origin is, what the variables are called, in which order they come. And what
// every back-end finds when the measurements are exact.
#include <gtest/gtest.h>

#include "tests/backends.hpp"
#include "tests/problems.hpp"

namespace holdfast::testing {
namespace {

class EveryBackend : public ::testing::TestWithParam<std::string> {};

std::string label(const ::testing::TestParamInfo<std::string>& info) {
  std::string text = info.param;
  std::replace(text.begin(), text.end(), '-', '_');
  return text;
}
INSTANTIATE_TEST_SUITE_P(Backends, EveryBackend, ::testing::ValuesIn(every_backend()), label);

template <int Space>
Motion<Space> some_motion() {
  Motion<Space> world;
  world.t = 10 * Vector<Space>::LinSpaced(-1, 2);
  if constexpr (Space == 2)
    world.R = Eigen::Rotation2Dd(1.2).toRotationMatrix();
  else
    world.R = Eigen::AngleAxisd(1.2, Eigen::Vector3d(1, -2, 0.5).normalized()).toRotationMatrix();
  return world;
}

template <class V, class Point>
Values moved_values(const Motion<V::space_dim>& world, const Values& values) {
  Values out;
  for (Key key : values.keys()) {
    if (values.contains<V>(key)) out.insert(key, moved(world, values.at<V>(key)));
    if (values.contains<Point>(key)) out.insert(key, moved(world, values.at<Point>(key)));
  }
  return out;
}

/// The problem of problems.hpp knows the world by its one prior only.
template <class V>
Graph moved_graph(const Motion<V::space_dim>& world, const Graph& graph) {
  Graph out = graph;
  for (std::size_t b = 0; b < out.batches().size(); ++b) {
    if (out.batches()[b]->factor_type() != typeid(Prior<V>)) continue;
    Prior<V>& prior = out.at<Prior<V>>(out.id_of(static_cast<int>(b), 0));
    prior.mean = moved(world, prior.mean);
  }
  return out;
}

template <class V>
void expect_shift_changes_nothing(const std::string& backend) {
  using Point = std::conditional_t<V::space_dim == 2, Point2, Point3>;
  const auto problem = slam<V>(1, 8, 0.1, Huber{2});
  const Motion<V::space_dim> world = some_motion<V::space_dim>();
  const Graph there = moved_graph<V>(world, problem.graph);
  Values here = problem.start, shifted = moved_values<V, Point>(world, problem.start);
  EXPECT_NEAR(there.cost(shifted), problem.graph.cost(here), 1e-9 * problem.graph.cost(here));
  ASSERT_TRUE(solve(backend, problem.graph, here).usable());
  ASSERT_TRUE(solve(backend, there, shifted).usable());
  EXPECT_NEAR(there.cost(shifted), problem.graph.cost(here), 1e-7 * problem.graph.cost(here));
  EXPECT_LT(largest_difference(moved_values<V, Point>(world, here), shifted), 1e-4);
}

TEST_P(EveryBackend, AnswersAShiftedWorldWithTheShiftedAnswer) {
  expect_shift_changes_nothing<Pose2>(GetParam());
  expect_shift_changes_nothing<Pose3>(GetParam());
}

TEST_P(EveryBackend, AnswersATranslatedWorldWithTheTranslatedAnswer) {  // bearings in the world frame, motion models
  constexpr Agent T('T');
  const auto problem = tracking<Motion3>(2, 12, 0.1, Huber{2});
  Motion<3> world{Matrix<3, 3>::Identity(), Vector<3>(100, -50, 25)};
  Graph there = problem.graph;
  for (std::size_t b = 0; b < there.batches().size(); ++b)
    for (int i = 0; i < there.batches()[b]->size(); ++i)
      if (there.batches()[b]->factor_type() == typeid(HuberMeasurement<Motion3>))
        there.at<HuberMeasurement<Motion3>>(there.id_of(static_cast<int>(b), i)).known += world.t;
  Values here = problem.start, shifted;
  for (Key key : here.keys()) shifted.insert(key, moved(world, here.at<Motion3>(key)));
  ASSERT_TRUE(solve(GetParam(), problem.graph, here).usable());
  ASSERT_TRUE(solve(GetParam(), there, shifted).usable());
  EXPECT_NEAR(there.cost(shifted), problem.graph.cost(here), 1e-6 * problem.graph.cost(here));
  EXPECT_LT((shifted.at<Motion3>(T(5)).position() - here.at<Motion3>(T(5)).position() - world.t).norm(), 1e-2);
}

Key renamed(Key key) { return {static_cast<char>('a' + 'Z' - key.kind()), 1000 - 7 * key.index()}; }

/// The same factors, last first, on the new names.
template <class V>
Graph renamed_graph(const Graph& graph) {
  using Point = std::conditional_t<V::space_dim == 2, Point2, Point3>;
  Graph out;
  const auto copy = [&](auto tag) {
    using F = typename decltype(tag)::type;
    graph.for_each_batch<F>([&](const Batch<F>& batch) {
      for (int i = batch.size() - 1; i >= 0; --i) {
        std::array<Key, F::Variables::size> keys;
        for (int k = 0; k < batch.arity(); ++k) keys[k] = renamed(batch.keys(i)[k]);
        out.add(batch.factors()[i], keys, batch.loss(i), batch.weight(i));
      }
    });
  };
  const auto all = [&](auto... tags) { (copy(tags), ...); };
  all(std::common_type<VonMisesBearingBody<V, Point>>{}, std::common_type<Range<V, Point>>{}, std::common_type<RelativePoint<V, Point>>{},
      std::common_type<Between<V>>{}, std::common_type<Prior<V>>{});
  return out;
}

template <class V>
void expect_names_do_not_matter(const std::string& backend) {
  using Point = std::conditional_t<V::space_dim == 2, Point2, Point3>;
  const auto problem = slam<V>(3, 9, 0.1, Cauchy{3});
  const Graph other = renamed_graph<V>(problem.graph);
  ASSERT_EQ(other.size(), problem.graph.size());
  Values here = problem.start, there, expected;
  std::vector<Key> keys = here.keys();
  std::reverse(keys.begin(), keys.end());
  for (Key key : keys) {
    if (here.contains<V>(key)) there.insert(renamed(key), here.at<V>(key));
    if (here.contains<Point>(key)) there.insert(renamed(key), here.at<Point>(key));
  }
  EXPECT_NEAR(other.cost(there), problem.graph.cost(here), 1e-12 * other.cost(there));
  ASSERT_TRUE(solve(backend, problem.graph, here).usable());
  ASSERT_TRUE(solve(backend, other, there).usable());
  EXPECT_NEAR(other.cost(there), problem.graph.cost(here), 1e-7 * other.cost(there));
  for (Key key : keys) {
    if (here.contains<V>(key)) expected.insert(renamed(key), here.at<V>(key));
    if (here.contains<Point>(key)) expected.insert(renamed(key), here.at<Point>(key));
  }
  EXPECT_LT(largest_difference(expected, there), 1e-4);
}

TEST_P(EveryBackend, DoesNotCareForNamesAndOrder) {
  expect_names_do_not_matter<Pose2>(GetParam());
  expect_names_do_not_matter<Pose3>(GetParam());
}

TEST_P(EveryBackend, RecoversTheTruthFromExactMeasurements) {
  for (const std::uint64_t seed : {4, 5, 6}) {
    const auto expect_truth = [&](const SmallProblem& problem) {
      Values values = problem.start;
      const double first = problem.graph.cost(values);
      ASSERT_TRUE(solve(GetParam(), problem.graph, values).usable());
      EXPECT_LT(problem.graph.cost(values), 1e-9 * first);
      EXPECT_LT(largest_difference(problem.truth, values), 1e-4);
    };
    for (const Loss& loss : {Loss(Squared{}), Loss(Huber{2}), Loss(Cauchy{2})}) {
      SCOPED_TRACE(loss.str() + " seed " + std::to_string(seed));
      expect_truth(slam<Pose2>(seed, 9, 0, loss));
      expect_truth(slam<Pose3>(seed, 9, 0, loss));
      expect_truth(tracking<Motion2>(seed, 12, 0, loss));
    }
  }
}

TEST_P(EveryBackend, StaysWhereItIsAtTheTruth) {
  const auto problem = slam<Pose3>(7, 9, 0);
  Values values = problem.truth;
  const Summary summary = solve(GetParam(), problem.graph, values);
  EXPECT_EQ(summary.termination, Termination::converged) << summary.str();
  EXPECT_LT(largest_difference(problem.truth, values), 1e-9);
}

TEST_P(EveryBackend, LeavesFixedVariablesBitByBit) {
  auto problem = slam<Pose3>(8, 9, 0.1, Huber{2});
  const Key fixed[] = {Key('A', 2), Key('L', 1)};
  for (Key key : fixed) problem.graph.fix(key);
  Values values = problem.start;
  ASSERT_TRUE(solve(GetParam(), problem.graph, values).usable());
  EXPECT_EQ(std::memcmp(&values.at<Pose3>(fixed[0]), &problem.start.at<Pose3>(fixed[0]), sizeof(Pose3)), 0);
  EXPECT_EQ(values.at<Point3>(fixed[1]).value, problem.start.at<Point3>(fixed[1]).value);
  EXPECT_LT(problem.graph.cost(values), problem.graph.cost(problem.start));
}

TEST_P(EveryBackend, LeavesStrangersAlone) {
  const auto problem = slam<Pose2>(9, 6, 0.1);
  Values values = problem.start;
  values.insert(Key('Z', 0), Motion3(1, 2, 3, 4, 5, 6));  // in no factor
  ASSERT_TRUE(solve(GetParam(), problem.graph, values).usable());
  EXPECT_EQ(values.at<Motion3>(Key('Z', 0)).value, (Motion3(1, 2, 3, 4, 5, 6)).value);
}

TEST_P(EveryBackend, FindsTheOneOptimumOfConvexProblems) {
  for (const Loss& loss : {Loss(Squared{}), Loss(Huber{1}), per_component(Huber{2}), Loss(PseudoHuber{1})})
    for (const std::uint64_t seed : {1, 2}) {
      SCOPED_TRACE(loss.str() + " seed " + std::to_string(seed));
      const auto expect_least = [&](const SmallProblem& problem) {
        Values values = problem.start, reference = problem.truth;  // another start, another method
        ASSERT_TRUE(solve("irls", problem.graph, reference).usable());
        const Summary summary = solve(GetParam(), problem.graph, values);
        ASSERT_TRUE(summary.usable()) << summary.str();
        const double least = problem.graph.cost(reference);
        EXPECT_NEAR(problem.graph.cost(values), least, 1e-6 * least) << summary.str();
      };
      expect_least(range_balls<Point2>(seed, 8, loss));
      expect_least(range_balls<Point3>(seed, 8, loss));
      expect_least(tracking<Motion2>(seed, 25, 0.3, loss));
      expect_least(tracking<Motion3>(seed, 25, 0.3, loss));
    }
}

}  // namespace
}  // namespace holdfast::testing
