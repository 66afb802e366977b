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

}  // namespace
}  // namespace holdfast::program
