// The races of `holdfast bench` and what they run on.
#include <gmock/gmock.h>

#include <cstdlib>
#include <holdfast/benchmarks/race.hpp>
#include <holdfast/factors/between.hpp>

#include "tests/program/helpers.hpp"

namespace holdfast::bench {
namespace {

using program::InDirectory;
using program::lines_of;
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

}  // namespace
}  // namespace holdfast::bench
