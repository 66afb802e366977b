// The races of `holdfast bench` and what they run on.
#include <gmock/gmock.h>

#include <cstdlib>
#include <filesystem>
#include <holdfast/benchmarks/race.hpp>
#include <holdfast/benchmarks/suites/profile.hpp>
#include <holdfast/benchmarks/suites/robust_cases.hpp>
#include <holdfast/factors/between.hpp>
#include <holdfast/factors/range.hpp>

#include "tests/program/helpers.hpp"

namespace holdfast::bench {
namespace {

using program::InDirectory;
using program::lines_of;
using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::Not;

class Suites : public InDirectory {};

TEST(SuiteTable, RacesRunOnlyWhenNamed) {
  for (const Suite& suite : suites_of({})) EXPECT_EQ(suite.race, nullptr) << suite.name;
  for (const char* name : {"window", "range", "pose-graph"}) EXPECT_NE(suites_of({name}).front().race, nullptr) << name;
}

TEST_F(Suites, SayWhichFileIsAbsent) {
  const char* before = std::getenv("HOLDFAST_DATA");
  const std::string saved = before == nullptr ? "" : before;
  ::setenv("HOLDFAST_DATA", at("empty").c_str(), 1);
  const std::vector<Case> cases = pose_graph_cases(1);
  before == nullptr ? ::unsetenv("HOLDFAST_DATA") : ::setenv("HOLDFAST_DATA", saved.c_str(), 1);
  EXPECT_EQ(cases.size(), 7u);
  for (const Case& one : cases) EXPECT_THAT(one.absent, HasSubstr(one.name));
  EXPECT_THROW(data_case("pose_graph/MIT.g2o", "squared", "nowhere", 1), BadOption);
}

template <class Pose>
void expect_walk(int space) {
  constexpr int kPoses = 2000;
  const Instance walk = grid_walk(space, kPoses, 3);
  constexpr Agent x('x');
  EXPECT_EQ(walk.start.size(), kPoses);
  int closures = 0;
  walk.graph.for_each_batch<Between<Pose>>([&](const Batch<Between<Pose>>& batch) {
    for (int i = 0; i < batch.size(); ++i) {
      const Key a = batch.keys(i)[0], b = batch.keys(i)[1];
      const double apart = (walk.truth.at<Pose>(a).p - walk.truth.at<Pose>(b).p).norm();
      const bool step = b.index() == a.index() + 1;
      closures += !step;
      EXPECT_EQ(apart, step ? 1 : 0) << a.str() << ' ' << b.str();
    }
  });
  EXPECT_EQ(walk.graph.size(), std::size_t(kPoses - 1 + closures));
  EXPECT_GT(closures, kPoses / 4);
  EXPECT_TRUE(walk.graph.is_fixed(x(0)));
  const double expected = 0.5 * Pose::dim * static_cast<double>(walk.graph.size());
  EXPECT_NEAR(walk.graph.cost(walk.truth), expected, 0.1 * expected);
  EXPECT_EQ(grid_walk(space, kPoses, 3).graph.cost(walk.start), walk.graph.cost(walk.start));
  EXPECT_NE(grid_walk(space, kPoses, 4).graph.cost(walk.start), walk.graph.cost(walk.start));
}

TEST(GridWalk, IsOnTheGridWithNoiseOfItsSigmasInThePlane) { expect_walk<Pose2>(2); }
TEST(GridWalk, IsOnTheGridWithNoiseOfItsSigmasInSpace) { expect_walk<Pose3>(3); }

Json line(const char* backend, double seconds, double cost, const char* file = "a", int threads = 1) {
  return {{"file", file},       {"loss", "squared"}, {"start", "file"}, {"backend", backend},         {"threads", threads},
          {"seconds", seconds}, {"cost", cost},      {"iterations", 3}, {"termination", "converged"}, {"why", ""}};
}

TEST(Race, LeadIsOverTheFastestThatEndsAtTheBestCost) {
  const std::vector<Json> lines{line("ceres", 4, 1),      line("ceres-lm", 1, 1.1),      line("ceres-dogleg", 3, 1 + 1e-7),
                                line("irls", 0.5, 1),     line("irls", 0.25, 1, "a", 2), line("ceres", 1, 1, "b"),
                                line("irls", 1, 0.5, "b")};
  EXPECT_DOUBLE_EQ(lead(lines[3], lines), 6);
  EXPECT_DOUBLE_EQ(lead(lines[4], lines), 12);
  EXPECT_TRUE(std::isnan(lead(lines[6], lines)));
  std::ostringstream out;
  print_race(out, lines);
  EXPECT_THAT(out.str(), HasSubstr("irls, 2 threads"));
  EXPECT_THAT(out.str(), HasSubstr("NOT the best cost: +0.1 of it"));
  EXPECT_THAT(out.str(), HasSubstr("NOT the best cost: +1 of it"));
  EXPECT_THAT(out.str(), Not(HasSubstr("1e-07 of it")));
}

struct Stage {
  std::ostringstream out, err;
  Terminal terminal{out, err, false};
  ProgressBar bar{terminal, 4};
};

TEST_F(Suites, ARaceKeepsEveryRunAndGoesOn) {
  const Suite suite{"small", "", false, 100, {}};
  const Case one{"walk", "squared", "near truth", [] { return grid_walk(2, 50, 1); }};
  const Case broken{"broken", "squared", "file", []() -> Instance { fail<BadFile>("line 3 is cut"); }};
  const RunnerOptions options = race_options({});
  EXPECT_EQ(options.repetitions, 5);
  Stage stage;
  SuiteResult result, again;
  {
    Journal journal(at("small.jsonl"));
    Runner(suite, kRacePolicy, options, journal, stage.bar).run(one, entrants_of(options.backends, 1), result);
  }
  ASSERT_EQ(result.lines.size(), race_backends().size());
  for (const Json& run : result.lines) {
    EXPECT_EQ(run["termination"], "converged") << run;
    EXPECT_NEAR(run["cost"], result.lines[0]["cost"].get<double>(), 1e-6 * run["cost"].get<double>());
  }
  EXPECT_EQ(lines_of(at("small.jsonl")).size(), result.lines.size());
  Journal journal(at("small.jsonl"));
  Runner runner(suite, kRacePolicy, options, journal, stage.bar);
  runner.run(one, entrants_of(options.backends, 1), again);
  EXPECT_EQ(again.taken, result.lines.size());
  EXPECT_TRUE(print_end(stage.terminal, again, journal.path()));
  runner.run(broken, entrants_of(options.backends, 1), again);
  EXPECT_FALSE(print_end(stage.terminal, again, journal.path()));
  EXPECT_THAT(stage.err.str(), HasSubstr("broken (file): line 3 is cut"));
}

/// A suite goes on with the lines that are there; a race compares seconds of one run, and starts the case again.
TEST_F(Suites, ARaceWithALineMissingIsRunAsAWhole) {
  const Suite suite{"small", "", false, 100, {}};
  const Case one{"walk", "squared", "near truth", [] { return grid_walk(2, 20, 1); }};
  RunnerOptions options;
  options.repetitions = 1;
  Stage stage;
  SuiteResult first, race, as_suite, both;
  Journal journal(at("small.jsonl"));
  Runner(suite, kRacePolicy, options, journal, stage.bar).run(one, {{"irls", 1}}, first);
  Runner(suite, kRacePolicy, options, journal, stage.bar).run(one, {{"irls", 1}, {"irls", 2}}, race);
  EXPECT_EQ(race.taken, 0u);
  EXPECT_EQ(journal.lines().size(), 3u);
  Runner(suite, kSuitePolicy, options, journal, stage.bar).run(one, {{"nesterov", 1}, {"irls", 1}}, as_suite);
  EXPECT_EQ(as_suite.taken, 1u);
  ASSERT_EQ(as_suite.lines.size(), 2u);
  EXPECT_EQ(as_suite.lines[0]["backend"], "nesterov");
  EXPECT_EQ(as_suite.lines[1], journal.lines()[1]) << "the latest of its runs";
  Runner(suite, kRacePolicy, options, journal, stage.bar).run(one, {{"irls", 1}, {"irls", 2}}, both);
  EXPECT_EQ(both.taken, 2u);
  EXPECT_EQ(both.lines, race.lines);
}

TEST(WindowRace, EveryRowEndsInTheSameMinimum) {
  Stage stage;
  const std::vector<Json> lines = window_lines({}, 10, stage.bar);
  ASSERT_GE(lines.size(), 4u);
  for (const Json& row : lines) {
    EXPECT_EQ(row["windows"], 10);
    EXPECT_EQ(row["failed"], false) << row;
    EXPECT_GT(row["median_us"], 0);
    if (row["backend"] == "irls") {
      EXPECT_EQ(row["at_limit"], 0);
    }
    EXPECT_LT(row["largest_excess"], row["tolerance"] == 1e-8 ? 1e-3 : 1e-1) << row;
  }
}

TEST(WindowRace, GivesTheSameNumbersForTheSameSeed) {
  Stage stage;
  const auto facts = [&](unsigned seed) {
    RunnerOptions options;
    options.seed = seed;
    std::vector<Json> lines = window_lines(options, 5, stage.bar);
    for (Json& row : lines)
      for (const char* field : {"median_us", "mean_us", "p95_us"}) row.erase(field);
    return lines;
  };
  EXPECT_EQ(facts(1), facts(1));
  EXPECT_NE(facts(1), facts(2));
}

/// A data directory of the test's own while this lives.
class DataDirectory {
 public:
  explicit DataDirectory(const std::string& path) {
    if (const char* before = std::getenv("HOLDFAST_DATA")) before_ = before;
    ::setenv("HOLDFAST_DATA", path.c_str(), 1);
  }
  ~DataDirectory() { before_ ? ::setenv("HOLDFAST_DATA", before_->c_str(), 1) : ::unsetenv("HOLDFAST_DATA"); }
  DataDirectory(const DataDirectory&) = delete;
  DataDirectory& operator=(const DataDirectory&) = delete;

