// Paper B's scenario, its filters and ours.
#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <holdfast/benchmarks/papers/flight_tracker.hpp>
#include <holdfast/benchmarks/papers/rivals_b.hpp>
#include <holdfast/factors/white_acceleration.hpp>
#include <holdfast/testing.hpp>

namespace holdfast::bench {
namespace {

double variance(const Flight& flight) {
  double sum = 0;
  for (int f = 0; f < kFollowers; ++f)
    for (int k = 0; k < flight.options.steps; ++k) sum += (flight.gps[f][k] - flight.truth[f][k].position()).squaredNorm() / 2;
  return sum / (kFollowers * flight.options.steps);
}

// As printed, more "Student's t" is less noise: α² ν/(ν − 2) + (1 − α)², ν between 25 and 50.
TEST(Flight, PrintedNoiseHasTheVarianceOfAWeightedSum) {
  for (const double alpha : {0.1, 0.3, 0.5}) {
    const double expected = alpha * alpha * 1.057 + (1 - alpha) * (1 - alpha);
    EXPECT_NEAR(variance(flight({alpha, false, 3, 5000}, 1)), expected, 0.02) << alpha;
  }
}

TEST(Flight, AMixtureHasTheVarianceOfItsParts) {
  EXPECT_NEAR(variance(flight({0.5, true, 10, 5000}, 1)), 0.5 * 10.0 / 8 + 0.5, 0.05);  // ν = 10: the fourth moment exists
  EXPECT_NEAR(variance(flight({0, true, 3, 5000}, 1)), 1, 0.03);
}

TEST(Flight, IsAFigureOfEight) {
  const Flight whole = flight({0.1, false, 3, 19635}, 1);
  const auto& leaderless = whole.truth[0];
  EXPECT_LT((leaderless.front().position() - leaderless.back().position()).norm(), 0.05);  // closed
  double highest = 0, lowest = 0;
  for (const Motion2& state : leaderless) {
    EXPECT_NEAR(state.derivative(1).norm(), kFlightSpeed, 1e-12);
    highest = std::max(highest, state.value[2]);
    lowest = std::min(lowest, state.value[2]);
    const Vector<2> centre(0, state.value[2] > 0 ? kFlightRadius : -kFlightRadius);
    EXPECT_NEAR((state.position() - centre).norm(), kFlightRadius, 1e-9);
  }
  EXPECT_NEAR(highest, 40, 1e-3);
  EXPECT_NEAR(lowest, -40, 1e-3);
  EXPECT_NEAR((whole.truth[0][5000].position() - whole.truth[1][5000].position()).norm(), 0.5, 1e-3);
}

// At r = 0: Γ = 0.15/4 I + 1.7/64 [1 −1; −1 1]: R̄ is 26.7 R where both axes err alike, 11 R where they differ.
TEST(RivalsB, AdaptedCovarianceByHand) {
  const Matrix<2, 2> W = Matrix<2, 2>::Identity() / std::sqrt(0.5), adapted = adapted_covariance(Vector<2>::Zero(), W);
  const Vector<2> alike(1, 1), apart(1, -1);
  EXPECT_NEAR((adapted * alike / 0.5)[0], 1 / 0.0375, 1e-9);
  EXPECT_NEAR((adapted * apart / 0.5)[0], 1 / (0.0375 + 2 * 1.7 / 64), 1e-9);
  // Far off, a component loses its own weight: exp(−(8/2)²/2).
  const Matrix<2, 2> far = adapted_covariance(Vector<2>(8, 8), Matrix<2, 2>::Identity());
  EXPECT_NEAR((far * alike)[0], 1 / (0.0375 * std::exp(-8)), 1e-6);
}

TEST(RivalsB, StandStillWhereTheyAreTold) {
  for (const FilterB kind : {FilterB::kf, FilterB::ekf, FilterB::arkf}) {
    ImmB filter({kind, 0.5, 0.01}, Motion2(3, 0, 4, 0));
    for (int k = 0; k < 200; ++k) filter.step({3, 4});
    EXPECT_LT((Motion2(filter.state().mean).position() - Vector<2>(3, 4)).norm(), 1e-9);
    EXPECT_NEAR(filter.probabilities().sum(), 1, 1e-12);
    EXPECT_EQ(filter.chi_square_alarms(), 0);
  }
}

// The inflated R̄ explains any residual before λ could: eᵀ Γ e has a largest value, and it is below 5.991.
TEST(RivalsB, TheChiSquareTestNeverFails) {
  double largest = 0;
  for (double x = -40; x <= 40; x += 0.5)
    for (double y = -40; y <= 40; y += 0.5) {
      const Vector<2> r(x, y);
      largest = std::max(largest, r.dot(adapted_covariance(r, Matrix<2, 2>::Identity()).inverse() * r));
    }
  EXPECT_LT(largest, 1.5);
  EXPECT_GT(largest, 1);
  ImmB filter({FilterB::arkf, 0.5, 0.01}, Motion2(0, 0, 0, 0));
  for (const double far : {0.1, 3.0, 30.0, 1e4}) filter.step({far, -far});
  EXPECT_EQ(filter.chi_square_alarms(), 0);
  EXPECT_TRUE(filter.state().mean.allFinite());
}

TEST(RivalsB, TheEkfStandsTheOrigin) {
  ImmB filter({FilterB::ekf, 0.5, 0.01}, Motion2(0, 0, 0, 0));
  for (int k = 0; k < 10; ++k) filter.step({0, 0});
  EXPECT_TRUE(filter.state().mean.allFinite());
}

Motion2 start_of(const Flight& flight, int follower) { return flight.truth[follower][0]; }

std::vector<Motion2> starts(const Flight& flight) {
  std::vector<Motion2> all;
  for (int f = 0; f < kFollowers; ++f) all.push_back(start_of(flight, f));
  return all;
}

std::vector<Vector<2>> samples(const Flight& flight, int step) {
  std::vector<Vector<2>> all;
  for (int f = 0; f < kFollowers; ++f) all.push_back(flight.gps[f][step]);
  return all;
}

// A state a sample, squared loss, no turns: nothing is left out, and what is left is Kalman's filter.
TEST(FlightTracker, IsTheKalmanFilterWhereNothingIsLeftOut) {
  FlightTrackerOptions options;
  options.loss = Squared();
  options.spacing = 1;
  options.q = 1e-2;
  options.q_turn = 1e-16;
  options.sigma_turn = 1e-7;
  options.looks_back = false;
  const Flight data = flight({0.1, false, 3, 100}, 2);
  FlightTracker tracker(kFlightStep, starts(data), options);
  const auto W = WhiteAcceleration<Motion2>::continuous(kFlightStep, options.q).sqrt_information;
  const Matrix<4, 4> F = transition<Motion2>(kFlightStep), Q = (W * W).inverse();
  Gaussian<4> state{start_of(data, 0).value, Vector<4>(1, 0.09, 1, 0.09).asDiagonal()};
  for (int k = 0; k < data.options.steps; ++k) {
    tracker.step(samples(data, k));
    if (k > 0) state = predicted(state, F, Q);
    state =
        corrected(state, data.gps[0][k], Matrix<2, 4>(Motion2::position_jacobian()), Matrix<2, 2>(options.R * Matrix<2, 2>::Identity()));
    EXPECT_LT((tracker.state(0).value - state.mean).norm(), 1e-6) << k;
    EXPECT_LT((tracker.covariance(0) - state.covariance).norm(), 1e-6) << k;
  }
}

// Prior and samples, these with the weights ρ' they have at the answer; then the turn, linearised there: what an extended Kalman filter
// makes of them, but for the first sample of a state, which the answer before it sees, too.
TEST(FlightTracker, KnowsWhatAnExtendedKalmanFilterKnows) {
  const FlightTrackerOptions options;
  const Flight data = flight({0.5, true, 3, 160}, 5);
  FlightTracker tracker(kFlightStep, starts(data), options);
  const CoordinatedTurn turn{options.spacing * kFlightStep, options.q, options.q_turn};
  Vector<5> mean, sigmas(1, 0.3, 1, 0.3, options.sigma_turn);
  mean << start_of(data, 0).value, 0;
  Matrix<5, 5> prior = sigmas.cwiseInverse().cwiseAbs2().asDiagonal();
  for (int s = 0; s < 10; ++s) {
    for (int k = 0; k < 16; ++k) tracker.step(samples(data, 16 * s + k));
    Matrix<5, 5> information;
    Vector<5> answer = mean;
    for (int i = 0; i < 300; ++i) {  // re-weighted least squares to the end
      information = prior;
      Vector<5> sum = prior * mean;
      for (int k = 0; k < 16; ++k) {
        Matrix<2, 5> H = Matrix<2, 5>::Zero();
        H(0, 0) = H(1, 2) = 1;
        H(0, 1) = H(1, 3) = k * kFlightStep;
        const Vector<2> gps = data.gps[0][16 * s + k];
        const double weight = options.loss.rho((gps - H * answer).squaredNorm() / options.R, 2).first / options.R;
        information += weight * H.transpose() * H;
        sum += weight * H.transpose() * gps;
      }
      answer = information.ldlt().solve(sum);
    }
    const CoordinatedTurn last{15 * kFlightStep, options.q, options.q_turn};
    EXPECT_LT((tracker.state(0).value - last.predicted(Turning2(answer)).mean.head<4>()).norm(), 1e-2) << s;
    const CoordinatedTurn::Prediction ahead = turn.predicted(Turning2(answer));
    prior = (ahead.F * information.inverse() * ahead.F.transpose() + turn.covariance()).inverse();
    mean = ahead.mean;
  }
}

TEST(FlightTracker, FlagsTheSamplesThatAreFarOff) {
  Flight data = flight({0, true, 3, 200}, 5);  // Gaussian
  for (int k = 20; k < 180; k += 20) data.gps[3][k] += Vector<2>(0, 12);
  FlightTracker tracker(kFlightStep, starts(data), {});
  for (int k = 0; k < 200; ++k) tracker.step(samples(data, k));
  EXPECT_EQ(tracker.judged(), kFollowers * 192);  // twelve states are complete
  int found = 0;
  for (const FlightTracker::Flag& flag : tracker.flags()) found += flag.follower == 3 && flag.step % 20 == 0;
  EXPECT_EQ(found, 8);
  EXPECT_LT(tracker.flags().size(), 20u);
}

TEST(FlightTracker, GivesTheSameNumbersFromCeresAndIrls) {
  const Flight data = flight({0.5, true, 3, 200}, 3);
  FlightTrackerOptions options;
  FlightTracker irls(kFlightStep, starts(data), options);
  options.backend = "ceres";
  FlightTracker ceres(kFlightStep, starts(data), options);
  for (int k = 0; k < data.options.steps; ++k) {
    irls.step(samples(data, k));
    ceres.step(samples(data, k));
    for (int f = 0; f < kFollowers; ++f) {
      EXPECT_LT((irls.state(f).position() - ceres.state(f).position()).norm(), 1e-6) << k;
      if (k > 100) {
        EXPECT_LT((irls.smoothed(f, 62).position() - ceres.smoothed(f, 62).position()).norm(), 1e-6) << k;
      }
    }
  }
}

TEST(FlightTracker, LearnsTheTurnAndIsBetterLater) {
  const Flight data = flight({0.5, false, 3, 4000}, 4);
  FlightTracker tracker(kFlightStep, starts(data), {});
  double now = 0, late = 0;
  for (int k = 0; k < data.options.steps; ++k) {
    tracker.step(samples(data, k));
    for (int f = 0; f < kFollowers && k >= 1000; ++f) {
      now += (tracker.state(f).position() - data.truth[f][k].position()).squaredNorm();
      late += (tracker.smoothed(f, 62).position() - data.truth[f][k - 62].position()).squaredNorm();
    }
  }
  const double count = kFollowers * 3000;
  EXPECT_LT(std::sqrt(now / count), 0.137);
  EXPECT_LT(std::sqrt(late / count), 0.085);
}

}  // namespace
}  // namespace holdfast::bench
