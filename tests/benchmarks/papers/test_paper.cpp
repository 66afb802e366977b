// The frame of the papers' suites: every score once, every score kept, the paper's number beside ours.
#include <gmock/gmock.h>

#include <atomic>
#include <holdfast/benchmarks/papers/paper.hpp>

#include "tests/program/helpers.hpp"

namespace holdfast::bench {
namespace {

using program::InDirectory;
using program::lines_of;
using ::testing::HasSubstr;

TEST(Quantile, IsBetweenItsNeighbours) {
  EXPECT_DOUBLE_EQ(quantile({3, 1, 2}, 0.5), 2);
  EXPECT_DOUBLE_EQ(quantile({0, 10}, 0.1), 1);
  EXPECT_DOUBLE_EQ(quantile({5}, 0.9), 5);
  EXPECT_TRUE(std::isnan(quantile({}, 0.5)));
}

class Papers : public InDirectory {
 protected:
  std::atomic<int> runs_{0};
  std::ostringstream out_, err_;
  Terminal terminal_{out_, err_, false};

  /// Errors are column + seed, and ten times that.
  PaperTable table() {
    return {"Table I", "made up", {"calm", "rough"}, {{"theirs", {1.5}}, {"ours"}}, [this](std::size_t column, unsigned seed) {
              ++runs_;
              const double error = static_cast<double>(column) + seed;
              return std::vector<Score>{{error, 1}, {10 * error, 2, {{"anees", 0.9}}}};
            }};
  }
  bool run(unsigned seed, unsigned runs, int threads = 1) {
    RunnerOptions options;
    options.seed = seed;
    options.runs = runs;
    options.solver.threads = threads;
    Journal journal(at("papers.jsonl"));
    return run_tables("papers", {table()}, options, journal, terminal_);
  }
};

TEST_F(Papers, PrintMedianAndBandBesideThePapersNumber) {
  EXPECT_TRUE(run(1, 3));
  EXPECT_THAT(out_.str(), HasSubstr("theirs: paper"));
  EXPECT_THAT(out_.str(), HasSubstr("1.5"));
  EXPECT_THAT(out_.str(), HasSubstr("3 (2.2-3.8)"));
  EXPECT_THAT(out_.str(), HasSubstr("20 (12-28)"));
  EXPECT_THAT(out_.str(), HasSubstr("anees"));
  EXPECT_THAT(out_.str(), HasSubstr("0.9 (0.9-0.9)"));
}

TEST_F(Papers, KeepEveryScoreAndGoOnWhereTheyWereKilled) {
  run(1, 2);
  EXPECT_EQ(runs_, 4);
  const auto lines = lines_of(at("papers.jsonl"));
  ASSERT_EQ(lines.size(), 8u);
  EXPECT_EQ(lines[3]["row"], "ours");
  EXPECT_EQ(lines[3]["column"], "rough");
  EXPECT_EQ(lines[3]["error"], 20.0);
  EXPECT_EQ(lines[3]["more"]["anees"], 0.9);
  run(1, 3, 2);
  EXPECT_EQ(runs_, 6);
  EXPECT_EQ(lines_of(at("papers.jsonl")).size(), 12u);
}

TEST_F(Papers, CountAnEstimatorThatThrowsAndKeepTheOthers) {
  using Number = double;
  const PaperTable broken = table_of<Number>("Table I", "made up", {"calm", "rough"},
                                             [](std::size_t column, unsigned seed) { return static_cast<double>(10 * column + seed); },
                                             {{{{"theirs"}},
                                               [](const Number& x) {
                                                 return std::vector<Score>{{x, 1}};
                                               }},
                                              {{{"ours"}, {"ours, later"}}, [](const Number& x) {
                                                 if (x == 12) fail<BadNumber>("twelve is too much");
                                                 return std::vector<Score>{{2 * x, 1}, {3 * x, 1}};
                                               }}});
  RunnerOptions options;
  options.seed = 1;
  options.runs = 3;
  Journal journal(at("papers.jsonl"));
  EXPECT_FALSE(run_tables("papers", {broken}, options, journal, terminal_));
  EXPECT_THAT(out_.str(), HasSubstr("12 (11.2-12.8)"));            // theirs, rough: 11, 12, 13
  EXPECT_THAT(out_.str(), HasSubstr("24 (22.4-25.6), 1 failed"));  // ours, rough: 22 and 26
  EXPECT_THAT(out_.str(),
              HasSubstr("FAILED: ours, later, rough: 1 of 3 runs, the first with seed 2: holdfast::BadNumber: twelve is too much"));
  const auto lines = lines_of(at("papers.jsonl"));
  ASSERT_EQ(lines.size(), 18u);
  EXPECT_EQ(std::count_if(lines.begin(), lines.end(), [](const Json& line) { return line.contains("failure"); }), 2);
}

TEST_F(Papers, CountAScenarioThatThrowsInEveryRow) {
  PaperTable broken = table();
  broken.run = [](std::size_t, unsigned) -> std::vector<Score> { throw std::runtime_error("no target"); };
  Journal journal(at("papers.jsonl"));
  EXPECT_FALSE(run_tables("papers", {broken}, {}, journal, terminal_));
  EXPECT_THAT(out_.str(), HasSubstr("FAILED: theirs, calm: 20 of 20 runs"));
  EXPECT_THAT(out_.str(), HasSubstr("std::runtime_error: no target"));
}

// 2 runs of 4 errors with 2 components: 1 ± 1.96 √(2/16).
TEST_F(Papers, PrintWhereAConsistentEstimatorWouldBe) {
  PaperTable sure = table();
  sure.run = [](std::size_t, unsigned seed) {
    std::vector<Score> scores(2, {1, 1});
    scores[1].consistency(seed == 1 ? 0.9 : 1.2, 8);
    return scores;
  };
  RunnerOptions options;
  options.seed = 1;
  options.runs = 2;
  Journal journal(at("papers.jsonl"));
  EXPECT_TRUE(run_tables("papers", {sure}, options, journal, terminal_));
  EXPECT_THAT(out_.str(), HasSubstr("1.05 (0.9-1.2); 95 %: 0.307-1.693"));
}

TEST_F(Papers, RunNoMoreSeedsThanATableWants) {
  PaperTable short_one = table();
  short_one.most_runs = 2;
  short_one.tracks = [](unsigned) { return Json{{"truth", track_of({{0, 0}, {1, 1}, {2.004, 3}}, 2)}}; };
  Journal journal(at("papers.jsonl"));
  run_tables("papers", {short_one}, {}, journal, terminal_);
  EXPECT_EQ(runs_, 4);
  EXPECT_THAT(out_.str(), HasSubstr("of 2 runs"));
  const auto lines = lines_of(at("papers.jsonl"));
  EXPECT_EQ(lines.back()["tracks"]["truth"].dump(), "[[0.0,0.0],[2.0,3.0]]");
}

TEST_F(Papers, SayWhenAnEstimatorFailed) {
  PaperTable broken = table();
  broken.run = [](std::size_t, unsigned) { return std::vector<Score>(2, {std::nan(""), 1}); };
  Journal journal(at("papers.jsonl"));
  EXPECT_FALSE(run_tables("papers", {broken}, {}, journal, terminal_));
}

}  // namespace
}  // namespace holdfast::bench
