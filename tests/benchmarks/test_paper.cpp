// The frame of the papers' suites: every score once, every score kept, the paper's number beside ours.
#include <gmock/gmock.h>

#include <atomic>
#include <holdfast/benchmarks/papers/paper.hpp>

#include "cli_helpers.hpp"

namespace holdfast::bench {
namespace {

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

TEST_F(Papers, SayWhenAnEstimatorFailed) {
  PaperTable broken = table();
  broken.run = [](std::size_t, unsigned) { return std::vector<Score>(2, {std::nan(""), 1}); };
  Journal journal(at("papers.jsonl"));
  EXPECT_FALSE(run_tables("papers", {broken}, {}, journal, terminal_));
}

}  // namespace
}  // namespace holdfast::bench
