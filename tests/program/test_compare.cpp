// `holdfast compare`: pairs, what is faster, what is worse, and how sure that is.
#include <gmock/gmock.h>

#include <holdfast/program/comparison.hpp>

#include "tests/program/helpers.hpp"

namespace holdfast::program {
namespace {

using ::testing::HasSubstr;

Json run_line(int problem, double seconds, double cost = 7, const std::string& termination = "converged") {
  return {{"file", "p" + std::to_string(problem)}, {"backend", "irls"}, {"seconds", seconds}, {"cost", cost}, {"termination", termination}};
}

/// Twenty problems of all sizes, each `factor` as fast within a tenth; another `day`, other noise.
std::vector<Json> runs(double factor, int day) {
  std::vector<Json> lines;
  for (int i = 0; i < 20; ++i)
    lines.push_back(run_line(i, std::pow(10.0, i % 4 - 3) * factor * (1 + 0.1 * std::sin(7.0 * i + day * (1 + i % 3)))));
  return lines;
}

TEST(Comparison, TheRatioIsTheGeometricMeanOfThePairs) {
  const Comparison found = compare({run_line(1, 1), run_line(2, 10)}, {run_line(2, 80), run_line(1, 2)});
  ASSERT_EQ(found.groups.size(), 1u);
  EXPECT_EQ(found.groups[0].name, "irls");
  EXPECT_EQ(found.groups[0].pairs, 2);
  EXPECT_NEAR(found.groups[0].ratio, 4, 1e-12);  // √(2 · 8)
  EXPECT_EQ(found.groups[0].speed, Speed::too_few);
}

TEST(Comparison, NoiseIsNoDifferenceAndAThirdLessIs) {
  const std::vector<Json> before = runs(1, 1);
  EXPECT_EQ(compare(before, before).groups[0].speed, Speed::open);
  EXPECT_EQ(compare(before, runs(1, 2)).groups[0].speed, Speed::open);
  const GroupChange faster = compare(before, runs(0.67, 2)).groups[0];
  EXPECT_EQ(faster.speed, Speed::faster);
  EXPECT_LT(faster.low, 0.67);
  EXPECT_GT(faster.high, 0.67);
  EXPECT_EQ(compare(before, runs(1.5, 2)).groups[0].speed, Speed::slower);
}

TEST(Comparison, TheIntervalIsThatOfAMeanOfLogarithms) {
  std::vector<Json> before, after;
  double squares = 0;
  constexpr int kPairs = 200;
  for (int i = 0; i < kPairs; ++i) {
    const double log = i % 2 == 0 ? 0.3 : -0.3;
    squares += log * log;
    before.push_back(run_line(i, 1));
    after.push_back(run_line(i, std::exp(log)));
  }
  const GroupChange group = compare(before, after).groups[0];
  const double expected = 1.96 * std::sqrt(squares / kPairs / kPairs);
  EXPECT_NEAR(std::log(group.high), expected, 0.1 * expected);
  EXPECT_NEAR(std::log(group.low), -expected, 0.1 * expected);
}

TEST(Comparison, CostsAndFailuresAreCountedApartFromTime) {
  const Comparison found = compare(
      {run_line(1, 1, 7), run_line(2, 1, 7), run_line(3, 1, 7), run_line(4, 1, 7), run_line(5, 1, 7, "failed")},
      {run_line(1, 1, 6), run_line(2, 1, 7 + 1e-9), run_line(3, 1, 8), run_line(4, 9, 7, "failed"), run_line(5, 1, 7), run_line(6, 1, 7)});
  const GroupChange& group = found.groups[0];
  EXPECT_EQ(group.lower, 1);
  EXPECT_EQ(group.equal, 1);
  EXPECT_EQ(group.higher, 1);
  EXPECT_EQ(group.newly_failed, 1);
  EXPECT_EQ(group.newly_solved, 1);
  EXPECT_EQ(group.timed, 3);  // a failure's time says nothing
  EXPECT_THAT(found.worse, ::testing::ElementsAre(HasSubstr("p3"), HasSubstr("p4")));
  EXPECT_EQ(found.only_b, 1u);
  EXPECT_TRUE(found.is_worse());
}

class Compare : public InDirectory {
 protected:
  std::string write_lines(const std::string& name, const std::vector<Json>& lines) {
    std::string text;
    for (const Json& line : lines) text += line.dump() + "\n";
    return write(name, text);
  }
};

TEST_F(Compare, SaysItInATableInJsonAndByItsCode) {
  const std::string a = write_lines("a.jsonl", runs(1, 1)), b = write_lines("b.jsonl", runs(2, 2));
  const Outcome outcome = holdfast_program({"compare", a, b});
  EXPECT_EQ(outcome.code, kDone) << outcome.err;
  EXPECT_THAT(outcome.out, HasSubstr("slower"));
  EXPECT_EQ(holdfast_program({"compare", a, b, "--strict"}).code, kFailed);
  EXPECT_EQ(holdfast_program({"compare", b, a, "--strict"}).code, kDone);
  const Json json = Json::parse(holdfast_program({"compare", a, b, "--json", "-"}).out);
  EXPECT_EQ(json["speed"], "slower");
  EXPECT_EQ(json["pairs"], 20);
}

TEST_F(Compare, OfAFileOnlyTheNewestCommitCounts) {
  Json old_line = run_line(1, 100), new_line = run_line(1, 1);
  old_line["commit"] = "old";
  new_line["commit"] = "new";
  const std::string a = write_lines("a.jsonl", {old_line, new_line}), b = write_lines("b.jsonl", {run_line(1, 3)});
  EXPECT_NEAR(Json::parse(holdfast_program({"compare", a, b, "--json", "-"}).out)["ratio"].get<double>(), 3, 1e-12);
}

TEST_F(Compare, BenchWithItselfIsEqual) {
  for (const std::string out : {"a", "b"})
    ASSERT_EQ(holdfast_program({"bench", "scenarios", "--backend", "irls", "--repetitions", "1", "--out", at(out)}).code, kDone);
  const Json json = Json::parse(holdfast_program({"compare", at("a"), at("b"), "--json", "-"}).out);
  EXPECT_EQ(json["pairs"], 8);
  EXPECT_EQ(json["costs_equal"], 8);
  EXPECT_EQ(json["costs_higher"], 0);
}

TEST_F(Compare, NamesWhatItCannotUse) {
  const std::string a = write_lines("a.jsonl", {run_line(1, 1)}), other = write_lines("c.jsonl", {run_line(2, 1)});
  EXPECT_THAT(holdfast_program({"compare", a, at("absent")}).err, HasSubstr("absent"));
  EXPECT_THAT(holdfast_program({"compare", a, write("bad.jsonl", "{}\n[1]\n")}).err, HasSubstr("bad.jsonl:2"));
  EXPECT_THAT(holdfast_program({"compare", a, other}).err, HasSubstr("no run in common"));
  std::filesystem::create_directory(at("empty"));
  EXPECT_EQ(holdfast_program({"compare", a, at("empty")}).code, kFailed);
}

}  // namespace
}  // namespace holdfast::program