 private:
  std::optional<std::string> before_;
};

class Robust : public Suites {
 protected:
  static constexpr int kPoses = 300;
  Robust() {
    std::filesystem::create_directories(at("range"));
    std::filesystem::create_directories(at("pose_graph"));
    std::ostringstream ranges, loops;
    for (int k = 0; k < kPoses; ++k) ranges << "VERTEX_SE2 " << k << " A" << k << ' ' << 0.1 * k << " 0 0\n";
    ranges << "VERTEX_XY L0 5 9\nVERTEX_XY L1 25 -8\n";
    for (int k = 1; k < kPoses; ++k) {
      ranges << "EDGE_SE2 " << k << " A" << k - 1 << " A" << k << " 0.1 0 0 0.0001 0 0 0.0001 0 0.000001\n";
      ranges << "EDGE_RANGE " << k << " A" << k << " L0 " << std::hypot(5 - 0.1 * k, 9.0) << " 0.01\n";
      ranges << "EDGE_RANGE " << k << " A" << k << " L1 " << std::hypot(25 - 0.1 * k, 8.0) << " 0.01\n";
      loops << "EDGE_SE2 " << k - 1 << ' ' << k << " 1 0 0.1 100 0 0 100 0 400\n";
    }
    constexpr int kRound = 63;  // about 2 pi / 0.1
    for (int k = kRound; k < kPoses; ++k) loops << "EDGE_SE2 " << k - kRound << ' ' << k << " 0.1 0 0.0168 100 0 0 100 0 400\n";
    write("range/plaza2.pyfg", ranges.str());
    write("pose_graph/CSAIL.g2o", loops.str());
  }
  double error(const AttackedGraph& problem, FactorId id) const {
    const Graph::Place& place = problem.graph.place(id);
    const Key* const keys = problem.graph.batches()[place.batch]->keys(place.index);
    const double truth =
        (problem.truth.at<Pose2>(keys[0]).p - Vector<2>(keys[1] == Key('L', 0) ? 5 : 25, keys[1] == Key('L', 0) ? 9 : -8)).norm();
    return problem.graph.at<Range<Pose2, Point2>>(id).distance - truth;
  }
};

TEST_F(Robust, EchoesAreOneToTwentyMetresTooLongAndTheOthersAsTheyWere) {
  const DataDirectory data(at(""));
  const auto problem = attacked("plaza2", FalseRanges{FalseRanges::Kind::echoes, 0.4}, 1);
  ASSERT_TRUE(problem);
  EXPECT_EQ(problem->odometry.size(), kPoses - 1u);
  EXPECT_EQ(problem->false_loops.size() + problem->true_loops.size(), 2 * (kPoses - 1u));
  EXPECT_NEAR(static_cast<double>(problem->false_loops.size()), 0.4 * 2 * (kPoses - 1), 60);
  for (const FactorId id : problem->false_loops) {
    EXPECT_GE(error(*problem, id), 1 - 1e-3);
    EXPECT_LE(error(*problem, id), 20 + 1e-3);
  }
  for (const FactorId id : problem->true_loops) EXPECT_NEAR(error(*problem, id), 0, 1e-3);
  const auto again = attacked("plaza2", FalseRanges{FalseRanges::Kind::echoes, 0.4}, 1);
  EXPECT_EQ(problem->graph.cost(problem->start), again->graph.cost(again->start));
}

TEST_F(Robust, WithoutLineOfSightRangesAreTwoMetresTooLongOnAverage) {
  const DataDirectory data(at(""));
  const auto problem = attacked("plaza2", FalseRanges{FalseRanges::Kind::no_line_of_sight, 0.9}, 2);
  ASSERT_TRUE(problem);
  double sum = 0;
  for (const FactorId id : problem->false_loops) {
    EXPECT_GE(error(*problem, id), -1e-3);
    sum += error(*problem, id);
  }
  EXPECT_NEAR(sum / static_cast<double>(problem->false_loops.size()), 2, 0.4);
  const auto untouched = attacked("plaza2", FalseRanges{FalseRanges::Kind::as_it_is, 0}, 2);
  EXPECT_TRUE(untouched->false_loops.empty());
}

TEST_F(Robust, LocalGroupsAreOfPosesNearEachOther) {
  const DataDirectory data(at(""));
  const auto problem = attacked("CSAIL", FalseLoops{FalseLoops::Kind::local_groups, 0.5}, 1);
  ASSERT_TRUE(problem);
  EXPECT_EQ(problem->false_loops.size(), (problem->true_loops.size() + 1) / 2);
  int in_groups = 0;
  Key before[2] = {};
  for (const FactorId id : problem->false_loops) {
    const Graph::Place& place = problem->graph.place(id);
    const Key* const keys = problem->graph.batches()[place.batch]->keys(place.index);
    EXPECT_LE(keys[1].step() - keys[0].step(), 20u);
    in_groups += keys[0].step() == before[0].step() + 1 && keys[1].step() == before[1].step() + 1;
    std::copy_n(keys, 2, before);
  }
  EXPECT_GT(in_groups, static_cast<int>(problem->false_loops.size()) / 2);
  EXPECT_FALSE(attacked("intel", FalseLoops{FalseLoops::Kind::local_groups, 0.5}, 1)) << "there is no such file";
}

TEST(RobustCases, AreChosenByNameAndAWrongNameIsSaidWithThoseThereAre) {
  RunnerOptions options;
  options.graphs = {"plaza2", "goats_14"};
  for (const RobustSetting& one : robust_settings(options)) EXPECT_TRUE(one.of_ranges());
  options.kinds = {"echoes"};
  options.shares = {0.4};
  EXPECT_EQ(robust_settings(options).size(), 1u);
  options.kinds = {"echos"};
  try {
    robust_settings(options);
    FAIL();
  } catch (const BadOption& bad) {
    EXPECT_THAT(bad.what(), AllOf(HasSubstr("echos"), HasSubstr("no line of sight")));
  }
  options.methods = {"magic"};
  EXPECT_THROW(robust_methods(options), BadOption);
}

// Two methods: the first is twice as fast on the first problem and fails on the second; nobody solves the third.
TEST(Profile, SharesOfProblemsWithinAFactorOfTheBest) {
  constexpr double kFailed = std::numeric_limits<double>::infinity();
  const auto profile = performance_profile({{1, 2}, {kFailed, 5}, {kFailed, kFailed}, {3, 3}}, {1, 2});
  EXPECT_EQ(profile, (std::vector<std::vector<double>>{{0.5, 0.5}, {0.5, 0.75}}));
  EXPECT_TRUE(performance_profile({}, {1}).empty());
}

TEST_F(Robust, ARunIsScoredByErrorPrecisionAndRecallAndWritesItsProblems) {
  const DataDirectory data(at(""));
  const std::vector<std::string> ranges{"bench",  "robust",   "--graphs", "plaza2",    "--kinds",
                                        "echoes", "--shares", "0.4",      "--methods", "squared,truncated_squares,gnc-irls",
                                        "--runs", "1",        "--out",    at("out")};
  const program::Outcome run = program::holdfast_program(ranges);
  ASSERT_EQ(run.code, 0) << run.err;
  EXPECT_THAT(run.out, HasSubstr("share of 1 runs"));
  const auto lines = lines_of(at("out/robust.jsonl"));
  ASSERT_EQ(lines.size(), 3u);
  EXPECT_EQ(lines[0]["success"], false) << lines[0];
  EXPECT_EQ(lines[2]["success"], true) << lines[2];
  EXPECT_GT(lines[2]["precision"], 0.95);
  EXPECT_GT(lines[2]["recall"], 0.95);
  EXPECT_GT(lines[2]["clean_seconds"], 0);
  ASSERT_EQ(program::holdfast_program(ranges).code, 0);
  EXPECT_EQ(lines_of(at("out/robust.jsonl")).size(), 3u) << "nothing is run twice";

  const program::Outcome loops =
      program::holdfast_program({"bench", "robust", "--graphs", "CSAIL", "--kinds", "random", "--shares", "0.1", "--methods", "squared",
                                 "--runs", "1", "--out", at("out"), "--write", at("problems")});
  ASSERT_EQ(loops.code, 0) << loops.err;
  EXPECT_TRUE(std::filesystem::is_regular_file(at("problems/CSAIL_random_0.1_1.g2o")));
  EXPECT_TRUE(std::filesystem::is_regular_file(at("problems/CSAIL_random_0.1_1_clean.g2o")));
  EXPECT_THAT(program::text_of(at("problems/CSAIL_random_0.1_1.json")), HasSubstr("\"false_loops\":24"));
  EXPECT_NE(program::holdfast_program({"bench", "data", "--graphs", "CSAIL", "--out", at("out")}).code, 0);
}

}  // namespace
}  // namespace holdfast::bench
