// Paper A's scenario, its estimators and ours.
#include <gtest/gtest.h>

#include <Eigen/LU>
#include <holdfast/benchmarks/papers/rivals_a.hpp>
#include <holdfast/benchmarks/papers/tracked_pursuit.hpp>
#include <holdfast/benchmarks/scenarios/random.hpp>
#include <holdfast/solvers/table.hpp>

namespace holdfast::bench {
namespace {

using Kind = WhiteAcceleration<Motion2>::Kind;

PursuitOptions soiled(int steps) {
  PursuitOptions options = gentle();
  options.steps = steps;
  options.sensors[0].outliers = 0.2;
  options.sensors[0].missing = 0.3;
  return options;
}

PursuitOptions soiled_and_fast(int steps) {
  PursuitOptions options = fast();
  options.steps = steps;
  options.sensors[0].outliers = 0.2;
  options.sensors[0].missing = 0.2;
  return options;
}

TEST(Pursuit, HasItsShareOfOutliersAndGapsOnTheSameTarget) {
  constexpr int kSteps = 4000;
  const Pursuit soil = pursuit(soiled(kSteps), 3), clean = without_outliers(soiled(kSteps), 3);
  int outliers = 0, received = 0;
  for (int k = 0; k < kSteps; ++k) {
    const Sighting &dirty = soil.sightings[k][0], &washed = clean.sightings[k][0];
    EXPECT_EQ(soil.truth[k].value, clean.truth[k].value);
    EXPECT_EQ(dirty.received, washed.received);
    EXPECT_FALSE(washed.outlier);
    outliers += dirty.outlier;
    received += dirty.received;
    const Vector<2> gross = dirty.z - washed.z;
    EXPECT_EQ(dirty.outlier, gross.norm() > 0);
    if (dirty.outlier) {
      EXPECT_GE(gross.minCoeff(), 40 - 1e-9);
      EXPECT_LE(gross.maxCoeff(), 70 + 1e-9);
    }
  }
  EXPECT_NEAR(outliers, 0.2 * kSteps, 100);
  EXPECT_NEAR(received, 0.7 * kSteps, 120);
}

TEST(Pursuit, RandomSignsGoEveryWayAndTHasItsQuartiles) {
  PursuitOptions options = soiled(4000);
  options.random_signs = true;
  int positive = 0, outliers = 0;
  const Pursuit soil = pursuit(options, 3);
  for (std::size_t k = 0; k < soil.truth.size(); ++k)
    if (soil.sightings[k][0].outlier) {
      ++outliers;
      positive += soil.sightings[k][0].z[0] > soil.truth[k].value[0];
    }
  EXPECT_NEAR(positive, outliers / 2, 60);
  PursuitOptions heavy = gentle();
  heavy.steps = 4000;
  heavy.sensors[0].student_nu = 1;  // Cauchy: half of it within ±1
  const Pursuit t = pursuit(heavy, 3), plain = without_outliers(heavy, 3);
  int within = 0;
  for (int k = 0; k < heavy.steps; ++k) within += std::abs(t.sightings[k][0].z[0] - plain.sightings[k][0].z[0]) < 1;
  EXPECT_NEAR(within, heavy.steps / 2, 100);
}

double largest_difference(const Positions& a, const Positions& b) {
  double largest = 0;
  for (std::size_t k = 0; k < a.size(); ++k) largest = std::max(largest, (a[k] - b[k]).norm());
  return largest;
}

// Anchored, with nothing ever dropped and squared losses, (7) is the Kalman filter over m missing steps.
TEST(RivalsA, LeastSquaresOverEverythingIsTheKalmanFilter) {
  const Pursuit data = pursuit(soiled(60), 2);
  EXPECT_LT(largest_difference(kalman_a(data), windowed_a(data, {least_squares_losses(), Kind::paper, true, 100})), 1e-8);
}

TEST(RivalsA, HuberStandsOutliersThatLeastSquaresDoesNot) {
  PursuitOptions options = soiled(300);
  options.sensors[0].outliers = 0.1;
  const Pursuit data = pursuit(options, 4);
  const double squares = rmse(data, windowed_a(data, {least_squares_losses()}), 0, 300);
  EXPECT_GT(squares, 10);
  EXPECT_LT(rmse(data, windowed_a(data, {robust_losses()}), 0, 300), squares / 3);
}

Positions tracked(const Pursuit& data, const TrackerOptions& options, int lag = 0) {
  const double variance = data.options.sigma * data.options.sigma;
  PursuitTracker tracker(data.options.dt, {variance * Matrix<2, 2>::Identity()}, options);
  Positions positions;
  for (std::size_t k = 0; k < data.truth.size(); ++k) {
    tracker.step(data.sightings[k]);
    positions.push_back((static_cast<int>(k) < lag ? tracker.state() : tracker.state(lag)).position());
  }
  return positions;
}

#ifdef HOLDFAST_WITH_CERES
constexpr double kSame = 1e-6;  // [m]; measured: 7e-8

void expect_same_numbers(const std::vector<Loss>& losses) {
  for (const Loss& loss : losses)
    for (const PursuitOptions& scenario : {soiled(150), soiled_and_fast(150)}) {
      TrackerOptions options;
      options.loss = loss;
      const Pursuit data = pursuit(scenario, 5);
      const Positions irls = tracked(data, options), later = tracked(data, options, 20);
      options.backend = "ceres";
      EXPECT_LT(largest_difference(irls, tracked(data, options)), kSame) << loss.str();
      EXPECT_LT(largest_difference(later, tracked(data, options, 20)), kSame) << loss.str();
    }
}

TEST(PursuitTracker, GivesTheSameNumbersFromCeresAndIrls) { expect_same_numbers({TruncatedSquares{3.5}, Huber{1.345}}); }

// Not yet: in one of the two scenarios one of them acquires again where the other does not.
TEST(PursuitTracker, DISABLED_GivesTheSameNumbersFromCeresAndIrlsUnderStudentT) { expect_same_numbers({StudentT{3}}); }

TEST(RivalsA, GiveTheSameNumbersFromCeresAndIrls) {
  for (const ChainLosses& losses : {robust_losses(), least_squares_losses(), sum_of_norms_losses(2)})
    for (const bool anchored : {false, true}) {
      WindowedOptions options{losses, anchored ? Kind::paper : Kind::recursive, anchored};
      const Pursuit data = pursuit(soiled_and_fast(100), 6);
      const Positions irls = windowed_a(data, options);
      options.backend = "ceres";
      EXPECT_LT(largest_difference(irls, windowed_a(data, options)), kSame) << losses.measurement.str() << anchored;
    }
}
#endif

// What Chain polishes is the last digits of a back-end's answer, not the answer.
TEST(Chain, PolishesNoMoreThanTheLastDigits) {
  const Pursuit data = pursuit(soiled_and_fast(80), 4);
  std::vector<ChainNode> nodes;
  for (int k = 0; k < 30; ++k)
    nodes.push_back({k,
                     {data.sightings[k][0].z},
                     WhiteAcceleration<Motion2>::continuous(0.05, 10),
                     Motion2(data.sightings[k][0].z[0], 0.0, data.sightings[k][0].z[1], 0.0)});
  for (const std::string& name : backend_names()) {
    if (name != "ceres" && name != "irls") continue;
    Chain chain({{25 * Matrix<2, 2>::Identity(), 1}}, {Huber{1.345}, Squared(), Squared()});
    Options options;
    options.cost_tolerance = 0;
    const auto backend = make_backend(name, options);
    chain.set(nodes, std::nullopt);
    Values alone = chain.values();
    backend->solve(chain.graph(), alone);
    std::vector<ChainNode> polished = nodes;
    chain.solve(*backend, polished);
    for (int k = 0; k < 30; ++k) EXPECT_LT((alone.at<Motion2>(chain.key(k)).value - polished[k].state.value).norm(), 1e-4) << name;
  }
}

// With squared losses the arrival cost holds all that the dropped states knew.
TEST(PursuitTracker, LosesNothingByAShortWindow) {
  TrackerOptions options;
  options.loss = Squared();
  const Pursuit data = without_outliers(soiled(150), 6);
  options.window = options.lock.memory = 200;
  const Positions all = tracked(data, options);
  options.window = 2;
  EXPECT_LT(largest_difference(all, tracked(data, options)), 1e-6);
}

TEST(PursuitTracker, IsCloseToWhatItWouldBeWithoutOutliers) {
  constexpr int kSteps = 400;
  const Pursuit data = pursuit(soiled(kSteps), 7), clean = without_outliers(soiled(kSteps), 7);
  const double soil = rmse(data, tracked(data, {}), 60, kSteps);
  EXPECT_LT(soil, 1.3 * rmse(clean, tracked(clean, {}), 60, kSteps));
  EXPECT_LT(rmse(data, tracked(data, {}), 60, kSteps), 1);
}

TEST(PursuitTracker, AgreesWithHindsight) {
  const Pursuit data = pursuit(soiled(200), 8);
  const Positions late = tracked(data, {}, 20);
  double sum = 0;
  for (int k = 80; k < 200; ++k) sum += (late[k] - data.truth[k - 20].position()).squaredNorm();
  EXPECT_LT(std::sqrt(sum / 120), 0.6 * rmse(data, tracked(data, {}), 80, 200));
}

// All measurements move 100 m away at once: to a truncated loss with an arrival cost each of them is an outlier, for ever.
TEST(PursuitTracker, NoticesThatItIsLockedOut) {
  constexpr int kJump = 100, kSteps = 200;
  Pursuit data = without_outliers(soiled(kSteps), 9);
  for (int k = kJump; k < kSteps; ++k) {
    data.sightings[k][0].z += Vector<2>(100, 0);
    data.truth[k].value[0] += 100;
  }
  PursuitTracker tracker(data.options.dt, {Matrix<2, 2>::Identity()}, {});
  for (int k = 0; k < kSteps; ++k) {
    tracker.step(data.sightings[k]);
    if (k == kJump - 1) {
      EXPECT_EQ(tracker.reacquisitions(), 0);
    }
  }
  EXPECT_GE(tracker.reacquisitions(), 1);
  EXPECT_LT((tracker.state().position() - data.truth.back().position()).norm(), 3);
}

}  // namespace
}  // namespace holdfast::bench
