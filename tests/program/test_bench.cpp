#include <gmock/gmock.h>

#include <cstdlib>
#include <holdfast/benchmarks/bench_runner.hpp>
#include <holdfast/benchmarks/scenarios/scenario.hpp>
#include <set>

#include "tests/program/helpers.hpp"

namespace holdfast::program {
namespace {

using ::testing::HasSubstr;

class Bench : public InDirectory {};

std::vector<Case> two_cases(unsigned seed) {
  const auto small = [seed] {
    UnicycleOptions options;
    options.states = 6;
    options.dt = 0.5;
    return unicycle(options, seed);
  };
  return {{"small", "huber:2:component", "measurements", small},
          {"twenty", "squared", "anywhere", [seed] { return swarm(20, seed); }},
          {"lost", "squared", "file", {}, "there is no such file"},
          {"broken", "squared", "file", []() -> Instance { fail<BadFile>("line 3 is cut"); }}};
}
const Suite kSuite{"two", "two small cases", true, 10000, two_cases};

RunnerOptions quick() {
  RunnerOptions options;
  options.backends = {"irls", "nesterov"};
  options.solver.cost_tolerance = 1e-8;
  options.repetitions = 2;
  return options;
}

SuiteResult run_two(const std::string& path, const RunnerOptions& options) {
  Journal journal(path);
  std::ostringstream out, err;
  Terminal terminal{out, err, false};
  ProgressBar bar(terminal, 4);
  Runner runner(kSuite, kSuitePolicy, options, journal, bar);
  SuiteResult result;
  for (const Case& one : kSuite.cases(options.seed)) runner.run(one, entrants_of(options.backends, 1), result);
  return result;
}

/// Everything but times.
std::set<std::string> facts(const std::vector<Json>& lines) {
  std::set<std::string> all;
  for (Json line : lines) {
    for (const char* field : {"seconds", "seconds_setup", "seconds_linearize", "seconds_solve", "repetitions"}) line.erase(field);
    if (line.contains("trace"))
      for (Json& point : line["trace"]) point.erase(0);  // its seconds
    all.insert(line.dump());
  }
  return all;
}

TEST_F(Bench, RunsEveryCaseUnderEveryBackEnd) {
  const SuiteResult result = run_two(at("two.jsonl"), quick());
  ASSERT_EQ(result.lines.size(), 4u);
  for (const Json& line : result.lines) {
    EXPECT_EQ(line["termination"], "converged") << line;
    EXPECT_TRUE(line["ate_rmse"].is_number());
    EXPECT_EQ(line["repetitions"], 2);
    EXPECT_FALSE(line["commit"].get<std::string>().empty());
    EXPECT_GE(line["machine"]["cores"], 1);
    EXPECT_EQ(line["seed"], 1);
  }
  EXPECT_EQ(result.taken, 0u);
  EXPECT_THAT(result.skipped, ::testing::ElementsAre(HasSubstr("there is no such file")));
  EXPECT_THAT(result.broken, ::testing::ElementsAre(HasSubstr("line 3 is cut")));
  EXPECT_EQ(facts(lines_of(at("two.jsonl"))), facts(result.lines));
}

TEST_F(Bench, GoesOnWhereItWasKilled) {
  const std::string path = at("two.jsonl");
  const auto whole = facts(run_two(path, quick()).lines);
  const std::string text = text_of(path);
  for (const std::size_t kept : {text.size(), text.size() - 1, text.size() / 2, text.find('\n') + 1, std::size_t{7}, std::size_t{0}}) {
    write("two.jsonl", text.substr(0, kept));
    const auto complete_lines = static_cast<std::size_t>(std::count(text.begin(), text.begin() + static_cast<std::ptrdiff_t>(kept), '\n'));
    const SuiteResult again = run_two(path, quick());
    EXPECT_EQ(again.taken, complete_lines);
    EXPECT_EQ(facts(again.lines), whole);
    EXPECT_EQ(lines_of(path).size(), 4u) << "nothing twice, nothing torn";
    EXPECT_EQ(facts(lines_of(path)), whole);
  }
}

TEST_F(Bench, RunsAgainUnderOtherOptions) {
  const std::string path = at("two.jsonl");
  run_two(path, quick());
  RunnerOptions other = quick();
  other.seed = 2;
  EXPECT_EQ(run_two(path, other).taken, 0u);
  other.solver.cost_tolerance = 1e-7;
  EXPECT_EQ(run_two(path, other).taken, 0u);
  other.backends = {"irls"};
  EXPECT_EQ(run_two(path, other).taken, 2u);
  other.fresh = true;
  EXPECT_EQ(run_two(path, other).taken, 0u);
}

TEST_F(Bench, ARunIsThereAlreadyOnlyWhereAllOfTheQuestionIsTheSame) {
  const auto small = [] { return swarm(20, 1); };
  const Suite suite{"a suite", "", false, 100, {}};
  const Case one{"swarm", "squared", "anywhere", small};
  RunnerOptions options;
  options.repetitions = 1;
  std::ostringstream out, err;
  Terminal terminal{out, err, false};
  ProgressBar bar(terminal, 10);
  Journal journal(at("all.jsonl"));
  const auto taken = [&](const Suite& of, const Case& what, const RunnerOptions& how, int threads = 1) {
    SuiteResult result;
    Runner(of, kSuitePolicy, how, journal, bar).run(what, {{"irls", threads}}, result);
    EXPECT_EQ(result.lines.size(), 1u);
    return result.taken;
  };
  EXPECT_EQ(taken(suite, one, options), 0u);
  EXPECT_EQ(taken(suite, one, options), 1u);
  EXPECT_EQ(taken(suite, one, options, 2), 0u) << "threads";
  EXPECT_EQ(taken({"another", "", false, 100, {}}, one, options), 0u) << "suite";
  EXPECT_EQ(taken({"a suite", "", false, 99, {}}, one, options), 0u) << "iterations";
  EXPECT_EQ(taken(suite, {"school", "squared", "anywhere", small}, options), 0u) << "file";
  EXPECT_EQ(taken(suite, {"swarm", "huber:2", "anywhere", small}, options), 0u) << "loss";
  EXPECT_EQ(taken(suite, {"swarm", "squared", "elsewhere", small}, options), 0u) << "start";
  RunnerOptions slow = options;
  slow.solver.time_limit = 5;
  EXPECT_EQ(taken(suite, one, slow), 0u) << "time limit";
  EXPECT_EQ(taken(suite, one, options), 1u);
}

TEST_F(Bench, GivesTheSameNumbersForTheSameSeed) {
  const auto first = facts(run_two(at("a.jsonl"), quick()).lines), second = facts(run_two(at("b.jsonl"), quick()).lines);
  EXPECT_EQ(first, second);
}

TEST_F(Bench, RefusesWhatMakesNoSense) {
  const Outcome suite = holdfast_program({"bench", "nothing", "--out", at("out")});
  EXPECT_EQ(suite.code, kUsage);
  EXPECT_THAT(suite.err, HasSubstr("scenarios"));
  EXPECT_EQ(holdfast_program({"bench", "scenarios", "--backend", "nothing", "--out", at("out")}).code, kUsage);
  EXPECT_EQ(holdfast_program({"bench", "scenarios", "--repetitions", "0", "--out", at("out")}).code, kUsage);
  EXPECT_FALSE(std::filesystem::exists(at("out")));
  EXPECT_EQ(holdfast_program({"bench", "data", "--out", write("file", "")}).code, kFailed);
}

TEST_F(Bench, SaysWhatItSkipsWithoutData) {
  const char* before = std::getenv("HOLDFAST_DATA");
  const std::string saved = before == nullptr ? "" : before;
  ::setenv("HOLDFAST_DATA", at("empty").c_str(), 1);
  const Outcome outcome = holdfast_program({"bench", "data", "--out", at("out")});
  before == nullptr ? ::unsetenv("HOLDFAST_DATA") : ::setenv("HOLDFAST_DATA", saved.c_str(), 1);
  EXPECT_EQ(outcome.code, kDone) << outcome.err;
  EXPECT_THAT(outcome.out, HasSubstr("skipped range/plaza2.pyfg (huber:2)"));
  EXPECT_THAT(outcome.out, HasSubstr("Same start, same cost function"));
}

}  // namespace
}  // namespace holdfast::program
