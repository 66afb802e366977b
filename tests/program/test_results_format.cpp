// docs/results_format.md says what the program writes, and all of it.
#include <gmock/gmock.h>

#include <holdfast/solvers/table.hpp>
#include <map>
#include <set>

#include "tests/program/helpers.hpp"

namespace holdfast::program {
namespace {

using Json = nlohmann::ordered_json;

/// field → type, of the table under a heading.
std::map<std::string, std::string> table_under(const std::string& heading) {
  std::ifstream file(std::string(HOLDFAST_SOURCE_DIR) + "/docs/results_format.md");
  std::map<std::string, std::string> fields;
  bool is_here = false;
  for (std::string line; std::getline(file, line);) {
    if (line.rfind("## ", 0) == 0) is_here = line == "## " + heading;
    if (!is_here || line.rfind("| `", 0) != 0) continue;
    const std::size_t end = line.find(" | ");
    const std::string type = line.substr(end + 3, line.find(" |", end + 3) - end - 3);
    std::istringstream names(line.substr(2, end - 2));
    for (std::string name; std::getline(names, name, '`');)
      if (!name.empty() && name != ", ") fields[name] = type;
  }
  return fields;
}

std::string type_of(const Json& value) {
  if (value.is_number_integer()) return "integer";
  return value.type_name();
}

void expect_as_said(const Json& line, const std::map<std::string, std::string>& fields) {
  for (const auto& [name, type] : fields) {
    const std::string or_null = " or null", only = type.substr(0, type.find(or_null));
    const bool may_be_null = only != type;
    if (!line.contains(name)) {
      EXPECT_EQ(name, "trace") << "is written nowhere";  // a run that failed has none
      continue;
    }
    const Json& value = line[name];
    EXPECT_TRUE(type_of(value) == only || (only == "number" && value.is_number()) || (may_be_null && value.is_null()))
        << name << " is " << value << ", not " << type;
  }
}

class ResultsFormat : public InDirectory {};

TEST_F(ResultsFormat, EveryFieldOfABenchLineIsInTheTables) {
  std::map<std::string, std::string> fields = table_under("A run");
  ASSERT_GT(fields.size(), 20u);
  const std::map<std::string, std::string> run = fields;
  const auto of_bench = table_under("Of `bench` alone");
  fields.insert(of_bench.begin(), of_bench.end());
  ASSERT_EQ(holdfast_program({"bench", "scenarios", "--repetitions", "1", "--backend", "irls", "--out", at("out")}).code, kDone);
  const auto lines = lines_of(at("out/scenarios.jsonl"));
  ASSERT_FALSE(lines.empty());
  for (const Json& line : lines) {
    expect_as_said(line, fields);
    for (const char* part : {"cpu", "cores", "compiler", "holdfast", "eigen"}) EXPECT_TRUE(line["machine"].contains(part)) << part;
    for (const auto& [name, value] : line.items()) EXPECT_EQ(fields.count(name), 1u) << name << " is not in docs/results_format.md";
  }
  ASSERT_EQ(holdfast_program({"solve", "--backend", "irls", "--json", at("solve.json"), write("two.pyfg", small_pyfg())}).code, kDone);
  expect_as_said(lines_of(at("solve.json"))[0], run);
}

TEST_F(ResultsFormat, TheTraceGoesDownFromTheFirstCostToTheLast) {
  const std::vector<std::string> known = backend_names();
  const std::string backends = std::count(known.begin(), known.end(), "ceres") > 0 ? "irls,ceres" : "irls";
  ASSERT_EQ(holdfast_program({"bench", "scenarios", "--repetitions", "1", "--backend", backends, "--out", at("out")}).code, kDone);
  for (const Json& line : lines_of(at("out/scenarios.jsonl"))) {
    const Json& trace = line["trace"];
    ASSERT_GE(trace.size(), 2u) << line["backend"];
    EXPECT_NEAR(trace.front()[1].get<double>(), line["cost_first"].get<double>(), 1e-9 * line["cost_first"].get<double>());
    EXPECT_NEAR(trace.back()[1].get<double>(), line["cost"].get<double>(), 1e-6 * line["cost"].get<double>()) << line["backend"];
    for (std::size_t i = 1; i < trace.size(); ++i) {
      EXPECT_GE(trace[i][0], trace[i - 1][0]);
      EXPECT_LE(trace[i][1].get<double>(), trace[i - 1][1].get<double>() * (1 + 1e-12));
    }
  }
}

TEST_F(ResultsFormat, EveryProblemOfASuiteHasItsDrawing) {
  ASSERT_EQ(holdfast_program({"bench", "scenarios", "--repetitions", "1", "--backend", "irls", "--out", at("out")}).code, kDone);
  std::set<std::string> problems;
  for (const Json& line : lines_of(at("out/scenarios.jsonl"))) problems.insert(line["file"].get<std::string>() + line["loss"].dump());
  std::set<std::string> drawn;
  for (const auto& entry : std::filesystem::directory_iterator(at("out/drawings"))) {
    const Json drawing = lines_of(entry.path().string())[0];
    drawn.insert(drawing["file"].get<std::string>() + drawing["loss"].dump());
    EXPECT_EQ(drawing["backend"], "irls");
    EXPECT_FALSE(drawing["tracks"].empty());
    EXPECT_FALSE(drawing["ellipses"].empty()) << drawing["file"];
    EXPECT_FALSE(drawing["tracks"][0]["truth"].empty());
  }
  EXPECT_EQ(drawn, problems);
}

TEST_F(ResultsFormat, EveryFieldOfAComparisonIsInItsTable) {
  const std::string lines = write("a.jsonl", R"({"file": "p", "backend": "irls", "seconds": 1.0, "cost": 7})"
                                             "\n");
  const Outcome outcome = holdfast_program({"compare", lines, lines, "--json", "-"});
  ASSERT_EQ(outcome.code, kDone) << outcome.err;
  const Json json = Json::parse(outcome.out);
  const auto fields = table_under("Two outputs compared");
  expect_as_said(json, fields);
  EXPECT_EQ(json.size(), fields.size());
}

}  // namespace
}  // namespace holdfast::program
