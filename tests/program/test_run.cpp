// One run as a line of JSON: every number under its name, what is unknown null.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <holdfast/common/run.hpp>
#include <holdfast/common/table.hpp>
#include <limits>
#include <sstream>

namespace holdfast::common {
namespace {

/// Every field another number.
Run any_run() {
  Run run;
  run.task = {"a.g2o", "huber:2", "odometry", "irls", 5, {}};
  run.task.options.threads = 2;
  run.task.options.cost_tolerance = 1e-7;
  run.task.options.max_iterations = 70;
  run.task.options.time_limit = 11;
  run.summary.termination = Termination::time_limit;
  run.summary.rule = "enough";
  run.summary.cost_first = 20;
  run.summary.cost = 3;
  run.summary.gradient_norm = 0.125;
  run.summary.iterations = 9;
  run.summary.restarts = 1;
  run.summary.seconds_setup = 0.25;
  run.summary.seconds_linearize = 0.5;
  run.summary.seconds_solve = 0.75;
  run.seconds = {4, 6, 5};
  run.error = PositionError();
  run.error->ate_rmse = 0.1;
  run.error->rmse = 0.2;
  run.rejected.ranges = 40;
  run.rejected.rejected_ranges = 4;
  run.rejected.judged = 50;
  run.rejected.rejected = 5;
  run.variables = 100;
  run.factors = 200;
  return run;
}

TEST(RunLine, HoldsEveryNumberUnderItsName) {
  const Json expected = Json::parse(R"({"file": "a.g2o", "backend": "irls", "loss": "huber:2", "start": "odometry", "cost_first": 20.0,
    "cost": 3.0, "iterations": 9, "restarts": 1, "termination": "time limit", "why": "enough", "gradient_norm": 0.125, "seconds": 5.0,
    "seconds_setup": 0.25, "seconds_linearize": 0.5, "seconds_solve": 0.75, "repetitions": 3, "ate_rmse": 0.1, "rmse": 0.2,
    "rejected_ranges": 4, "ranges": 40, "rejected_factors": 5, "judged": 50,
    "variables": 100, "factors": 200, "seed": 5, "threads": 2, "tolerance": 1e-7,
    "max_iterations": 70, "time_limit": 11.0})");
  EXPECT_EQ(Json::parse(to_line(to_json(any_run()))).dump(), expected.dump());
}

TEST(RunLine, HasNoNumberOfWhatIsUnknown) {
  common::Run run = any_run();
  run.error.reset();
  run.summary.termination = Termination::failed;
  run.summary.cost = std::numeric_limits<double>::quiet_NaN();
  run.task.options.time_limit = std::numeric_limits<double>::infinity();
  const Json json = to_json(run);
  for (const char* field : {"cost", "ate_rmse", "rmse", "rejected_ranges", "ranges", "time_limit"})
    EXPECT_TRUE(json[field].is_null()) << field;
  EXPECT_EQ(json["cost_first"], 20);
}

TEST(RunLine, IsOneLineWhateverTheFileIsCalled) {
  common::Run run = any_run();
  run.task.file = "a\n\xFF.g2o";
  const std::string line = to_line(to_json(run));
  EXPECT_EQ(std::count(line.begin(), line.end(), '\n'), 1);
  EXPECT_EQ(Json::parse(line)["file"], "a\n\xEF\xBF\xBD.g2o");
}

TEST(Table, NumbersAreCellsAndColumnsAreAligned) {
  EXPECT_EQ(cell("%.2f", 1.005e2), "100.50");
  EXPECT_EQ(cell("%+.1g", 0.02), "+0.02");
  EXPECT_EQ(cell("%g", std::numeric_limits<double>::quiet_NaN()), "-");
  EXPECT_EQ(cell("%g", -std::numeric_limits<double>::infinity()), "-");
  Table table({{"name", Table::Align::left}, {"x [µs]", Table::Align::right}, {"", Table::Align::left}});
  table.add({"ceres-lm", "7", "slow"});
  table.add({"irls", "12.5", ""});
  std::ostringstream out;
  table.print(out);
  EXPECT_EQ(out.str(),
            "name      x [µs]\n"
            "ceres-lm       7  slow\n"
            "irls        12.5\n");
}

}  // namespace
}  // namespace holdfast::common
