// Every way a file can be wrong: a BadFile that names file, line, text and what was expected.
#include <algorithm>
#include <holdfast/graph/files/internal/parser.hpp>

#include "tests/graph/files/helpers.hpp"

namespace holdfast {
namespace {

using namespace testing_io;

const std::string kPoses = "VERTEX_SE2 0.5 A0 0 0 0\nVERTEX_SE2 1 A1 1 0 0.1\nVERTEX_XY L0 5 5\n";
const std::string kG2oPoses = "VERTEX_SE2 0 0 0 0\nVERTEX_SE2 1 1 0 0.1\n";
const std::string kIdentity21 = "1 0 0 0 0 0 1 0 0 0 0 1 0 0 0 1 0 0 1 0 1";

struct Case {
  const char* what;
  Format format;
  std::string before;  ///< good lines
  std::string bad;     ///< the line at fault
  std::vector<std::string> parts;
};

void PrintTo(const Case& c, std::ostream* out) { *out << c.what; }

class BadLine : public ::testing::TestWithParam<Case> {};

TEST_P(BadLine, IsNamed) {
  const Case& c = GetParam();
  const std::size_t number = static_cast<std::size_t>(std::count(c.before.begin(), c.before.end(), '\n')) + 1;
  std::vector<std::string> parts = c.parts;
  parts.push_back("test.txt, line " + std::to_string(number) + ": '" + c.bad.substr(0, 60));
  parts.push_back("expected");
  expect_message<BadFile>([&] { parsed(c.before + c.bad + "\n# end\n", c.format); }, parts);
}

INSTANTIATE_TEST_SUITE_P(
    All, BadLine,
    ::testing::Values(
        Case{"too few columns",
             Format::PyFG,
             kPoses,
             "EDGE_RANGE 1 A1 L0 5.0",
             {"found 5 columns", "expected 6", "EDGE_RANGE time name name distance variance"}},
        Case{"too many columns", Format::PyFG, kPoses, "EDGE_RANGE 1 A1 L0 5.0 0.1 7", {"found 7 columns", "expected 6"}},
        Case{"too few in g2o", Format::G2o, kG2oPoses, "EDGE_SE2 0 1 1 0 0.1 1 0 0 1 0", {"found 11 columns", "expected 12"}},
        Case{"FIX without id", Format::G2o, kG2oPoses, "FIX", {"found 1 columns", "expected 2 or more"}},
        Case{"no number", Format::PyFG, kPoses, "EDGE_RANGE 1 A1 L0 5.0m 0.1", {"column 5 '5.0m' is not a number", "a distance [m]"}},
        Case{"two signs", Format::PyFG, kPoses, "EDGE_RANGE 1 A1 L0 +-5 0.1", {"'+-5' is not a number"}},
        Case{"decimal comma", Format::PyFG, kPoses, "EDGE_RANGE 1 A1 L0 5,0 0.1", {"'5,0' is not a number"}},
        Case{"NaN", Format::PyFG, kPoses, "EDGE_RANGE 1 A1 L0 nan 0.1", {"'nan' is not finite"}},
        Case{"infinite", Format::G2o, kG2oPoses, "VERTEX_SE2 2 -inf 0 0", {"'-inf' is not finite", "x [m]"}},
        Case{"overflow", Format::G2o, kG2oPoses, "VERTEX_SE2 2 1e999 0 0", {"'1e999' is outside the range of a double"}},
        Case{"bad name", Format::PyFG, kPoses, "EDGE_RANGE 1 A1 LL0 5 0.1", {"'LL0' is not a name", "such as A11"}},
        Case{"name too large", Format::PyFG, kPoses, "EDGE_RANGE 1 A1 L99999999999999999999 5 0.1", {"L99999999999999999999", "2^56"}},
        Case{"negative id", Format::G2o, kG2oPoses, "VERTEX_SE2 -2 0 0 0", {"'-2' is not an id", "expected an integer from 0"}},
        Case{"id too large", Format::G2o, kG2oPoses, "VERTEX_SE2 18446744073709551616 0 0 0", {"is not an id"}},
        Case{"zero variance", Format::PyFG, kPoses, "EDGE_RANGE 1 A1 L0 5 0", {"the variance is 0", "> 0"}},
        Case{"negative variance", Format::PyFG, kPoses, "EDGE_RANGE 1 A1 L0 5 -0.1", {"the variance is -0.1"}},
        Case{"negative distance", Format::PyFG, kPoses, "EDGE_RANGE 1 A1 L0 -5 0.1", {"the distance is -5", ">= 0"}},
        Case{"covariance",
             Format::PyFG,
             kPoses,
             "EDGE_SE2 1 A0 A1 1 0 0.1 1 2 0 1 0 1",
             {"covariance matrix is not positive definite", "smallest eigenvalue is -0.99999", "all > 0"}},
        Case{"information",
             Format::G2o,
             kG2oPoses,
             "EDGE_SE2 0 1 1 0 0.1 1 0 0 1 0 -1",
             {"information matrix is not positive semidefinite", "smallest eigenvalue is -1;", "all >= 0"}},
        Case{"matrix 2", Format::PyFG, kPoses, "EDGE_SE2_XY 1 A0 L0 1 0 -1 0 1", {"smallest eigenvalue is -1;"}},
        Case{"toro order", Format::Toro, "VERTEX2 0 0 0 0\n", "EDGE2 0 1 1 0 0 1 0 1 -3 0 0", {"smallest eigenvalue is -3;"}},
        Case{"matrix 6",
             Format::G2o,
             "",
             "EDGE_SE3:QUAT 0 1 0 0 0 0 0 0 1 1 0 0 0 0 0 1 0 0 0 0 1 0 0 0 1 0 0 1 0 -2",
             {"smallest eigenvalue is -2;"}},
        Case{"quaternion",
             Format::G2o,
             "",
             "VERTEX_SE3:QUAT 0 0 0 0 0 0 0.1 1",
             {"qx qy qz qw has norm 1.00498", "expected 1 within 0.001"}},
        Case{"zero quaternion", Format::G2o, "", "EDGE_SE3:QUAT 0 1 0 0 0 0 0 0 0 " + kIdentity21, {"has norm 0;"}},
        Case{"vertex again", Format::PyFG, kPoses, "VERTEX_SE2 2 A1 0 0 0", {"defines A1 again, after line 2"}},
        Case{"to itself", Format::PyFG, kPoses, "EDGE_RANGE 1 A1 A1 5 0.1", {"from A1 to itself", "two different variables"}},
        Case{"landmark as pose",
             Format::PyFG,
             kPoses,
             "EDGE_SE2 1 A0 L0 1 0 0.1 1 0 0 1 0 1",
             {"uses L0 as a Pose2, but line 3 as a Point2"}},
        Case{"pose as landmark", Format::PyFG, kPoses, "EDGE_SE2_XY 1 A0 A1 1 0 1 0 1", {"uses A1 as a Point2, but line 2 as a Pose2"}},
        Case{"plane and space",
             Format::G2o,
             kG2oPoses,
             "EDGE_SE3:QUAT 0 1 0 0 0 0 0 0 1 " + kIdentity21,
             {"uses x0 as a Pose3, but line 1 as a Pose2"}},
        Case{
            "no vertex", Format::PyFG, kPoses, "EDGE_RANGE 1 A1 L7 5 0.1", {"names L7, which has no vertex", "VERTEX line for every name"}},
        Case{"g2o in PyFG", Format::PyFG, kPoses, "EDGE_SE2 0 1 1 0 0.1 1 0 0 1 0 1", {"a line of g2o", "expected PyFG", "one dialect"}},
        Case{"PyFG in g2o", Format::G2o, kG2oPoses, "EDGE_RANGE 1 A1 L0 5 0.1", {"a line of PyFG", "expected g2o"}},
        Case{"PyFG landmark in g2o", Format::G2o, kG2oPoses, "VERTEX_XY L0 5 0.1", {"a line of PyFG", "expected g2o"}},
        Case{"TORO in g2o", Format::G2o, kG2oPoses, "VERTEX2 4 5 0.1 1", {"a line of TORO", "expected g2o"}},
        Case{"g2o in TORO", Format::Toro, "VERTEX2 0 0 0 0\n", "FIX 0", {"a line of g2o", "expected TORO"}},
        Case{"name in g2o", Format::G2o, kG2oPoses, "EDGE_SE2 A0 A1 1 0 0.1 1 0 0 1 0 1", {"'A0' is not an id"}},
        Case{"sensor in the plane",
             Format::G2o,
             "PARAMS_SE2OFFSET 0 0 0 0\n",
             "EDGE_SE3_PRIOR 1 0 0 0 0 0 0 0 1 " + kIdentity21,
             {"sensor offset 0 (line 1) is in the plane, the edge in space"}}),
    [](const ::testing::TestParamInfo<Case>& instance) {
      std::string name = instance.param.what;
      for (char& c : name) c = c == ' ' ? '_' : c;
      return name;
    });

TEST(BadFiles, UndefinedSensorOffset) {
  expect_message<BadFile>([] { parsed("EDGE_SE3_PRIOR 1 4 0 0 0 0 0 0 1 " + kIdentity21 + "\n", Format::G2o); },
                          {"test.txt, line 1", "sensor offset 4", "PARAMS_SE3OFFSET"});
  expect_message<BadFile>([] { parsed("PARAMS_SE3OFFSET 0 0 0 0 0 0 0 1\nPARAMS_SE3OFFSET 0 0 0 0 0 0 0 1\n", Format::G2o); },
                          {"line 2", "sensor offset 0 again, after line 1"});
}

TEST(BadFiles, MissingDirectoryEmpty) {
  const TemporaryDirectory directory;
  expect_message<BadFile>([&] { read_dataset(directory / "none.g2o"); },
                          {"cannot read", directory / "none.g2o", "No such file", "expected a readable"});
  expect_message<BadFile>([&] { read_dataset(directory / ""); }, {"cannot read", "it is a directory"});
  put(directory / "empty.g2o", "");
  expect_message<BadFile>([&] { read_dataset(directory / "empty.g2o"); }, {"empty.g2o", "empty (0 bytes)"});
  put(directory / "blank.g2o", "# nothing\n\n  \n");
  expect_message<BadFile>([&] { read_dataset(directory / "blank.g2o"); }, {"blank.g2o", "no records, only blank lines and comments"});
  expect_message<BadFile>([&] { read_g2o(directory / "blank.g2o"); }, {"blank.g2o", "no vertex and no edge of g2o"});
  std::istringstream nothing;
  expect_message<BadFile>([&] { parse_dataset(nothing, "stdin"); }, {"stdin", "empty"});
}

TEST(BadFiles, NoDialect) {
  const auto recognised = [](const std::string& text) {
    std::istringstream in(text);
    return parse_dataset(in, "file.g2o").format;
  };
  expect_message<BadFile>([&] { recognised("# x\nhello world\n"); }, {"file.g2o, line 2: 'hello world'", "expected such as VERTEX_SE2"});
  expect_message<BadFile>([&] { recognised("VERTEX_SE2 a b c d e\n"); }, {"file.g2o, line 1", "expected the columns of PyFG", "or of g2o"});
  expect_message<BadFile>([&] { recognised("VERTEX_SE2 0 0 0 0\nVERTEX_SE2 1 A1 0 0 0\n"); }, {"line 2", "a line of PyFG", "expected g2o"});
  expect_message<BadFile>(
      [&] {
        recognised(
            std::string("\x7f"
                        "ELF\x01\x00",
                        6));
      },
      {"line 1: '?ELF"});
  EXPECT_EQ(recognised("UNKNOWN 1\nVERTEX_SE2 0 0 0 0\n"), Format::G2o);
  EXPECT_EQ(recognised("VERTEX_XY L0 0 0\n"), Format::PyFG);
  EXPECT_EQ(recognised("VERTEX_XY 0 0 0\n"), Format::G2o);
  EXPECT_EQ(recognised("VERTEX_SE2 3152 A0 0 0 0\n"), Format::PyFG);
  EXPECT_EQ(recognised("EDGE2 0 1 0 0 0 1 0 1 1 0 0\n"), Format::Toro);
}

TEST(BadFiles, CutInTheMiddle) {
  const TemporaryDirectory directory;
  const std::string whole = kPoses + "EDGE_SE2 1 A0 A1 1 0 0.1 1 0 0 1 0 1\n";
  for (std::size_t length = kPoses.size() + 10; length + 2 < whole.size(); ++length) {
    put(directory / "cut.pyfg", whole.substr(0, length));
    expect_message<BadFile>([&] { read_dataset(directory / "cut.pyfg"); }, {"cut.pyfg, line 4: 'EDGE_SE2 1", "is the file cut?"});
  }
  for (std::size_t length = kPoses.size() + 1; length < kPoses.size() + 9; ++length) {  // inside the tag: not merely unknown
    put(directory / "cut.pyfg", whole.substr(0, length));
    expect_message<BadFile>([&] { read_dataset(directory / "cut.pyfg"); }, {"cut.pyfg, line 4: 'E", "is the file cut?"});
  }
  put(directory / "cut.pyfg", whole.substr(0, whole.size() - 1));
  EXPECT_EQ(read_dataset(directory / "cut.pyfg").edges.size(), 1u);
  put(directory / "cut.pyfg", kPoses + "EDGE_FOO");  // a whole tag that nobody knows is no cut
  EXPECT_EQ(read_dataset(directory / "cut.pyfg").unknown.size(), 1u);
}

TEST(BadFiles, LongLineIsShownInPart) {
  expect_message<BadFile>([] { parsed("VERTEX_SE2 " + std::string(1000, '1') + "\n", Format::G2o); }, {"1...': found 2 columns"});
}

TEST(BadFiles, StreamGoesOnAfterBadLine) {
  LineParser parser(Format::PyFG, "stdin");
  parser.parse("VERTEX_SE2 0 A0 0 0 0\n");
  expect_message<BadFile>([&] { parser.parse("EDGE_RANGE 0 A0 L0 x 1"); }, {"stdin, line 2", "'x' is not a number"});
  expect_message<BadFile>([&] { parser.parse("EDGE_SE2 0 A0 A0 0 0 0 1 0 0 1 0 1"); }, {"stdin, line 3"});
  EXPECT_EQ(parser.dataset().edges.size(), 0u);
  parser.parse("EDGE_RANGE 0 A0 L0 2 1");
  EXPECT_EQ(parser.dataset().edges.size(), 1u);
  EXPECT_EQ(parser.dataset().edges[0].line, 4u);
  expect_message<BadFile>([&] { parser.finish(); }, {"stdin, line 4: 'EDGE_RANGE 0 A0 L0 2 1'", "names L0"});
  parser.parse("VERTEX_XY L0 1 1");
  const Dataset dataset = parser.finish();
  EXPECT_EQ(dataset.vertices.size(), 2u);
  EXPECT_EQ(parser.dataset().vertices.size(), 0u);
}

}  // namespace
}  // namespace holdfast
