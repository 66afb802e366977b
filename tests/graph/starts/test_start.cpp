// Starts: from the vertices, from odometry, and from edges where vertices are missing.
#include <holdfast/graph/starts/start.hpp>

#include "tests/graph/files/helpers.hpp"

namespace holdfast {
namespace {

using namespace testing_io;

const std::string kI = " 1 0 0 1 0 1\n";

double distance(const Pose2& a, const Pose2& b) { return a.local(b).norm(); }

TEST(Odometry, IsTheStepToTheNextPoseOfTheAgent) {
  const Dataset data = parsed(
      "VERTEX_SE2 0 A0 0 0 0\nVERTEX_SE2 0 A1 0 0 0\nVERTEX_SE2 0 A5 0 0 0\nVERTEX_SE2 0 B0 0 0 0\nVERTEX_XY L0 0 0\n"
      "EDGE_SE2 0 A0 A1 1 0 0" +
          kI + "EDGE_SE2 0 A1 A5 1 0 0" + kI + "EDGE_SE2 0 A0 A5 1 0 0" + kI + "EDGE_SE2 0 A5 B0 1 0 0" + kI + "EDGE_SE2 0 A1 A0 1 0 0" +
          kI + "EDGE_RANGE 0 A0 A1 1 1\nEDGE_SE2 0 A0 A1 2 0 0" + kI,
      Format::PyFG);
  // In either direction: the fifth is A1 to A0.
  EXPECT_EQ(odometry_edges(data), (std::vector<bool>{true, true, false, false, true, false, true}));
}

TEST(VertexStart, IsTheFile) {
  const Dataset data = parsed("VERTEX_SE2 0 A0 1 2 3\nVERTEX_SE2 0 A1 4 5 6\nVERTEX_XY L0 7 8\nEDGE_SE2 0 A0 A1 1 0 0" + kI, Format::PyFG);
  const Values values = vertex_start(data);
  EXPECT_EQ(values.size(), 3u);
  EXPECT_EQ(distance(values.at<Pose2>(Key('A', 1)), Pose2(4, 5, 6)), 0);
  EXPECT_EQ(values.at<Point2>(Key('L', 0)).value, Vector<2>(7, 8));
}

TEST(VertexStart, CompletesFromEdges) {
  // 3 has a vertex; 2 and 4 follow by odometry, 9 over a loop edge backwards; 20, 21 are an island; 30 a landmark.
  const Dataset data = parsed("VERTEX_SE2 3 10 0 0\nEDGE_SE2 9 3 0 1 0" + kI + "EDGE_SE2 2 3 1 0 0" + kI + "EDGE_SE2 3 4 1 0 0.5" + kI +
                                  "EDGE_SE2 3 4 9 9 0.5" + kI + "EDGE_SE2 20 21 2 0 0" + kI + "EDGE_SE2_XY 4 30 1 0 1 0 1\n",
                              Format::G2o);
  const Values values = vertex_start(data);
  constexpr Agent x('x');
  EXPECT_EQ(values.size(), 7u);
  EXPECT_LT(distance(values.at<Pose2>(x(2)), Pose2(9, 0, 0)), 1e-14);
  EXPECT_LT(distance(values.at<Pose2>(x(4)), Pose2(11, 0, 0.5)), 1e-14);
  EXPECT_LT(distance(values.at<Pose2>(x(9)), Pose2(10, -1, 0)), 1e-14);
  EXPECT_LT(distance(values.at<Pose2>(x(20)), Pose2()), 1e-14);
  EXPECT_LT(distance(values.at<Pose2>(x(21)), Pose2(2, 0, 0)), 1e-14);
  EXPECT_LT((values.at<Point2>(x(30)).value - Vector<2>(11 + std::cos(0.5), std::sin(0.5))).norm(), 1e-14);
}

TEST(OdometryStart, ChainsBridgesAndStartsAgain) {
  // A: 0→1 odometry (its vertex at 1 is wrong on purpose), 1→2 missing but B0→A2 leads there, 2→3 odometry; 3→4 missing: vertex.
  const Dataset data = parsed(
      "VERTEX_SE2 0 A0 1 1 0\nVERTEX_SE2 0 A1 50 50 0\nVERTEX_SE2 0 A2 50 50 0\nVERTEX_SE2 0 A3 50 50 0\nVERTEX_SE2 0 A4 7 7 0\nVERTEX_SE2 "
      "0 A5 50 50 0\n"
      "VERTEX_SE2 0 B0 0 5 0\nEDGE_SE2 0 A0 A1 1 0 0" +
          kI + "EDGE_SE2 0 A2 A3 1 0 0" + kI + "EDGE_SE2 0 B0 A2 0 1 0" + kI + "EDGE_SE2 0 A0 A3 9 9 0" + kI + "EDGE_SE2 0 A4 A5 0 2 0" +
          kI,
      Format::PyFG);
  const Values values = odometry_start(data, 1);
  constexpr Agent A('A'), B('B');
  EXPECT_LT(distance(values.at<Pose2>(A(0)), Pose2(1, 1, 0)), 1e-14);
  EXPECT_LT(distance(values.at<Pose2>(A(1)), Pose2(2, 1, 0)), 1e-14);
  EXPECT_LT(distance(values.at<Pose2>(B(0)), Pose2(0, 5, 0)), 1e-14);
  EXPECT_LT(distance(values.at<Pose2>(A(2)), Pose2(9, 10, 0)), 1e-14);  // over A0 → A3 and back: the first link that opened
  EXPECT_LT(distance(values.at<Pose2>(A(3)), Pose2(10, 10, 0)), 1e-14);
  EXPECT_LT(distance(values.at<Pose2>(A(4)), Pose2(7, 7, 0)), 1e-14);
  EXPECT_LT(distance(values.at<Pose2>(A(5)), Pose2(7, 9, 0)), 1e-14);
}

TEST(OdometryStart, LandmarksAreDrawnFromTheSeed) {
  const std::string text = "VERTEX_SE2 0 A0 0 0 0\nVERTEX_XY L0 5 5\nVERTEX_XY L1 6 6\n";
  const std::string turned = "VERTEX_XY L1 6 6\nVERTEX_XY L0 5 5\nVERTEX_SE2 0 A0 0 0 0\n";
  const auto landmark = [](const std::string& file, unsigned seed, double sigma, unsigned i) {
    return odometry_start(parsed(file, Format::PyFG), seed, sigma).at<Point2>(Key('L', i)).value;
  };
  EXPECT_EQ(landmark(text, 3, 1, 0), landmark(turned, 3, 1, 0));
  EXPECT_NE(landmark(text, 3, 1, 0), landmark(text, 4, 1, 0));
  EXPECT_EQ(landmark(text, 3, 0, 1), Vector<2>(6, 6));
  EXPECT_LT(((landmark(text, 3, 2, 1) - Vector<2>(6, 6)) - 2 * (landmark(text, 3, 1, 1) - Vector<2>(6, 6))).norm(), 1e-14);
  double sum = 0, squares = 0;
  for (unsigned seed = 0; seed < 2000; ++seed) {
    const double error = landmark(text, seed, 1, 0)[0] - 5;
    sum += error;
    squares += error * error;
  }
  EXPECT_NEAR(sum / 2000, 0, 0.1);
  EXPECT_NEAR(squares / 2000, 1, 0.15);
  EXPECT_THROW(odometry_start(parsed(text, Format::PyFG), 0, -1), BadNumber);
  EXPECT_THROW(odometry_start(parsed(text, Format::PyFG), 0, std::nan("")), BadNumber);
}

TEST(Start, RangesDoNotSayWhere) {
  Dataset data = parsed("VERTEX_SE2 0 A0 0 0 0\nVERTEX_XY L0 0 0\nEDGE_RANGE 0 A0 L0 1 1\n", Format::PyFG);
  data.vertices.pop_back();
  expect_message<BadKey>([&] { vertex_start(data); }, {"L0 has no vertex", "range A0 L0 (line 3)", "give it a vertex"});
}

template <class Pose>
double largest_step_error(const Dataset& data, const Values& values) {
  const std::vector<bool> is_odometry = odometry_edges(data);
  double largest = 0;
  for (std::size_t i = 0; i < data.edges.size(); ++i)
    if (is_odometry[i]) {
      const auto& edge = std::get<RelativePoseEdge<Pose>>(data.edges[i].measurement);
      const Pose step = values.at<Pose>(edge.first).inverse() * values.at<Pose>(edge.second);
      largest = std::max(largest, edge.measured.local(step).norm());
    }
  return largest;
}

TEST(OdometryStart, ReproducesOdometryOfPlaza2) {
  HOLDFAST_NEED_DATA("range/plaza2.pyfg");
  const Dataset data = read_dataset(data_directory() + "/range/plaza2.pyfg");
  const Values values = odometry_start(data, 1);
  EXPECT_EQ(values.size(), 4095u);
  EXPECT_LT(largest_step_error<Pose2>(data, values), 1e-12);
  EXPECT_EQ(distance(values.at<Pose2>(Key('A', 0)), std::get<Pose2>(data.vertices[0].value)), 0);
}

TEST(OdometryStart, ReproducesOdometryInSpaceAndOfTeams) {
  HOLDFAST_NEED_DATA("range/single_drone.pyfg");
  HOLDFAST_NEED_DATA("range/mrclam5a.pyfg");
  const Dataset drone = read_dataset(data_directory() + "/range/single_drone.pyfg");
  EXPECT_LT(largest_step_error<Pose3>(drone, odometry_start(drone, 1)), 1e-12);
  const Dataset team = read_dataset(data_directory() + "/range/mrclam5a.pyfg");
  EXPECT_LT(largest_step_error<Pose2>(team, odometry_start(team, 1)), 1e-12);
}

TEST(VertexStart, CsailHasEdgesAlone) {
  HOLDFAST_NEED_DATA("pose_graph/CSAIL.g2o");
  const Dataset data = read_dataset(data_directory() + "/pose_graph/CSAIL.g2o");
  const Values values = vertex_start(data);
  EXPECT_EQ(values.size(), 1045u);
  EXPECT_LT(largest_step_error<Pose2>(data, values), 1e-12);
  EXPECT_EQ(distance(values.at<Pose2>(Key('x', 0)), Pose2()), 0);
}

}  // namespace
}  // namespace holdfast
