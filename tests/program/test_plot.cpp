// `holdfast plot`: the page shows every agent, the truth and the outliers, and is whole by itself.
#include <gmock/gmock.h>

#include <cstdlib>

#include "tests/program/helpers.hpp"

namespace holdfast::program {
namespace {

using Json = nlohmann::ordered_json;
using ::testing::HasSubstr;
using ::testing::Not;

class Plot : public InDirectory {};

TEST_F(Plot, DrawsWaysLandmarksTruthAndTheOneOutlier) {
  const std::string file = write("two.pyfg", small_pyfg());
  const Outcome outcome = holdfast_program({"plot", file, at("page.html"), "--json", at("drawing.json")});
  ASSERT_EQ(outcome.code, kDone) << outcome.err;
  const Json drawing = lines_of(at("drawing.json"))[0];
  ASSERT_EQ(drawing["tracks"].size(), 3u);
  for (const Json& track : drawing["tracks"]) {
    EXPECT_EQ(track["is_way"], track["name"] != "L");
    EXPECT_EQ(track["estimate"].size(), track["name"] == "L" ? 1u : 5u);
    EXPECT_EQ(track["truth"].size(), track["name"] == "L" ? 0u : 5u);
  }
  ASSERT_EQ(drawing["rejected"].size(), 1u);  // the range of 30 m between A2 and B2, 3 m apart
  EXPECT_NEAR(drawing["rejected"][0][0].get<double>(), 2, 0.5);
  EXPECT_NEAR(drawing["rejected"][0][2].get<double>(), 2, 0.5);
  const std::string page = text_of(at("page.html"));
  for (const char* part :
       {"id=kept", "id=rejected", "id=truth", "id=estimate", "outliers (1)", "<title>A</title>", "<title>B</title>", "</html>"})
    EXPECT_THAT(page, HasSubstr(part));
  for (const char* foreign : {"http://", "https://", "<script"}) EXPECT_THAT(page, Not(HasSubstr(foreign)));
}

TEST_F(Plot, WithoutASolveVerticesAreAsInTheFile) {
  const std::string file = write("square.g2o", small_g2o());
  const Outcome outcome = holdfast_program({"plot", file, "--backend", "none", "--json", "-"});
  ASSERT_EQ(outcome.code, kDone) << outcome.err;
  EXPECT_EQ(Json::parse(outcome.out)["tracks"][0]["estimate"].dump(), "[[0.0,0.0],[1.1,0.0],[1.0,1.1],[0.0,1.0]]");
  EXPECT_TRUE(std::filesystem::is_regular_file(at("square.html")));
}

TEST_F(Plot, ThePictureIsTrueToScaleWithYUpwards) {
  write("corner.g2o",
        "VERTEX_SE2 0 0 0 0\nVERTEX_SE2 1 10 0 0\nVERTEX_SE2 2 10 5 0\nEDGE_SE2 0 1 10 0 0 1 0 0 1 0 1\n"
        "EDGE_SE2 1 2 0 5 0 1 0 0 1 0 1\n");
  ASSERT_EQ(holdfast_program({"plot", at("corner.g2o"), "--backend", "none"}).code, kDone);
  const std::string page = text_of(at("corner.html"));
  const std::size_t way = page.find("class=way");
  ASSERT_NE(way, std::string::npos);
  double x[3], y[3];
  ASSERT_EQ(std::sscanf(page.c_str() + page.find("d='M", way), "d='M%lf,%lf L%lf,%lf L%lf,%lf", &x[0], &y[0], &x[1], &y[1], &x[2], &y[2]),
            6);
  EXPECT_NEAR((x[1] - x[0]) / (y[1] - y[2]), 2, 1e-3);
  EXPECT_NEAR(y[0], y[1], 1e-3);
  EXPECT_GT(y[1], y[2]);
}

TEST_F(Plot, TheAnswerIsLaidOntoTheTruth) {
  // Odometry alone, exact, of a corner: the vertices are the truth, but the dead reckoning begins at the origin, unturned.
  const std::string noise = " 0.01 0 0 0.01 0 0.01\n";
  const std::string file = write("corner.pyfg",
                                 "VERTEX_SE2 0 A0 5 5 1.5707963267948966\nVERTEX_SE2 1 A1 5 7 3.141592653589793\n"
                                 "VERTEX_SE2 2 A2 2 7 3.141592653589793\nEDGE_SE2 0 A0 A1 2 0 1.5707963267948966" +
                                     noise + "EDGE_SE2 1 A1 A2 3 0 0" + noise);
  const Outcome outcome = holdfast_program({"plot", file, "--start", "odometry", "--json", "-"});
  ASSERT_EQ(outcome.code, kDone) << outcome.err;
  EXPECT_EQ(Json::parse(outcome.out)["tracks"][0]["estimate"].dump(), "[[5.0,5.0],[5.0,7.0],[2.0,7.0]]");
}

// Two steps of 1 m, 0.1 m of noise a step and axis, 0.01 rad; the first pose is held. The last is known along the way to 2 · 0.01 m², and
// across it to 2 · 0.01 m² + (1 m · 0.01 rad)².
TEST_F(Plot, EllipsesAreTheCovariancesOfPositions) {
  const std::string file = write("way.g2o",
                                 "VERTEX_SE2 0 0 0 0\nVERTEX_SE2 1 1 0 0\nVERTEX_SE2 2 2 0 0\nEDGE_SE2 0 1 1 0 0 100 0 0 100 0 10000\n"
                                 "EDGE_SE2 1 2 1 0 0 100 0 0 100 0 10000\n");
  const Outcome outcome = holdfast_program({"plot", file, at("page.html"), "--json", "-"});
  ASSERT_EQ(outcome.code, kDone) << outcome.err;
  const Json drawing = Json::parse(outcome.out);
  EXPECT_EQ(drawing["ellipses"].dump(), "[[0.0,0.0,0.0,0.0,0.0],[1.0,0.0,0.01,0.0,0.01],[2.0,0.0,0.02,0.0,0.0201]]");
  EXPECT_THAT(text_of(at("page.html")), HasSubstr("id=ellipses"));
}

// The same way, of which the truth goes along y: the ellipses turn with it. The first pose of a PyFG file has a prior with the noise of a
// step, 0.01 m² and (0.01 rad)²: across the way 3 · 0.01 m² + (2 m · 0.01 rad)² + (1 m · 0.01 rad)².
TEST_F(Plot, EllipsesTurnWithTheAnswer) {
  const std::string noise = " 0.01 0 0 0.01 0 0.0001\n";
  const std::string file = write("way.pyfg",
                                 "VERTEX_SE2 0 A0 0 0 1.5707963267948966\nVERTEX_SE2 1 A1 0 1 1.5707963267948966\n"
                                 "VERTEX_SE2 2 A2 0 2 1.5707963267948966\nEDGE_SE2 0 A0 A1 1 0 0" +
                                     noise + "EDGE_SE2 1 A1 A2 1 0 0" + noise);
  const Outcome outcome = holdfast_program({"plot", file, "--start", "odometry", "--json", "-"});
  ASSERT_EQ(outcome.code, kDone) << outcome.err;
  const Json last = Json::parse(outcome.out)["ellipses"][2];
  EXPECT_NEAR(last[2].get<double>(), 0.0305, 1e-6);
  EXPECT_NEAR(last[3].get<double>(), 0, 1e-6);
  EXPECT_NEAR(last[4].get<double>(), 0.03, 1e-6);
}

TEST_F(Plot, NamesAreTextNotMarkup) {
  const std::string file = write("a<b>&c.g2o", small_g2o());
  ASSERT_EQ(holdfast_program({"plot", file, at("page.html")}).code, kDone);
  EXPECT_THAT(text_of(at("page.html")), HasSubstr("a&lt;b&gt;&amp;c.g2o"));
}

TEST_F(Plot, SaysWhatItCannotDo) {
  EXPECT_THAT(holdfast_program({"plot", at("absent.g2o")}).err, HasSubstr("absent.g2o"));
  EXPECT_EQ(holdfast_program({"plot", write("square.g2o", small_g2o()), "--backend", "nobody"}).code, kUsage);
  EXPECT_EQ(holdfast_program({"plot", at("square.g2o"), at("no/page.html")}).code, kFailed);
}

class Report : public InDirectory {};

TEST_F(Report, RunsTheScriptOnTheDirectory) {
  write("report.py", "import sys\nopen(sys.argv[2], 'w').write('drawn from ' + sys.argv[1])\n");
  const Outcome outcome = holdfast_program({"report", at("."), at("page.html"), "--script", at("report.py"), "--json", "-"});
  ASSERT_EQ(outcome.code, kDone) << outcome.err;
  EXPECT_EQ(text_of(at("page.html")), "drawn from " + at("."));
  EXPECT_EQ(Json::parse(outcome.out)["bytes"], ("drawn from " + at(".")).size());
}

TEST_F(Report, FailsWithTheScript) {
  write("bad.py", "import sys\nsys.exit(3)\n");
  EXPECT_EQ(holdfast_program({"report", at("."), "--script", at("bad.py")}).code, kFailed);
  EXPECT_THAT(holdfast_program({"report", at("."), "--script", at("absent.py")}).err, HasSubstr("absent.py"));
}

}  // namespace
}  // namespace holdfast::program
