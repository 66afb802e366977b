// `holdfast simulate`: the file holds what was asked for, and says where the truth is.
#include <gmock/gmock.h>

#include <holdfast/common/instance.hpp>
#include <holdfast/factors/range.hpp>

#include "tests/program/helpers.hpp"

namespace holdfast::program {
namespace {

using ::testing::HasSubstr;

class Simulate : public InDirectory {};

TEST_F(Simulate, EveryScenarioIsAFileThatSolves) {
  for (const SimulatedScenario& scenario : simulated_scenarios()) {
    const std::string name = scenario.name;
    const bool has_agents = scenario.agents > 0;
    const std::string few = has_agents ? "--agents" : "--steps";
    const std::string file = at(name + ".pyfg");
    const Outcome made = holdfast_program({"simulate", name, file, few, name == "fleet" ? "2" : "40"});
    ASSERT_EQ(made.code, kDone) << made.err;
    const Outcome solved = holdfast_program({"solve", "--backend", "irls", "--json", at("run.json"), file});
    EXPECT_EQ(solved.code, kDone) << name << solved.err;
    const auto run = lines_of(at("run.json"))[0];
    EXPECT_LT(run["cost_first"], 4.0 * run["factors"].get<double>()) << name;  // ½χ² at the truth, at most six components a factor
    EXPECT_LE(run["cost"], run["cost_first"]) << name;
  }
}

TEST_F(Simulate, TheSameSeedIsTheSameFileAndAnotherIsNot) {
  for (const std::string seed : {"4", "4", "5"}) {
    static int count = 0;
    ASSERT_EQ(holdfast_program({"simulate", "fleet", at(std::to_string(count++) + ".pyfg"), "--seed", seed}).code, kDone);
  }
  EXPECT_EQ(text_of(at("0.pyfg")), text_of(at("1.pyfg")));
  EXPECT_NE(text_of(at("0.pyfg")), text_of(at("2.pyfg")));
}

/// χ² a degree of the ranges' noise at the true vertices.
double mean_square(const std::string& file, double most) {
  const FileProblem problem = load(file, ProblemOptions());
  double sum = 0;
  int count = 0;
  problem.instance.graph.for_each_batch<Range<Pose2, Pose2>>([&](const auto& batch) {
    for (int i = 0; i < batch.size(); ++i) {
      const double r = batch.factors()[i](problem.instance.truth.template at<Pose2>(batch.keys(i)[0]),
                                          problem.instance.truth.template at<Pose2>(batch.keys(i)[1]))[0];
      if (std::abs(r) > most) continue;
      sum += r * r;
      ++count;
    }
  });
  return sum / count;
}

TEST_F(Simulate, TheNoiseIsWhatTheFileSaysAtTheTrueVertices) {
  for (const std::string noise : {"1", "3"}) {
    ASSERT_EQ(holdfast_program({"simulate", "fleet", at("a.pyfg"), "--agents", "4", "--steps", "200", "--noise", noise}).code, kDone);
    EXPECT_NEAR(mean_square(at("a.pyfg"), 1e9), 1, 0.15) << noise;  // 1200 ranges: σ of the mean square is 0.04
    for (const Edge& edge : read_any(at("a.pyfg")).edges) {
      const RangeEdge* range = std::get_if<RangeEdge>(&edge.measurement);
      if (range != nullptr) {
        ASSERT_NEAR(range->variance, std::pow(0.1 * std::stod(noise), 2), 1e-12);
      }
    }
  }
}

TEST_F(Simulate, OutliersAndLossesAreSharesOfTheRanges) {
  const Outcome all = holdfast_program({"simulate", "fleet", at("all.pyfg"), "--agents", "2"});
  EXPECT_THAT(all.out, HasSubstr("0 of them false, 0 lost"));
  const Outcome some = holdfast_program({"simulate", "fleet", at("some.pyfg"), "--agents", "2", "--outliers", "0.2", "--lost", "0.5"});
  ASSERT_EQ(some.code, kDone) << some.err;
  const auto ranges = [](const std::string& text) {
    int count = 0;
    for (std::size_t at = 0; (at = text.find("EDGE_RANGE", at)) != std::string::npos; ++at) ++count;
    return count;
  };
  EXPECT_EQ(ranges(text_of(at("all.pyfg"))), 100 * (2 * 4 + 1));
  EXPECT_NEAR(ranges(text_of(at("some.pyfg"))), 450, 75);  // five σ
  const Dataset dataset = read_any(at("some.pyfg"));
  const Simulation truth = simulate({"fleet", 2, 100, 1, 0, 0, 1});
  std::map<Key, Vector<2>> places;
  for (const Key key : truth.truth.keys())
    places[key] = key.kind() == 'L' ? truth.truth.at<Point2>(key).value : truth.truth.at<Pose2>(key).p;
  int long_ones = 0;
  for (const Edge& edge : dataset.edges)
    if (const RangeEdge* range = std::get_if<RangeEdge>(&edge.measurement))
      long_ones += range->distance - (places[range->first] - places[range->second]).norm() > 4 ? 1 : 0;
  EXPECT_NEAR(long_ones, 90, 45);
  EXPECT_THAT(some.out, HasSubstr(std::to_string(long_ones) + " of them false"));
}

TEST_F(Simulate, G2oHasTheStartAndTheTruthWhereItIsAsked) {
  ASSERT_EQ(holdfast_program({"simulate", "ring", at("start.g2o")}).code, kDone);
  ASSERT_EQ(holdfast_program({"simulate", "ring", at("truth.g2o"), "--vertices", "truth"}).code, kDone);
  const Dataset start = read_any(at("start.g2o")), truth = read_any(at("truth.g2o"));
  ASSERT_EQ(start.vertices.size(), 300u);
  double furthest = 0;
  for (std::size_t i = 0; i < 300; ++i) {
    EXPECT_NEAR(std::get<Pose2>(truth.vertices[i].value).p.norm(), 50, 1e-9);  // on the circle
    furthest = std::max(furthest, std::abs(std::get<Pose2>(start.vertices[i].value).p.norm() - 50));
  }
  EXPECT_GT(furthest, 0.1);
}

TEST_F(Simulate, SaysWhatMakesNoSenseAndWritesNothing) {
  for (const std::vector<std::string>& bad : std::vector<std::vector<std::string>>{{"nowhere", at("a.pyfg")},
                                                                                   {"ring", at("a.txt")},
                                                                                   {"ring", at("a.g2o"), "--agents", "3"},
                                                                                   {"swarm", at("a.pyfg"), "--steps", "3"},
                                                                                   {"fleet", at("a.pyfg"), "--agents", "26"},
                                                                                   {"fleet", at("a.pyfg"), "--outliers", "1.5"},
                                                                                   {"fleet", at("a.pyfg"), "--noise", "0"}}) {
    std::vector<std::string> arguments{"simulate"};
    arguments.insert(arguments.end(), bad.begin(), bad.end());
    const Outcome outcome = holdfast_program(arguments);
    EXPECT_EQ(outcome.code, kUsage) << bad[0] << outcome.err;
    EXPECT_FALSE(outcome.err.empty());
    EXPECT_FALSE(std::filesystem::exists(bad[1]));
  }
  const Outcome swarm = holdfast_program({"simulate", "fleet", at("a.g2o")});  // ranges between poses
  EXPECT_EQ(swarm.code, kFailed);
  EXPECT_THAT(swarm.err, HasSubstr("range"));
}

}  // namespace
}  // namespace holdfast::program
