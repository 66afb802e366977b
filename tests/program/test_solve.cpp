#include <gmock/gmock.h>

#include <algorithm>
#include <cstdio>
#include <holdfast/solvers/backend.hpp>

#include "tests/program/helpers.hpp"

namespace holdfast::program {
namespace {

using ::testing::HasSubstr;
using ::testing::Not;

class Solve : public InDirectory {};

TEST_F(Solve, WritesOneObjectARunWithEveryField) {
  const std::string file = write("two.pyfg", small_pyfg()), json = at("runs.jsonl");
  const Outcome outcome = holdfast_program({"solve", file, "--backend", "irls,nesterov", "--loss", "huber:2", "--start", "odometry",
                                            "--tolerance", "1e-10", "--seed", "4", "--json", json});
  EXPECT_EQ(outcome.code, kDone) << outcome.err;
  const auto lines = lines_of(json);
  ASSERT_EQ(lines.size(), 2u);
  for (const auto& line : lines)
    for (const char* field :
         {"file",    "backend",  "loss",      "start",        "cost_first", "cost",          "iterations",      "termination",
          "seconds", "ate_rmse", "variables", "factors",      "why",        "gradient_norm", "rejected_ranges", "ranges",
          "seed",    "threads",  "tolerance", "seconds_setup"})
      EXPECT_TRUE(line.contains(field)) << field;
  EXPECT_EQ(lines[0]["file"], file);
  EXPECT_EQ(lines[0]["backend"], "irls");
  EXPECT_EQ(lines[1]["backend"], "nesterov");
  EXPECT_EQ(lines[0]["loss"], "huber:2");
  EXPECT_EQ(lines[0]["start"], "odometry");
  EXPECT_EQ(lines[0]["termination"], "converged");
  EXPECT_EQ(lines[0]["variables"], 11);
  EXPECT_EQ(lines[0]["factors"], 8 + 15 + 2);  // odometry, ranges, the priors that hold the two robots
  EXPECT_EQ(lines[0]["ranges"], 15);
  EXPECT_EQ(lines[0]["rejected_ranges"], 1);  // the one of 30 m
  EXPECT_EQ(lines[0]["seed"], 4);
  EXPECT_LT(lines[0]["cost"], lines[0]["cost_first"]);
  EXPECT_LT(lines[0]["ate_rmse"], 0.3);
  EXPECT_NEAR(lines[0]["cost"], lines[1]["cost"], 1e-5 * lines[0]["cost"].get<double>());
}

/// Anchors in one plane and the start in it (cases/coplanar_in_plane): stationary at 58.5 across the plane.
TEST_F(Solve, LeavesASaddle) {
  std::ostringstream text;
  const double corners[4][2] = {{0, 0}, {10, 0}, {10, 8}, {0, 8}};
  for (int i = 0; i < 4; ++i)
    text << "VERTEX_XYZ L" << i << ' ' << corners[i][0] << ' ' << corners[i][1] << " 2.5\nVERTEX_XYZ:PRIOR 0 L" << i << ' ' << corners[i][0]
         << ' ' << corners[i][1] << " 2.5 0.0001 0 0 0.0001 0 0.0001\n";
  const double ranges[3][4] = {
      {4.779121, 7.927168, 8.879189, 6.232175}, {6.576473, 6.576473, 6.576473, 6.576473}, {7.549834, 4.123106, 7.000000, 9.433981}};
  const double starts[3][2] = {{3, 3}, {5, 4}, {7, 2}};
  for (int p = 0; p < 3; ++p) {
    text << "VERTEX_XYZ P" << p << ' ' << starts[p][0] << ' ' << starts[p][1] << " 2.5\n";
    for (int i = 0; i < 4; ++i) text << "EDGE_RANGE 0 P" << p << " L" << i << ' ' << ranges[p][i] << " 0.01\n";
  }
  const std::string file = write("plane.pyfg", text.str()), json = at("runs.jsonl");
  const Outcome left = holdfast_program({"solve", file, "--backend", "irls,nesterov", "--json", json});
  EXPECT_EQ(left.code, kDone) << left.err;
  EXPECT_THAT(left.out, HasSubstr("irls left a saddle"));
  const auto lines = lines_of(json);
  ASSERT_EQ(lines.size(), 2u);
  EXPECT_LT(lines[0]["cost"], 1e-6);
  EXPECT_LT(lines[1]["cost"], 0.1);
  for (const auto& line : lines) EXPECT_EQ(line["minimum"], "left a saddle");
  const Outcome stuck = holdfast_program({"solve", file, "--backend", "irls", "--no-second-order", "--json", json});
  EXPECT_EQ(stuck.code, kDone) << stuck.err;
  EXPECT_GT(lines_of(json)[0]["cost"], 58);
  EXPECT_EQ(lines_of(json)[0]["minimum"], "not checked");
}

TEST_F(Solve, PrintsARowABackEnd) {
  const Outcome outcome = holdfast_program({"solve", write("two.pyfg", small_pyfg()), "--loss", "huber:2"});
  EXPECT_EQ(outcome.code, kDone) << outcome.err;
  for (const char* text : {"first cost", "ATE [m]", "rejected", "irls", "nesterov", "converged", "1/15", "loss huber:2"})
    EXPECT_THAT(outcome.out, HasSubstr(text));
  EXPECT_THAT(outcome.out, Not(HasSubstr("ceres-lm")));
  EXPECT_EQ(outcome.err, "");
}

TEST_F(Solve, StartsFromNothing) {
  std::ostringstream points;  // the vertices are worth nothing: what is known are the priors and the ranges
  for (int i = 0; i < 5; ++i) points << "VERTEX_XY L" << i << " 1000 -1000\n";
  const double corners[4][2] = {{0, 0}, {10, 0}, {10, 10}, {0, 10}};
  for (int i = 0; i < 4; ++i) {
    points << "VERTEX_XY:PRIOR 0 L" << i << ' ' << corners[i][0] << ' ' << corners[i][1] << " 0.0001 0 0.0001\n";
    points << "EDGE_RANGE 0 L4 L" << i << ' ' << std::hypot(corners[i][0] - 3, corners[i][1] - 4) << " 0.01\n";
  }
  const std::string json = at("runs.jsonl");
  const Outcome outcome =
      holdfast_program({"solve", write("points.pyfg", points.str()), "--start", "convex", "--backend", "irls,nesterov", "--json", json});
  EXPECT_EQ(outcome.code, kDone) << outcome.err;
  for (const char* text : {"start convex", "at the centroid; convex problem"}) EXPECT_THAT(outcome.out, HasSubstr(text));
  for (const auto& line : lines_of(json)) {
    EXPECT_EQ(line["start"], "convex");
    EXPECT_LT(line["cost"], 1e-6);
  }
  const Outcome poses = holdfast_program({"solve", write("two.pyfg", small_pyfg()), "--start", "convex", "--backend", "irls"});
  EXPECT_EQ(poses.code, kDone) << poses.err;
  EXPECT_THAT(poses.out, HasSubstr("at the centroid; partly relaxed problem"));
}

TEST_F(Solve, CertifiesASquareAndNotRanges) {
  const std::string json = at("runs.jsonl");
  const Outcome square = holdfast_program(
      {"solve", write("square.g2o", small_g2o()), "--backend", "irls", "--certify", "--json", json, "--tolerance", "1e-12"});
  EXPECT_EQ(square.code, kDone) << square.err;
  for (const char* text : {"certificate, irls: global minimum", "bound", "gap"}) EXPECT_THAT(square.out, HasSubstr(text));
  const auto line = lines_of(json).at(0);
  EXPECT_EQ(line["certificate"], "global minimum");
  EXPECT_NEAR(line["bound"], line["cost"], 1e-7 * line["cost"].get<double>());
  const Outcome ranges = holdfast_program({"solve", write("two.pyfg", small_pyfg()), "--backend", "irls", "--certify"});
  EXPECT_THAT(ranges.out, HasSubstr("not certified"));
  EXPECT_THAT(ranges.out, HasSubstr("count as 0 in the bound"));
}

TEST_F(Solve, LeavesOutLoopsThatDisagree) {
  std::ostringstream text;  // along a line and back: every pose is seen again; three loops see another place
  const auto edge = [&](int i, int j, double x) { text << "EDGE_SE2 " << i << ' ' << j << ' ' << x << " 0 0 400 0 0 400 0 4000\n"; };
  for (int i = 0; i < 20; ++i) edge(i, i + 1, i < 10 ? 1 : -1);
  for (int i = 0; i < 9; ++i) edge(i, 20 - i, 0.01 * (i % 3));
  for (int i = 2; i < 5; ++i) edge(i, i + 12, 9 - 2 * i);
  const std::string json = at("runs.jsonl");
  const Outcome outcome =
      holdfast_program({"solve", write("line.g2o", text.str()), "--backend", "irls", "--pcm", "--tolerance", "1e-10", "--json", json});
  EXPECT_EQ(outcome.code, kDone) << outcome.err;
  EXPECT_THAT(outcome.out, HasSubstr("pcm: 9 of 12 loops agree"));
  EXPECT_THAT(outcome.out, HasSubstr("rejected: Between(x2, x14), Between(x3, x15), Between(x4, x16)"));
  const auto line = lines_of(json).at(0);
  EXPECT_EQ(line["pcm_rejected"], 3);
  EXPECT_LT(line["cost"], 1);
  EXPECT_THAT(outcome.out, Not(HasSubstr("over all measurements")));  // squared: the cost over all loops says nothing
  const Outcome judged = holdfast_program({"solve", at("line.g2o"), "--backend", "irls", "--gnc", "--pcm"});
  EXPECT_EQ(judged.code, kDone) << judged.err;
  EXPECT_THAT(judged.out, HasSubstr("pcm, gnc-irls: over all measurements the cost is "));
}

TEST_F(Solve, LeavesOutRangesThatDisagree) {
  std::ostringstream text;  // along an arc, a beacon in sight; every fourth range is an echo
  text << "VERTEX_XY L0 4 9\n";
  double x = 0, y = 0, turn = 0;
  for (int k = 0; k < 40; ++k) {
    text << "VERTEX_SE2 " << k << " A" << k << ' ' << x << ' ' << y << ' ' << turn << '\n';
    if (k > 0) text << "EDGE_SE2 " << k << " A" << k - 1 << " A" << k << " 0.5 0 0.05 1e-4 0 0 1e-4 0 1e-5\n";
    text << "EDGE_RANGE " << k << " A" << k << " L0 " << std::hypot(4 - x, 9 - y) + (k % 4 == 1 ? 3 + 0.2 * k : 0.0) << " 0.1\n";
    x += 0.5 * std::cos(turn);
    y += 0.5 * std::sin(turn);
    turn += 0.05;
  }
  const std::string json = at("runs.jsonl");
  const Outcome outcome = holdfast_program({"solve", write("arc.pyfg", text.str()), "--backend", "irls", "--pcm", "--json", json});
  EXPECT_EQ(outcome.code, kDone) << outcome.err;
  EXPECT_THAT(outcome.out, HasSubstr("pcm: 30 of 40 ranges agree"));
  EXPECT_EQ(lines_of(json).at(0)["pcm_rejected"], 10);
  EXPECT_LT(lines_of(json).at(0)["cost"], 1);
}

// Odometry that slips by far more than its sigma makes good loops disagree: the filter rejects some of them.
TEST_F(Solve, WithPcmTheLowerCostOverAllLoopsIsTheAnswer) {
  struct Slipping {
    std::vector<int> at;
    double by;
    int every, span;
    bool filter_harms;
  };
  const double kCost = 0.5 * 11.3449;  // of a rejected loop: half the χ² of three components that 1 % exceed
  for (const Slipping& one : {Slipping{{5, 10}, 0.5, 1, 12, true}, Slipping{{5, 10, 15}, 0.6, 2, 8, false}}) {
    std::ostringstream text;
    const auto edge = [&](int i, int j, double x) { text << "EDGE_SE2 " << i << ' ' << j << ' ' << x << " 0 0 400 0 0 400 0 10000\n"; };
    for (int i = 0; i < 30; ++i) text << "VERTEX_SE2 " << i << ' ' << i << " 0 0\n";
    for (int i = 0; i < 29; ++i) edge(i, i + 1, std::count(one.at.begin(), one.at.end(), i) > 0 ? 1 + one.by : 1);
    for (int i = 0; i + one.span < 30; i += one.every) edge(i, i + one.span, one.span);
    const std::string json = at("runs.jsonl");
    const Outcome outcome =
        holdfast_program({"solve", write("slips.g2o", text.str()), "--backend", "irls", "--gnc", "--pcm", "--json", json});
    EXPECT_EQ(outcome.code, kDone) << outcome.err;
    const std::string said = "over all measurements the cost is ";
    ASSERT_THAT(outcome.out, HasSubstr(said));
    double with_pcm = 0, without = 0;
    ASSERT_EQ(std::sscanf(outcome.out.c_str() + outcome.out.find(said) + said.size(), "%lf with it and %lf without", &with_pcm, &without),
              2);
    EXPECT_EQ(without < with_pcm, one.filter_harms) << outcome.out;
    const auto line = lines_of(json).at(0);
    const int left_out = line["pcm_rejected"];
    EXPECT_EQ(left_out == 0, one.filter_harms) << outcome.out;
    EXPECT_NEAR(line["cost"].get<double>() + kCost * left_out, std::min(with_pcm, without), 1e-3) << outcome.out;
  }
}

TEST_F(Solve, KnowsNoTruthInG2o) {
  const std::string json = at("runs.jsonl");
  EXPECT_EQ(holdfast_program({"solve", write("square.g2o", small_g2o()), "--backend", "irls", "--json", json}).code, kDone);
  const auto lines = lines_of(json);
  ASSERT_EQ(lines.size(), 1u);
  EXPECT_TRUE(lines[0]["ate_rmse"].is_null());
  EXPECT_EQ(lines[0]["loss"], "squared");
  EXPECT_EQ(lines[0]["start"], "file");
  EXPECT_EQ(lines[0]["ranges"], 0);
}

TEST_F(Solve, GivesTheSameNumbersAgain) {
  const std::string file = write("two.pyfg", small_pyfg());
  std::vector<std::string> runs;
  for (const char* threads : {"1", "2"}) {
    const std::string json = at(std::string("runs") + threads);
    holdfast_program({"solve", file, "--backend", "irls,nesterov", "--start", "odometry", "--threads", threads, "--json", json});
    std::string numbers;
    for (auto line : lines_of(json)) numbers += line["cost"].dump() + line["ate_rmse"].dump() + line["iterations"].dump() + ' ';
    runs.push_back(numbers);
  }
  EXPECT_EQ(runs[0], runs[1]);
}

TEST_F(Solve, WritesTrajectoriesByBackEndAndAgent) {
  const std::string file = write("two.pyfg", small_pyfg());
  EXPECT_EQ(holdfast_program({"solve", file, "--backend", "irls", "--tum", at("tum")}).code, kDone);
  for (const char* agent : {"A", "B"}) {
    const std::string text = text_of(at(std::string("tum/two_irls/") + agent + ".tum"));
    EXPECT_EQ(std::count(text.begin(), text.end(), '\n'), 5) << agent;
  }
}

TEST_F(Solve, KeepsTrajectoriesOfFilesOfOneNameApart) {
  std::filesystem::create_directories(at("a"));
  std::filesystem::create_directories(at("b"));
  const std::string one = write("a/two.pyfg", small_pyfg()), other = write("b/two.pyfg", small_pyfg());
  EXPECT_EQ(holdfast_program({"solve", one, other, "--backend", "irls", "--tum", at("tum")}).code, kDone);
  EXPECT_TRUE(std::filesystem::exists(at("tum/two_irls/A.tum")));
  EXPECT_TRUE(std::filesystem::exists(at("tum/two-2_irls/A.tum")));
}

TEST_F(Solve, ReportsUnknownTags) {
  const Outcome outcome = holdfast_program({"solve", write("square.g2o", small_g2o() + "EDGE_STRANGE 1 2 3\n"), "--backend", "irls"});
  EXPECT_EQ(outcome.code, kDone);
  EXPECT_THAT(outcome.err, HasSubstr("EDGE_STRANGE"));
}

TEST_F(Solve, StopsAtTheLimitHonestly) {
  const std::string json = at("runs.jsonl");
  const Outcome outcome = holdfast_program({"solve", write("two.pyfg", small_pyfg()), "--start", "odometry", "--backend", "irls,nesterov",
                                            "--max-iterations", "1", "--json", json});
  EXPECT_EQ(outcome.code, kDone);
  for (const auto& line : lines_of(json)) {
    EXPECT_EQ(line["termination"], "iteration limit");
    EXPECT_EQ(line["iterations"], 1);
  }
  EXPECT_THAT(outcome.out, HasSubstr("different ends"));
}

// ---- bad input

TEST_F(Solve, TriesEveryFileAndFailsForTheBadOnes) {
  const std::string good = write("two.pyfg", small_pyfg()), json = at("runs.jsonl");
  const std::string text = small_pyfg();
  const std::vector<std::pair<std::string, std::string>> bad{
      {write("empty.g2o", ""), "empty.g2o"},
      {at("absent.g2o"), "absent.g2o"},
      {std::filesystem::path(at("x")).parent_path().string(), "directory"},
      {write("cut.pyfg", text.substr(0, text.size() - 20)), "cut.pyfg"},
      {write("nan.pyfg", "VERTEX_SE2 0 A0 0 0 nan\n"), "nan.pyfg"},
      {write("variance.pyfg", "VERTEX_XY L0 0 0\nVERTEX_XY L1 1 0\nEDGE_RANGE 0 L0 L1 1 -2\n"), "variance.pyfg"},
      {write("unknown_key.pyfg", "VERTEX_XY L0 0 0\nEDGE_RANGE 0 L0 L1 1 2\n"), "unknown_key.pyfg"},
  };
  for (const auto& [file, named] : bad) {
    const Outcome outcome = holdfast_program({"solve", file, good, "--backend", "irls", "--json", json});
    EXPECT_EQ(outcome.code, kFailed) << file;
    EXPECT_THAT(outcome.err, HasSubstr(named));
    EXPECT_THAT(outcome.out, HasSubstr("two.pyfg")) << "the good one is solved all the same";
    EXPECT_EQ(lines_of(json).size(), 1u);
  }
}

TEST_F(Solve, LeavesNoResultsWhereNothingCouldBeRun) {
  const std::string json = write("runs.jsonl", "old\n");
  EXPECT_EQ(holdfast_program({"solve", at("absent.g2o"), "--json", json}).code, kFailed);
  EXPECT_FALSE(std::filesystem::exists(json));
}

TEST_F(Solve, FailsWhereAProblemHasNoAnswer) {
  const std::string json = at("runs.jsonl");
  const Outcome outcome = holdfast_program(
      {"solve", write("alone.pyfg", "VERTEX_SE2 0 A0 0 0 0\nVERTEX_SE2 1 A1 1 0 0\n"), "--backend", "irls", "--json", json});
  EXPECT_EQ(outcome.code, kFailed);
  const auto lines = lines_of(json);
  ASSERT_EQ(lines.size(), 1u);
  EXPECT_EQ(lines[0]["termination"], "failed");
  EXPECT_THAT(lines[0]["why"].get<std::string>(), HasSubstr("factor"));
  EXPECT_TRUE(lines[0]["cost"].is_null());
}

TEST_F(Solve, RefusesACommandLineThatMakesNoSense) {
  const std::string file = write("two.pyfg", small_pyfg());
  const std::vector<std::pair<std::vector<std::string>, std::string>> bad{
      {{"solve"}, "FILE"},
      {{}, "subcommand"},
      {{"fly", file}, ""},
      {{"solve", file, "--backend", "gurobi"}, "irls"},
      {{"solve", file, "--backend", ""}, "--backend"},
      {{"solve", file, "--loss", "hubert:2"}, "huber"},
      {{"solve", file, "--loss", "huber:-1"}, "huber:-1"},
      {{"solve", file, "--start", "nowhere"}, "odometry"},
      {{"solve", file, "--threads", "0"}, "threads"},
      {{"solve", file, "--threads", "many"}, "threads"},
      {{"solve", file, "--tolerance", "-1"}, "tolerance"},
      {{"solve", file, "--max-iterations", "-1"}, "max_iterations"},
      {{"solve", file, "--seed", "-1"}, "seed"},
      {{"solve", file, "--json", at("absent/runs.jsonl")}, "absent"},
      {{"solve", file, "--json", at(".")}, "directory"},
      {{"solve", file, "--frobnicate"}, "frobnicate"},
  };
  for (const auto& [arguments, named] : bad) {
    const Outcome outcome = holdfast_program(arguments);
    EXPECT_EQ(outcome.code, kUsage) << ::testing::PrintToString(arguments);
    EXPECT_THAT(outcome.err, HasSubstr(named)) << ::testing::PrintToString(arguments);
    EXPECT_EQ(outcome.out, "") << ::testing::PrintToString(arguments);
  }
}

TEST(Program, SaysWhatItIs) {
  EXPECT_EQ(holdfast_program({"--help"}).code, kDone);
  EXPECT_THAT(holdfast_program({"--version"}).out, HasSubstr("holdfast"));
  EXPECT_THAT(holdfast_program({"bench", "--help"}).out, HasSubstr("scenarios"));
}

TEST(Backends, AllAreThoseWithoutTheVariantsOfCeres) {
  for (const std::string& name : backends_of("all")) EXPECT_NE(name.rfind("ceres-", 0), 0u);
  EXPECT_THAT(backends_of("all"), ::testing::IsSupersetOf({"irls", "nesterov"}));
  EXPECT_THAT(backends_of("nesterov,irls,nesterov"), ::testing::ElementsAre("nesterov", "irls"));
  EXPECT_THROW(backends_of("irls,nothing"), BadOption);
}

/// A square of 40 poses walked twice, from the odometry; on the second lap it knows eight places again, and is wrong about `bad` more.
std::string laps(int bad) {
  std::ostringstream file;
  const auto pose = [](int k, double& x, double& y, double& yaw) {
    const int side = k / 5 % 4, along = k % 5;
    const double corner[4][2] = {{0, 0}, {5, 0}, {5, 5}, {0, 5}};
    yaw = side * 1.5707963267948966;
    x = corner[side][0] + along * std::cos(yaw);
    y = corner[side][1] + along * std::sin(yaw);
  };
  for (int k = 0; k < 40; ++k) {
    double x, y, yaw;
    pose(k, x, y, yaw);
    file << "VERTEX_SE2 " << k << ' ' << x << ' ' << y << ' ' << yaw << '\n';
  }
  const char* const information = " 400 0 0 400 0 1600\n";
  for (int k = 0; k + 1 < 40; ++k)
    file << "EDGE_SE2 " << k << ' ' << k + 1 << (k % 5 == 4 ? " 1 0 1.5707963267948966" : " 1.01 0 0") << information;
  for (int k = 0; k < 8; ++k) file << "EDGE_SE2 " << k << ' ' << k + 20 << " 0.02 -0.01 0.005" << information;
  for (int k = 0; k < bad; ++k) file << "EDGE_SE2 " << k << ' ' << 12 + 3 * k << ' ' << 3 - k << " 2 -1" << information;
  return file.str();
}

TEST_F(Solve, GncRejectsFalseLoopsAndNamesThem) {
  const std::string file = write("laps.g2o", laps(3)), json = at("runs.jsonl");
  const Outcome outcome = holdfast_program({"solve", file, "--gnc", "--backend", "irls,nesterov", "--json", json});
  EXPECT_EQ(outcome.code, kDone) << outcome.err;
  for (const char* text :
       {"gnc-irls", "gnc-nesterov", "rejected by gnc-irls, 3:", "Between(x0, x12)", "Between(x1, x15)", "Between(x2, x18)"})
    EXPECT_THAT(outcome.out, HasSubstr(text));
  for (const auto& line : lines_of(json)) {
    ASSERT_EQ(line["rejected"].size(), 3u);
    for (const auto& one : line["rejected"]) {
      EXPECT_GT(one["chi_square"], 100);
      EXPECT_LT(one["probability"], 1e-20);
      EXPECT_EQ(one["components"], 3);
    }
  }
}

TEST_F(Solve, AlphaSetsTheThresholdByTheNumberOfComponents) {
  const std::string file = write("laps.g2o", laps(0)), json = at("runs.jsonl");
  const auto cost = [&](const std::string& loss, const std::string& alpha) {
    std::vector<std::string> arguments{"solve", file, "--loss", loss, "--backend", "irls", "--max-iterations", "1", "--json", json};
    if (!alpha.empty()) arguments.insert(arguments.end(), {"--alpha", alpha});
    EXPECT_EQ(holdfast_program(arguments).code, kDone);
    return lines_of(json)[0]["cost_first"].get<double>();
  };
  EXPECT_NEAR(cost("truncated_squares:77", "0.05"), cost("truncated_squares:2.7954834", ""), 1e-6);  // √7.8147, χ² of 3 at 95 %
  const Outcome squared = holdfast_program({"solve", file, "--alpha", "0.05"});
  EXPECT_EQ(squared.code, kUsage);
  EXPECT_THAT(squared.err, HasSubstr("the loss squared has no threshold for outliers"));
  EXPECT_NEAR(cost("dcs:77", "0.05"), cost("dcs:2.7954834", ""), 1e-6);
  EXPECT_EQ(holdfast_program({"solve", file, "--loss", "max_mixture:5", "--alpha", "0.05"}).code, kUsage);
}

}  // namespace
}  // namespace holdfast::program
