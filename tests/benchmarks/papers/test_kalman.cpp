// The filters that the papers' systems stand on: Kalman's, and several of them interacting.
#include <gtest/gtest.h>

#include <Eigen/LU>
#include <holdfast/benchmarks/papers/imm.hpp>
#include <holdfast/benchmarks/scenarios/random.hpp>
#include <holdfast/factors/huber_measurement.hpp>
#include <holdfast/factors/prior.hpp>
#include <holdfast/factors/white_acceleration.hpp>
#include <holdfast/solvers/marginals.hpp>
#include <holdfast/solvers/table.hpp>

namespace holdfast::bench {
namespace {

using Square = Matrix<4, 4>;
constexpr double kStep = 0.1;  // [s]
const Matrix<2, 4> H = Motion2::position_jacobian();
const Matrix<2, 2> R = (Matrix<2, 2>() << 0.5, 0.1, 0.1, 0.8).finished();

Square process_noise() {
  const auto W = WhiteAcceleration<Motion2>::continuous(kStep, 2).sqrt_information;
  return (W.transpose() * W).inverse();
}
Gaussian<4> first_state() { return {Vector<4>(1, 2, 3, -1), Square::Identity() * 4}; }

std::vector<Vector<2>> measurements(int count) {
  Random random(5);
  std::vector<Vector<2>> z;
  for (int k = 0; k < count; ++k) z.push_back(Vector<2>(0.3 * k, 3 - 0.1 * k) + random.normals<2>(0.8));
  return z;
}

Filtered<4> filtered(const Gaussian<4>& before, const Vector<2>& z, const Square& F, const Square& Q) {
  const Gaussian<4> prior = predicted(before, F, Q);
  const Innovation<2> innovation{z - H * prior.mean, innovation_covariance(prior.covariance, H, R)};
  return {corrected(prior, innovation, H, R), innovation.log_likelihood()};
}

// By hand: P = 3, R = 1, z = 2: K = 3/4, x = 1.5, P = 3/4; ln N(2; 0, 4) = −½ (1 + ln 8π).
TEST(Kalman, OneNumberByHand) {
  const Gaussian<1> prior{Vector<1>(0), Matrix<1, 1>(3)};
  const Matrix<1, 1> one(1);
  const Innovation<1> innovation{Vector<1>(2), innovation_covariance(prior.covariance, one, one)};
  const Gaussian<1> posterior = corrected(prior, innovation, one, one);
  EXPECT_NEAR(posterior.mean[0], 1.5, 1e-15);
  EXPECT_NEAR(posterior.covariance(0, 0), 0.75, 1e-15);
  EXPECT_NEAR(innovation.normalized_squared(), 1, 1e-15);
  EXPECT_NEAR(innovation.log_likelihood(), -0.5 * (1 + std::log(8 * kPi)), 1e-14);
}

// The whitening of a prior asks for it, and rounding alone would not give it after a first guess of a kilometre.
TEST(Kalman, CovarianceIsSymmetricToTheLastBit) {
  Gaussian<4> state{Vector<4>::Zero(), Vector<4>(1e6, 400, 1e6, 400).asDiagonal()};
  for (const Vector<2>& z : measurements(20)) {
    state = corrected(predicted(state, transition<Motion2>(kStep), process_noise()), z, H, R);
    EXPECT_EQ(state.covariance, state.covariance.transpose().eval());
  }
}

TEST(Kalman, IsTheBatchSolutionOfTheGraphOnAGaussianChain) {
  constexpr Agent A('A');
  constexpr int kStates = 40;
  const auto motion = WhiteAcceleration<Motion2>::continuous(kStep, 2);
  const std::vector<Vector<2>> z = measurements(kStates);
  Gaussian<4> state = corrected(first_state(), z[0], H, R);
  Graph graph;
  Values values;
  graph.add(Prior<Motion2>::from_covariance(Motion2(first_state().mean), first_state().covariance), {A(0)});
  for (int k = 0; k < kStates; ++k) {
    values.insert(A(k), Motion2());
    graph.add(HuberMeasurement<Motion2>::of_position(-z[k], Vector<2>::Zero(), R), {A(k)}, Squared());
    if (k == 0) continue;
    graph.add(motion, {A(k - 1), A(k)});
    state = corrected(predicted(state, transition<Motion2>(kStep), process_noise()), z[k], H, R);
  }
  ASSERT_EQ(make_backend("irls")->solve(graph, values).termination, Termination::converged);
  const Square covariance = Marginals(graph, values).covariance<Motion2>(A(kStates - 1));
  EXPECT_LT((values.at<Motion2>(A(kStates - 1)).value - state.mean).cwiseAbs().maxCoeff(), 1e-9);
  EXPECT_LT((covariance - state.covariance).cwiseAbs().maxCoeff(), 1e-9);
}

template <int K>
Imm<4, K> imm() {
  Imm<4, K> filters;
  filters.transition.setConstant(1e-3);
  filters.transition.diagonal().setConstant(1 - 1e-3 * (K - 1));
  filters.probabilities.setConstant(1.0 / K);
  filters.models.fill(first_state());
  return filters;
}

TEST(Imm, OfOneModelIsItsFilter) {
  Imm<4, 1> filters = imm<1>();
  Gaussian<4> alone = first_state();
  const Square F = transition<Motion2>(kStep);
  for (const Vector<2>& z : measurements(50)) {
    filters.step([&](int, const Gaussian<4>& prior) { return filtered(prior, z, F, process_noise()); });
    alone = filtered(alone, z, F, process_noise()).state;
    EXPECT_EQ(filters.probabilities[0], 1);
    EXPECT_LT((filters.state().mean - alone.mean).cwiseAbs().maxCoeff(), 1e-12);
    EXPECT_LT((filters.state().covariance - alone.covariance).cwiseAbs().maxCoeff(), 1e-12);
  }
}

TEST(Imm, ProbabilitiesSumToOneEvenFarFromEveryModel) {
  Imm<4, 3> filters = imm<3>();
  const Square F = transition<Motion2>(kStep);
  for (const Vector<2>& z : measurements(50)) {
    filters.step([&](int i, const Gaussian<4>& prior) { return filtered(prior, z + Vector<2>(1e4, 0), F, (1 + i) * process_noise()); });
    EXPECT_NEAR(filters.probabilities.sum(), 1, 1e-14);
    EXPECT_GE(filters.probabilities.minCoeff(), 0);
    EXPECT_TRUE(filters.state().mean.allFinite());
  }
}

TEST(Imm, FindsTheModelThatIsTrue) {
  Imm<4, 2> filters = imm<2>();
  const Square still = Square::Identity(), moving = transition<Motion2>(kStep);
  for (const Vector<2>& z : measurements(100))
    filters.step([&](int i, const Gaussian<4>& prior) { return filtered(prior, z, i == 0 ? still : moving, 0.01 * process_noise()); });
  EXPECT_GT(filters.probabilities[1], 0.9);
}

// Two halves one metre to each side: variance 0.25 + 1, mean between.
TEST(Imm, MixtureHasTheMomentsOfItsParts) {
  const std::array<Gaussian<1>, 2> parts{Gaussian<1>{Vector<1>(-1), Matrix<1, 1>(0.25)}, Gaussian<1>{Vector<1>(1), Matrix<1, 1>(0.25)}};
  const Gaussian<1> all = mixture<1, 2>(parts, Vector<2>(0.5, 0.5));
  EXPECT_NEAR(all.mean[0], 0, 1e-15);
  EXPECT_NEAR(all.covariance(0, 0), 1.25, 1e-15);
}

}  // namespace
}  // namespace holdfast::bench
