// Numbers at the edge of what robots meet: sigmas over 12 decades, coordinates of 10⁷ m, turns near and beyond π. Every second-order
// back-end finds the answer; every other one ends no worse than it began.
#include <gtest/gtest.h>

#include "tests/backends.hpp"
#include "tests/problems.hpp"

namespace holdfast::testing {
namespace {

constexpr Agent A('A'), P('P');

bool is_second_order(const std::string& backend) { return backend != "nesterov" && backend != "nesterov-mpi"; }

/// The squared problem on points as a dense one, in long double: what no sparse code has rounded. Returns the cost of its answer.
double least_cost(const Graph& graph, const Values& values) {
  using Dense = Eigen::Matrix<long double, Eigen::Dynamic, Eigen::Dynamic>;
  const Resolved resolved(graph, values);
  Dense J = Dense::Zero(resolved.residual_dim(), resolved.tangent_dim()), r(resolved.residual_dim(), 1);
  int row = 0;
  for (std::size_t b = 0; b < graph.batches().size(); ++b) {
    const FactorBatch& batch = *graph.batches()[b];
    const int m = batch.residual_dim(), n = batch.total_dim();
    std::vector<double> residuals(static_cast<std::size_t>(batch.size() * m)), jacobians(static_cast<std::size_t>(batch.size() * m * n));
    batch.evaluate(values, resolved.batches()[b].index.data(), 0, batch.size(), residuals.data(), jacobians.data());
    for (int i = 0; i < batch.size(); ++i, row += m)
      for (int c = 0; c < m; ++c) {
        const long double root = std::sqrt(batch.weight(i));
        r(row + c) = root * residuals[static_cast<std::size_t>(i * m + c)];
        for (int k = 0, column = 0; k < batch.arity(); ++k)
          for (int d = 0; d < batch.dims()[static_cast<std::size_t>(k)]; ++d, ++column) {
            const int variable = resolved.batches()[b].variable[static_cast<std::size_t>(i * batch.arity() + k)];
            J(row + c, resolved.variables()[static_cast<std::size_t>(variable)].offset + d) =
                root * jacobians[static_cast<std::size_t>((i * n + column) * m + c)];
          }
      }
  }
  const Dense step = J.householderQr().solve(-r);
  return static_cast<double>((r + J * step).squaredNorm() / 2);
}

/// Points, each held and tied by terms whose sigmas are anything from 10⁻⁶ to 10⁶.
SmallProblem sigmas_over_twelve_decades(std::uint64_t seed) {
  std::mt19937_64 rng(seed);
  const auto sigma = [&] { return std::pow(10, uniform(rng, -6, 6)); };
  SmallProblem problem;
  constexpr int kPoints = 30;
  for (int i = 0; i < kPoints; ++i) {
    const Key key = P(static_cast<std::uint64_t>(i));
    problem.start.insert(key, Point2(random_vector<2>(rng, 100)));
    problem.graph.add(Prior<Point2>::from_sigmas(Point2(random_vector<2>(rng, 10)), {sigma(), sigma()}), {key});
    for (int k = 0; k < 3 && i > 0; ++k)
      problem.graph.add(PositionStep<Point2, Point2>{sigma()}, {P(rng() % static_cast<unsigned>(i)), key});
  }
  return problem;
}

class Stress : public ::testing::TestWithParam<std::string> {};

TEST_P(Stress, SigmasOverTwelveDecades) {
  for (std::uint64_t seed = 0; seed < 20; ++seed) {
    const SmallProblem problem = sigmas_over_twelve_decades(seed);
    Values values = problem.start;
    const Summary summary = solve(GetParam(), problem.graph, values);
    ASSERT_TRUE(summary.usable()) << summary.str();
    ASSERT_LE(summary.cost, summary.cost_first);
    if (!is_second_order(GetParam())) continue;
    const double least = least_cost(problem.graph, problem.start);
    EXPECT_NEAR(summary.cost / least, 1, 1e-6) << "seed " << seed << ": " << summary.str();
  }
}

/// A robot that turns by `turn` at each step, with loop closures; the world begins at `origin`. The start is a little off.
template <class V>
SmallProblem walk(double turn, double noise, const Vector<V::space_dim>& origin, std::uint64_t seed) {
  std::mt19937_64 rng(seed);
  Vector<V::dim> step = Vector<V::dim>::Zero();
  step[0] = 1;
  step.template tail<rotation_dim<V::space_dim>>() = turn * random_unit<rotation_dim<V::space_dim>>(rng);
  const V measured = V{}.retract(step);
  SmallProblem problem;
  V x;
  x.p = origin;
  problem.graph.add(Prior<V>::from_sigmas(x, Vector<V::dim>::Constant(0.01)), {A(0)});
  for (unsigned i = 0; i < 40; ++i, x = x * measured) {
    problem.truth.insert(A(i), x);
    const auto tie = [&](unsigned from, const Loss& loss) {
      const V relative = (problem.truth.at<V>(A(from)).inverse() * x).retract(random_vector<V::dim>(rng, noise));
      problem.graph.add(Between<V>::from_sigmas(relative, Vector<V::dim>::Constant(0.1)), {A(from), A(i)}, loss);
    };
    if (i > 0) tie(i - 1, Squared{});
    if (i > 6 && i % 3 == 0) tie(i - 7, Cauchy{3});
  }
  problem.start = perturbed(problem.graph, problem.truth, 0.1, rng);
  return problem;
}

template <class V>
void expect_same_answer_far_away(const std::string& backend) {
  const Vector<V::space_dim> far = Vector<V::space_dim>::Constant(1e7);
  const SmallProblem near_by = walk<V>(0.2, 0.05, Vector<V::space_dim>::Zero(), 1), far_away = walk<V>(0.2, 0.05, far, 1);
  Values here = near_by.start, there = far_away.start;
  ASSERT_TRUE(solve(backend, near_by.graph, here).usable());
  ASSERT_TRUE(solve(backend, far_away.graph, there).usable());
  EXPECT_NEAR(far_away.graph.cost(there), near_by.graph.cost(here), 1e-6 * near_by.graph.cost(here));
  if (!is_second_order(backend)) return;
  for (Key key : here.keys()) EXPECT_LT((there.at<V>(key).p - far - here.at<V>(key).p).norm(), 1e-5) << key;
}

TEST_P(Stress, CoordinatesOfTenMillionMetres) {
  expect_same_answer_far_away<Pose2>(GetParam());
  expect_same_answer_far_away<Pose3>(GetParam());
}

template <class V>
void expect_spinning_robot_is_found(const std::string& backend, double turn) {
  const SmallProblem problem = walk<V>(turn, 0, Vector<V::space_dim>::Zero(), 2);
  Values values = problem.start;
  const Summary summary = solve(backend, problem.graph, values);
  ASSERT_TRUE(summary.usable()) << summary.str();
  EXPECT_LE(summary.cost, summary.cost_first);
  if (is_second_order(backend)) {
    EXPECT_LT(largest_difference(values, problem.truth), 1e-5) << "turn " << turn << ": " << summary.str();
  }
}

TEST_P(Stress, TurnsNearAndBeyondPi) {
  for (const double turn : {3.0, kPi - 1e-6, kPi, kPi + 1e-6, 4.0, 2 * kPi, 100.0}) {
    expect_spinning_robot_is_found<Pose2>(GetParam(), turn);
    expect_spinning_robot_is_found<Pose3>(GetParam(), turn);
  }
}

std::string label(const ::testing::TestParamInfo<std::string>& info) {
  std::string text = info.param;
  std::replace(text.begin(), text.end(), '-', '_');
  return text;
}
INSTANTIATE_TEST_SUITE_P(Backends, Stress, ::testing::ValuesIn(every_backend()), label);

}  // namespace
}  // namespace holdfast::testing
