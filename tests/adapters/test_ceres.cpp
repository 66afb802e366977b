// Our factors in a user's ceres::Problem: memory layouts, manifolds, and losses that Ceres has not.
#include <ceres/ceres.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <holdfast/adapters/ceres/ceres.hpp>

#include "tests/problems.hpp"

namespace holdfast::testing {
namespace {

using ::testing::HasSubstr;
constexpr Agent A('A'), L('L');

template <class Throwing>
std::string message_of(const Throwing& call) {
  try {
    call();
  } catch (const BadOption& error) {
    return error.what();
  }
  return "";
}

// ---- layouts

/// A variable in a user's memory, each number moved off the manifold a little: Jacobians must hold there, too.
template <class Layout>
std::vector<double> somewhere(std::mt19937_64& rng) {
  std::vector<double> x(layout_size<Layout>);
  Layout::write(random_variable<typename Layout::Variable>(rng), x.data());
  for (double& number : x) number += uniform(rng, -0.05, 0.05);
  return x;
}

/// The cost function's residual is the factor's, and its Jacobian d r / d (every number of the user's) is the numeric one.
template <class... Layouts, class F>
void expect_exact_in(const F& factor, std::uint64_t seed) {
  std::mt19937_64 rng(seed);
  const std::unique_ptr<ceres::CostFunction> cost(ceres_cost<Layouts...>(factor));
  for (int repeat = 0; repeat < 20; ++repeat) {
    std::vector<std::vector<double>> memory{somewhere<Layouts>(rng)...};
    std::vector<double*> blocks;
    std::size_t k = 0;
    (
        [&] {
          double* next = memory[k++].data();
          for (int size : block_layout<Layouts>().blocks) blocks.push_back(std::exchange(next, next + size));
        }(),
        ...);
    ASSERT_EQ(cost->parameter_block_sizes().size(), blocks.size());

    const int m = F::residual_dim;
    Vector<F::residual_dim> r, above, below;
    std::vector<Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>> J;
    std::vector<double*> jacobians;
    for (int size : cost->parameter_block_sizes()) J.emplace_back(m, size);
    for (auto& block : J) jacobians.push_back(block.data());
    ASSERT_TRUE(cost->Evaluate(blocks.data(), r.data(), jacobians.data()));
    auto next = memory.begin();
    const auto read_next = [&](auto layout) { return decltype(layout)::read((next++)->data()); };
    const std::tuple<typename Layouts::Variable...> x{read_next(Layouts{})...};
    EXPECT_LT((r - std::apply(factor, std::tuple_cat(x, std::make_tuple(nullptr)))).norm(), 1e-12 * (1 + r.norm()));
    for (std::size_t b = 0; b < blocks.size(); ++b)
      for (int c = 0; c < J[b].cols(); ++c) {
        const double at = blocks[b][c], h = 1e-5;
        blocks[b][c] = at + h;
        cost->Evaluate(blocks.data(), above.data(), nullptr);
        blocks[b][c] = at - h;
        cost->Evaluate(blocks.data(), below.data(), nullptr);
        blocks[b][c] = at;
        EXPECT_LT(((above - below) / (2 * h) - J[b].col(c)).norm(), 1e-6 * (1 + J[b].norm())) << "block " << b << " number " << c;
      }
  }
}

const auto kBetween2 = Between<Pose2>::from_sigmas(Pose2(1, 0.5, 0.3), Vector<3>(0.5, 0.4, 0.2));
const auto kBetween3 =
    Between<Pose3>::from_sigmas(Pose3().retract(Vector<6>(1, 2, 3, 0.1, -0.2, 0.3)), Vector<6>(0.5, 0.4, 0.6, 0.2, 0.3, 0.2));
constexpr auto xyzw = QuaternionOrder::xyzw, wxyz = QuaternionOrder::wxyz;

TEST(CeresLayouts, JacobiansAreExactInTheUsersNumbers) {
  expect_exact_in<Own<Pose2>, PositionYaw>(kBetween2, 1);
  expect_exact_in<Separate<PositionYaw>, Separate<Own<Pose2>>>(kBetween2, 2);
  expect_exact_in<EachNumber<PositionYaw>, EachNumber<Own<Pose2>>>(kBetween2, 2);
  expect_exact_in<Own<Pose3>, PositionQuaternion<wxyz>>(kBetween3, 3);
  expect_exact_in<QuaternionPosition<xyzw>, QuaternionPosition<wxyz>>(kBetween3, 4);
  expect_exact_in<Separate<PositionQuaternion<wxyz>>, Separate<QuaternionPosition<xyzw>>>(kBetween3, 5);
  expect_exact_in<PositionYaw, Own<Point2>>(Range<Pose2, Point2>{3, 0.5}, 6);
  expect_exact_in<PositionYaw, Separate<ByDerivative<Motion2>>>(Range<Pose2, Motion2>{3, 0.5}, 7);
  expect_exact_in<ByDerivative<Motion3>, Own<Motion3>>(WhiteAcceleration<Motion3>::continuous(0.5, 0.3), 8);
}

TEST(CeresLayouts, EachHoldsWhatItWasGiven) {
  std::mt19937_64 rng(9);
  const Pose3 pose = random_variable<Pose3>(rng);
  double x[7];
  QuaternionPosition<wxyz>::write(pose, x);
  EXPECT_EQ(x[0], pose.q.w());
  EXPECT_EQ(x[4], pose.p[0]);
  EXPECT_LT(pose.local(QuaternionPosition<wxyz>::read(x)).norm(), 1e-15);
  ByDerivative<Motion2>::write(Motion2(1, 2, 3, 4), x);  // px vx py vy
  EXPECT_EQ((std::vector<double>{x[0], x[1], x[2], x[3]}), (std::vector<double>{1, 3, 2, 4}));
}

/// As Ceres' own pose_graph_2d keeps its poses.
TEST(CeresLayouts, ThreeNumbersAreThreeBlocks) {
  double x = 0, y = 0, yaw = 0.5, beacon[2] = {3, 4};
  ceres::Problem problem;
  ceres_add<EachNumber<PositionYaw>, Own<Point2>>(problem, Range<Pose2, Point2>{4, 0.5}, Squared{}, {&x, &y, &yaw, beacon});
  EXPECT_EQ(problem.NumParameterBlocks(), 4);
  double cost = 0;
  problem.Evaluate({}, &cost, nullptr, nullptr, nullptr);
  EXPECT_DOUBLE_EQ(cost, 0.5 * 4);  // (5 − 4) / 0.5
}

template <class Layout>
void expect_manifold() {
  const std::unique_ptr<ceres::Manifold> manifold(ceres_manifold<Layout>());
  std::mt19937_64 rng(10);
  using V = typename Layout::Variable;
  constexpr int size = layout_size<Layout>;
  for (int repeat = 0; repeat < 20; ++repeat) {
    double x[size], y[size], back[V::dim];
    const V v = random_variable<V>(rng);
    Vector<V::dim> delta = random_vector<V::dim>(rng, 0.3);
    Layout::write(v, x);
    ASSERT_TRUE(manifold->Plus(x, delta.data(), y));
    EXPECT_LT(v.retract(delta).local(Layout::read(y)).norm(), 1e-14);
    ASSERT_TRUE(manifold->Minus(y, x, back));
    EXPECT_LT((Eigen::Map<Vector<V::dim>>(back) - delta).norm(), 1e-13);
    Eigen::Matrix<double, size, V::dim, size == 1 ? Eigen::ColMajor : Eigen::RowMajor> P, numeric;
    Eigen::Matrix<double, V::dim, size, Eigen::RowMajor> M;
    manifold->PlusJacobian(x, P.data());
    manifold->MinusJacobian(x, M.data());
    EXPECT_LT((M * P - Eigen::Matrix<double, V::dim, V::dim>::Identity()).norm(), 1e-13);
    for (int c = 0; c < V::dim; ++c) {
      double above[size], below[size];
      manifold->Plus(x, Vector<V::dim>(1e-5 * Vector<V::dim>::Unit(c)).data(), above);
      manifold->Plus(x, Vector<V::dim>(-1e-5 * Vector<V::dim>::Unit(c)).data(), below);
      for (int i = 0; i < size; ++i) EXPECT_NEAR((above[i] - below[i]) / 2e-5, P(i, c), 1e-9);
    }
  }
}

TEST(CeresManifold, IsTheRetractionOfTheVariable) {
  expect_manifold<Own<Pose2>>();
  expect_manifold<PositionYaw>();
  expect_manifold<Own<Pose3>>();
  expect_manifold<QuaternionPosition<wxyz>>();
  expect_manifold<ByDerivative<Motion3>>();
}

TEST(CeresManifold, OfSeparateBlocksThereIsNone) {
  EXPECT_THAT(message_of([] { ceres_manifold<Separate<PositionQuaternion<>>>(); }), HasSubstr("2 blocks"));
}

// ---- losses

TEST(CeresLoss, WhatCeresCannotHoldIsRefusedByName) {
  EXPECT_THAT(message_of([] { ceres_loss(per_component(Huber{2}), 3); }), HasSubstr("huber:2:component"));
  EXPECT_THAT(message_of([] { ceres_loss(one_sided(Cauchy{1}), 1); }), HasSubstr("ceres_cost(factor, loss)"));
  EXPECT_THAT(message_of([] { ceres_loss(StudentT{3}); }), HasSubstr("how many components"));
  EXPECT_THAT(message_of([] { ceres_loss(per_component(Huber{2})); }), HasSubstr("how many components"));
  EXPECT_THAT(message_of([] { ceres_cost(kBetween2, Huber{2}); }), HasSubstr("Between"));
  EXPECT_EQ(ceres_loss(Squared{}), nullptr);
}

TEST(CeresLoss, MissingBlocksAreCounted) {
  ceres::Problem problem;
  double pose[4];
  EXPECT_THAT(message_of([&] { ceres_add(problem, kBetween2, {pose}); }), HasSubstr("2 blocks"));
}

// ---- a problem of the user's own: quaternions wxyz in blocks of their own, poses as [x y θ], theirs and ours side by side

TEST(CeresProblem, ReachesTheSameOptimumOnTheUsersMemory) {
  const auto problem = slam<Pose3>(3, 8, 0.2, Cauchy{2}, 0.1);
  Values answer = problem.start;
  ASSERT_TRUE(solve("irls", problem.graph, answer).usable());

  std::map<Key, std::array<double, 3>> position;
  std::map<Key, std::array<double, 4>> quaternion;
  ceres::Problem user;
  for (Key key : problem.start.keys()) {
    if (problem.start.contains<Pose3>(key)) {
      double x[7];
      PositionQuaternion<wxyz>::write(problem.start.at<Pose3>(key), x);
      std::copy_n(x + 3, 4, quaternion[key].begin());
      user.AddParameterBlock(quaternion[key].data(), 4, new ceres::QuaternionManifold);
      std::copy_n(x, 3, position[key].begin());
    } else {
      Own<Point3>::write(problem.start.at<Point3>(key), position[key].data());
    }
    user.AddParameterBlock(position[key].data(), 3);
  }
  using Pose = Separate<PositionQuaternion<wxyz>>;
  const auto blocks = [&](const Key* keys) {
    std::vector<double*> all;
    for (int k = 0; k < 2; ++k) {
      all.push_back(position[keys[k]].data());
      if (quaternion.count(keys[k]) != 0) all.push_back(quaternion[keys[k]].data());
    }
    return all;
  };
  const auto add_all = [&](const auto& batch, auto add) {
    for (int i = 0; i < batch.size(); ++i) add(batch.factors()[i], batch.loss(i), batch.keys(i));
  };
  problem.graph.for_each_batch<Between<Pose3>>([&](const auto& batch) {
    add_all(batch, [&](const auto& f, const Loss& loss, const Key* keys) { ceres_add<Pose, Pose>(user, f, loss, blocks(keys)); });
  });
  const auto add_landmarks = [&](const auto& batch) {
    add_all(batch, [&](const auto& f, const Loss& loss, const Key* keys) { ceres_add<Pose, Own<Point3>>(user, f, loss, blocks(keys)); });
  };
  problem.graph.for_each_batch<Range<Pose3, Point3>>(add_landmarks);
  problem.graph.for_each_batch<RelativePoint<Pose3, Point3>>(add_landmarks);
  problem.graph.for_each_batch<VonMisesBearingBody<Pose3, Point3>>(add_landmarks);
  problem.graph.for_each_batch<Prior<Pose3>>([&](const auto& batch) {
    ceres_add<Pose>(user, batch.factors()[0], batch.loss(0), {position[A(0)].data(), quaternion[A(0)].data()});
  });

  ceres::Solver::Options options;
  options.max_num_iterations = 500;
  options.function_tolerance = options.gradient_tolerance = options.parameter_tolerance = 1e-15;
  options.logging_type = ceres::SILENT;
  ceres::Solver::Summary summary;
  ceres::Solve(options, &user, &summary);
  const double best = problem.graph.cost(answer);
  EXPECT_NEAR(summary.final_cost, best, 1e-9 * best);
  Values theirs = answer;
  for (Key key : answer.keys())
    if (answer.contains<Pose3>(key))
      theirs.update(key, Pose3(Vector<3>(Eigen::Map<Vector<3>>(position[key].data())),
                               so3::Quaternion<double>(quaternion[key][0], quaternion[key][1], quaternion[key][2], quaternion[key][3])));
    else
      theirs.update(key, Point3(position[key][0], position[key][1], position[key][2]));
  EXPECT_LT(largest_difference(answer, theirs), 1e-4);
}

}  // namespace
}  // namespace holdfast::testing
