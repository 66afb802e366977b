// What `solve` says of the cases in ../shared/cases that leave something open: the files stay there.
#include <gmock/gmock.h>

#include <filesystem>

#include "tests/program/helpers.hpp"

namespace holdfast::program {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::Not;

std::string case_path(const std::string& file) {
  const char* const data = std::getenv("HOLDFAST_DATA");
  return std::string(data != nullptr ? data : "../shared/data") + "/../cases/" + file;
}

#define NEED_CASE(file) \
  if (!std::filesystem::exists(case_path(file))) GTEST_SKIP() << "no " << (file) << " in ../cases beside HOLDFAST_DATA"

class SolveCases : public InDirectory {};

std::size_t times(const std::string& part, const std::string& text) {
  std::size_t n = 0;
  for (std::size_t at = text.find(part); at != std::string::npos; at = text.find(part, at + 1)) ++n;
  return n;
}

TEST_F(SolveCases, ASecondSessionThatNothingHoldsIsNamedOnce) {
  NEED_CASE("two_sessions.g2o");
  const std::string json = at("runs.jsonl");
  const Outcome outcome = holdfast_program({"solve", case_path("two_sessions.g2o"), "--json", json});
  EXPECT_EQ(outcome.code, kDone) << outcome.err;
  EXPECT_EQ(
      times("5 variables (5 of agent x from x100) can move together at no cost (rotation, translation x, translation y)", outcome.err), 1u)
      << outcome.err;
  EXPECT_THAT(outcome.err, HasSubstr("share no factor"));
  const auto lines = lines_of(json);
  std::size_t told = 0;
  for (const auto& line : lines) told += line.contains("findings") ? 1 : 0;
  EXPECT_EQ(told, 1u);  // at the answer of the lowest cost
  const Outcome quiet = holdfast_program({"solve", case_path("two_sessions.g2o"), "--no-check"});
  EXPECT_EQ(quiet.err, "");
}

TEST_F(SolveCases, OneAnchorLeavesARotation) {
  NEED_CASE("one_anchor.pyfg");
  const Outcome outcome = holdfast_program({"solve", case_path("one_anchor.pyfg"), "--backend", "irls"});
  EXPECT_EQ(outcome.code, kDone) << outcome.err;
  EXPECT_THAT(outcome.err, HasSubstr("can move together at no cost (rotation)"));
}

TEST_F(SolveCases, NoStartAtAllIsNamedAsWhatItIs) {
  NEED_CASE("all_zero.pyfg");
  const Outcome outcome = holdfast_program({"solve", case_path("all_zero.pyfg"), "--backend", "irls"});
  EXPECT_EQ(outcome.code, kDone) << outcome.err;
  EXPECT_THAT(outcome.err, AllOf(HasSubstr("at the start: 15 factors stand at zero distance"), HasSubstr("Range(A0, L0)")));
  EXPECT_THAT(outcome.err, Not(HasSubstr("one-sided")));
}

TEST_F(SolveCases, BothMirrorAnswersWithTheirCosts) {
  NEED_CASE("coplanar_in_plane.pyfg");
  const Outcome outcome = holdfast_program({"solve", case_path("coplanar_in_plane.pyfg"), "--backend", "irls"});
  EXPECT_EQ(outcome.code, kDone) << outcome.err;
  EXPECT_THAT(outcome.err, HasSubstr("P0 fits as well on the other side of the plane of L0, L1, L2, L3"));
  const Outcome both =
      holdfast_program({"solve", case_path("coplanar_in_plane.pyfg"), "--backend", "irls", "--mirror", "--output", at("a.pyfg")});
  EXPECT_EQ(both.code, kDone) << both.err;
  EXPECT_THAT(both.err, Not(HasSubstr("other side")));
  EXPECT_THAT(both.out, HasSubstr("mirror image: P0 on the other side of the plane of L0, L1, L2, L3: cost "));
  EXPECT_EQ(times("mirror image: ", both.out), 3u) << both.out;
  EXPECT_TRUE(std::filesystem::exists(at("a-mirror-3.pyfg")));
}

TEST_F(SolveCases, TwoRobotsOnOneSpotAreMovedApart) {
  NEED_CASE("pose_on_pose.pyfg");
  const std::string json = at("runs.jsonl");
  const Outcome outcome = holdfast_program({"solve", case_path("pose_on_pose.pyfg"), "--json", json});
  EXPECT_EQ(outcome.code, kDone) << outcome.err;
  // The first poses of both are held where the file has them, on one spot, by sigmas of 0.05 m: a range of 5 m there costs what it must.
  for (const auto& line : lines_of(json)) {
    EXPECT_EQ(line["minimum"], "left a saddle");
    EXPECT_NEAR(line["cost"].get<double>(), 1224.76, 0.05);
  }
}

}  // namespace
}  // namespace holdfast::program
