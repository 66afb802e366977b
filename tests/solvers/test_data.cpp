// irls on real data: at ceres' cost or lower from the same start, and the same bits with any number of threads.
#include <gtest/gtest.h>

#include <cstdlib>
#include <filesystem>
#include <holdfast/adapters/files/problem.hpp>
#include <holdfast/graph/files/files.hpp>
#include <holdfast/solvers/irls/irls.hpp>

#include "tests/problems.hpp"

namespace holdfast::testing {
namespace {

std::string path_of(const std::string& file) {
  const char* chosen = std::getenv("HOLDFAST_DATA");
  return (chosen != nullptr ? std::string(chosen) : std::string(HOLDFAST_SOURCE_DIR) + "/../shared/data") + "/" + file;
}

#define HOLDFAST_NEED(file) \
  if (!std::filesystem::exists(path_of(file))) GTEST_SKIP() << path_of(file) << " is not there; set HOLDFAST_DATA"

Problem problem_of(const std::string& file, const Loss& loss) {
  return make_problem(read_dataset(path_of(file)), {loss, ProblemOptions::Start::odometry, 0});
}

struct Run {
  const char* file;
  Loss loss;
};
void PrintTo(const Run& run, std::ostream* out) { *out << run.file << " " << run.loss.str(); }

std::string label(const ::testing::TestParamInfo<Run>& info) {
  return std::filesystem::path(info.param.file).stem().string() + "_" + info.param.loss.str().substr(0, info.param.loss.str().find(':'));
}

class RealData : public ::testing::TestWithParam<Run> {};

Options to_1e_10() {
  Options options;
  options.max_iterations = 1000;
  options.cost_tolerance = 1e-10;
  return options;
}

// "Where the two end in different minima, both are shown": lower than ceres is always right, higher never.
TEST_P(RealData, IrlsEndsAtTheCostOfCeresOrLower) {
  HOLDFAST_NEED(GetParam().file);
  const Problem problem = problem_of(GetParam().file, GetParam().loss);
  double irls = NAN, least_of_ceres = NAN;
  for (const std::string& backend : backend_names()) {
    if (backend != "irls" && backend != "ceres") continue;
    Values values = problem.start;
    const Summary summary = solve(backend, problem.graph, values, to_1e_10());
    EXPECT_EQ(summary.termination, Termination::converged) << backend << ": " << summary.str();
    EXPECT_NEAR(summary.cost, problem.graph.cost(values), 1e-9 * summary.cost);
    std::cout << "  " << backend << ": " << summary.str() << std::endl;
    (backend == "irls" ? irls : least_of_ceres) = summary.cost;
  }
  if (std::isnan(least_of_ceres)) GTEST_SKIP() << "this build has no ceres";
  EXPECT_LE(irls, least_of_ceres * (1 + 1e-6));
}

std::vector<Run> every_run() {
  std::vector<Run> runs;
  for (const char* file : {"range/plaza2.pyfg", "range/goats_14.pyfg", "range/single_drone.pyfg", "range/tiers.pyfg", "range/mrclam5a.pyfg",
                           "pose_graph/intel.g2o", "pose_graph/MIT.g2o", "pose_graph/M3500.g2o", "pose_graph/tinyGrid3D.g2o",
                           "pose_graph/smallGrid3D.g2o", "pose_graph/sphere2500.g2o"})
    for (const Loss& loss : {Loss(Squared{}), Loss(Huber{2})}) runs.push_back({file, loss});
  return runs;
}

INSTANTIATE_TEST_SUITE_P(Files, RealData, ::testing::ValuesIn(every_run()), label);

class SameBits : public ::testing::TestWithParam<Run> {};

TEST_P(SameBits, WithOneTwoAndThreeThreads) {
  HOLDFAST_NEED(GetParam().file);
  const Problem problem = problem_of(GetParam().file, GetParam().loss);
  Options options;
  options.max_iterations = 8;
  Values alone = problem.start;
  const Summary reference = Irls(options).solve(problem.graph, alone);
  ASSERT_TRUE(reference.usable()) << reference.str();
  for (const int threads : {2, 3}) {
    options.threads = threads;
    Irls solver(options);
    for (int round = 0; round < 2; ++round) {  // a fresh object, and the same again
      Values values = problem.start;
      const Summary summary = solver.solve(problem.graph, values);
      EXPECT_TRUE(same_bits(alone, values)) << threads << " threads, round " << round;
      EXPECT_EQ(summary.cost, reference.cost);
      EXPECT_EQ(summary.gradient_norm, reference.gradient_norm);
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Files, SameBits,
                         ::testing::Values(Run{"range/plaza2.pyfg", Huber{2}}, Run{"pose_graph/sphere2500.g2o", Huber{2}},
                                           Run{"pose_graph/M3500.g2o", Squared{}}),
                         label);

TEST(NesterovOnData, NeverRisesAndSaysWhenItHitsItsLimit) {
  HOLDFAST_NEED("range/plaza2.pyfg");
  const Problem problem = problem_of("range/plaza2.pyfg", Huber{2});
  Values values = problem.start;
  Options options;
  options.max_iterations = 300;
  options.cost_tolerance = 1e-12;
  options.trace = true;
  const Summary summary = solve("nesterov", problem.graph, values, options);
  EXPECT_EQ(summary.termination, Termination::iteration_limit) << summary.str();
  for (std::size_t i = 1; i < summary.trace.size(); ++i) ASSERT_LE(summary.trace[i].cost, summary.trace[i - 1].cost) << i;
  EXPECT_NEAR(summary.cost, problem.graph.cost(values), 1e-9 * summary.cost);
}

}  // namespace
}  // namespace holdfast::testing
