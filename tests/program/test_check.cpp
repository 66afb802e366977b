#include <gmock/gmock.h>

#include "tests/program/helpers.hpp"

namespace holdfast::program {
namespace {

using ::testing::HasSubstr;

class Check : public InDirectory {};

TEST_F(Check, FindsNothingWhereAllIsWell) {
  const Outcome outcome = holdfast_program({"check", write("square.g2o", small_g2o())});
  EXPECT_EQ(outcome.code, kDone) << outcome.out << outcome.err;
  EXPECT_THAT(outcome.out, HasSubstr("no findings"));
}

TEST_F(Check, NamesAPoseThatNothingHolds) {
  const Outcome outcome = holdfast_program({"check", write("square.g2o", small_g2o() + "VERTEX_SE2 9 0 0 0\n")});
  EXPECT_THAT(outcome.out, HasSubstr("unconstrained variable"));
  EXPECT_THAT(outcome.out, HasSubstr("x9"));
}

TEST_F(Check, NamesARobotThatIsAlone) {
  const Outcome outcome = holdfast_program(
      {"check", write("square.g2o", small_g2o() + "VERTEX_SE2 8 0 0 0\nVERTEX_SE2 9 0 0 0\nEDGE_SE2 8 9 1 0 0 100 0 0 100 0 400\n")});
  EXPECT_EQ(outcome.code, kFailed) << outcome.out;
  EXPECT_THAT(outcome.out, HasSubstr("error: "));
  EXPECT_THAT(outcome.out, HasSubstr("x8"));
}

TEST_F(Check, NamesUnknownTags) {
  const Outcome outcome = holdfast_program({"check", write("square.g2o", small_g2o() + "EDGE_STRANGE 1 2 3\n")});
  EXPECT_EQ(outcome.code, kDone);
  EXPECT_THAT(outcome.out, HasSubstr("warning: unknown tag"));
  EXPECT_THAT(outcome.out, HasSubstr("EDGE_STRANGE"));
}

TEST_F(Check, FailsForWhatItCannotRead) {
  for (const std::string& file : {write("empty.g2o", ""), at("absent.g2o"), at("."), write("cut.g2o", small_g2o().substr(0, 140)),
                                  write("zero.pyfg", "VERTEX_XY L0 0 0\nVERTEX_XY L1 1 0\nEDGE_RANGE 0 L0 L1 1 0\n")}) {
    const Outcome outcome = holdfast_program({"check", file});
    EXPECT_EQ(outcome.code, kFailed) << file;
    EXPECT_THAT(outcome.err, HasSubstr(std::filesystem::path(file).filename().string())) << file;
  }
}

TEST_F(Check, FailsForAFileWithoutMeasurements) {
  const Outcome outcome = holdfast_program({"check", write("alone.pyfg", "VERTEX_SE2 0 A0 0 0 0\n")});
  EXPECT_EQ(outcome.code, kFailed);
  EXPECT_THAT(outcome.out, HasSubstr("error: empty graph"));
}

TEST_F(Check, SaysWhatWasTakenForWhat) {
  const std::string file = write("square.g2o", small_g2o() + "VERTEX_TAG 3 a\nVERTEX_TAG 4 b\nFIX 77\n");
  const Outcome outcome = holdfast_program({"check", file});
  EXPECT_THAT(outcome.out, HasSubstr("read: 3 odometry edges, 1 loop closure; 2 lines of VERTEX_TAG kept, not used"));
  EXPECT_THAT(outcome.out, HasSubstr("FIX 77 names no vertex"));
  EXPECT_THAT(holdfast_program({"check", "--odometry", "none", file}).out, HasSubstr("read: 4 loop closures"));
}

TEST_F(Check, ReadsAsItIsTold) {
  const std::string rows = write("rows.graph", "EDGE2 0 1 1 0 0 100 0 0 100 0 400\nEDGE2 1 2 1 0 0 100 0 0 100 0 400\n");
  EXPECT_THAT(holdfast_program({"check", rows}).err, HasSubstr("--toro-order rows"));
  EXPECT_EQ(holdfast_program({"check", rows, "--toro-order", "rows"}).code, kDone);
  const std::string indefinite = write("indefinite.g2o", small_g2o() + "EDGE_SE2 0 2 1 1 3.1 1 0 0 1 0 -1\n");
  EXPECT_THAT(holdfast_program({"check", indefinite}).err, HasSubstr("line 9"));
  const Outcome repaired = holdfast_program({"check", indefinite, "--indefinite", "repair"});
  EXPECT_EQ(repaired.code, kDone);
  EXPECT_THAT(repaired.out, HasSubstr("line 9 (smallest eigenvalue -1"));
}

class ConvertFiles : public InDirectory {};

TEST_F(ConvertFiles, ThereAndBackThroughEveryFormat) {
  const std::string file = write("square.g2o", "# kept\n" + small_g2o());
  EXPECT_EQ(holdfast_program({"convert", file, at("same.g2o")}).code, kDone);
  EXPECT_EQ(text_of(at("same.g2o")), text_of(file));
  for (const std::string name : {"a.pyfg", "a.graph", "a.jrl"}) {
    const Outcome outcome = holdfast_program({"convert", file, at(name)});
    ASSERT_EQ(outcome.code, kDone) << outcome.err;
    EXPECT_THAT(outcome.out, HasSubstr("3 odometry edges, 1 loop closure"));
    const Outcome solved = holdfast_program({"solve", "--backend", "irls", "--json", at(name + ".json"), at(name)});
    EXPECT_EQ(solved.code, kDone) << solved.err;
    EXPECT_THAT(solved.out, HasSubstr("read: 3 odometry edges, 1 loop closure"));
  }
  EXPECT_EQ(holdfast_program({"convert", file, at("tum"), "--to", "tum"}).code, kDone);
  EXPECT_TRUE(std::filesystem::is_regular_file(at("tum") + "/x.tum"));
}

TEST_F(ConvertFiles, SaysWhatTheFormatCannotHold) {
  const std::string file = write("gps.g2o", small_g2o() + "EDGE_PRIOR_SE2_XY 0 1 2 1 0 1\nFOO 1\n");
  const Outcome outcome = holdfast_program({"convert", file, at("gps.pyfg")});
  EXPECT_EQ(outcome.code, kFailed);
  EXPECT_THAT(outcome.err, HasSubstr("position prior x0"));
  EXPECT_FALSE(std::filesystem::exists(at("gps.pyfg")));
}

TEST_F(ConvertFiles, ASolveWritesItsAnswerAsTheFileWas) {
  const std::string file = write("square.g2o", "# head\n" + small_g2o() + "LASER 1 2\n# end\n");
  const Outcome outcome = holdfast_program({"solve", "--backend", "irls", "--output", at("out.g2o"), file});
  ASSERT_EQ(outcome.code, kDone) << outcome.err;
  const std::string text = text_of(at("out.g2o"));
  EXPECT_EQ(text.find("# head\nVERTEX_SE2 0 0 0 0\nVERTEX_SE2 1 "), 0u) << text;
  EXPECT_NE(text.find("LASER 1 2\n# end\n"), std::string::npos);
  EXPECT_EQ(std::count(text.begin(), text.end(), '\n'), 11);
  EXPECT_EQ(holdfast_program({"solve", "--output", at("x.g2o"), file, file}).code, kUsage);
}

}  // namespace
}  // namespace holdfast::program
