// The public data: counts as its README has them, and nothing lost between reading and writing.
#include <ctime>
#include <set>

#include "tests/graph/files/helpers.hpp"

namespace holdfast {
namespace {

using namespace testing_io;

struct Expected {
  const char* file;
  Format format;
  std::size_t agents, poses, landmarks, relative_poses, ranges, ranges_between, relative_points;
};

class DataFile : public ::testing::TestWithParam<Expected> {};

TEST_P(DataFile, CountsAsPublished) {
  const Expected& expected = GetParam();
  HOLDFAST_NEED_DATA(expected.file);
  const Dataset data = read_dataset(data_directory() + "/" + expected.file);
  EXPECT_EQ(data.format, expected.format);
  EXPECT_TRUE(data.unknown.empty()) << unknown_report(data);
  std::set<Agent> agents;
  std::set<Key> poses;
  std::size_t relative_poses = 0, ranges = 0, between = 0, relative_points = 0;
  for (const Vertex& vertex : data.vertices)
    if (vertex.value.index() < 2) agents.insert(vertex.key.agent()), poses.insert(vertex.key);
  for (const Edge& edge : data.edges) {
    relative_poses += edge.measurement.index() < 2;
    relative_points += edge.measurement.index() == 2 || edge.measurement.index() == 3;
    if (const auto* range = std::get_if<RangeEdge>(&edge.measurement)) {
      ++ranges;
      between += poses.count(range->first) == 1 && poses.count(range->second) == 1;
    }
  }
  EXPECT_EQ(agents.size(), expected.agents);
  EXPECT_EQ(poses.size(), expected.poses);
  EXPECT_EQ(data.vertices.size() - poses.size(), expected.landmarks);
  EXPECT_EQ(relative_poses, expected.relative_poses);
  EXPECT_EQ(ranges, expected.ranges);
  EXPECT_EQ(between, expected.ranges_between);
  EXPECT_EQ(relative_points, expected.relative_points);
}

TEST_P(DataFile, RoundTripKeepsEveryBit) {
  HOLDFAST_NEED_DATA(GetParam().file);
  const Dataset data = read_dataset(data_directory() + "/" + GetParam().file);
  const TemporaryDirectory directory;
  const std::string path = directory / "again";
  switch (data.format) {
    case Format::PyFG:
      write_pyfg(path, data);
      break;
    case Format::G2o:
      write_g2o(path, data);
      break;
    case Format::Toro:
      write_toro(path, data);
      break;
  }
  const Dataset again = read_dataset(path);
  expect_same(data, again);
  EXPECT_EQ(written(data), written(again));
}

INSTANTIATE_TEST_SUITE_P(All, DataFile,
                         ::testing::Values(Expected{"range/plaza2.pyfg", Format::PyFG, 1, 4091, 4, 4090, 1807, 0, 0},
                                           Expected{"range/single_drone.pyfg", Format::PyFG, 1, 1754, 1, 1753, 1754, 0, 0},
                                           Expected{"range/tiers.pyfg", Format::PyFG, 4, 9768, 1, 9764, 7789, 4713, 0},
                                           Expected{"range/mrclam5a.pyfg", Format::PyFG, 5, 1080, 15, 1075, 316, 316, 1127},
                                           Expected{"range/goats_14.pyfg", Format::PyFG, 1, 679, 4, 678, 1558, 0, 0},
                                           Expected{"pose_graph/intel.g2o", Format::G2o, 1, 1728, 0, 2512, 0, 0, 0},
                                           Expected{"pose_graph/M3500.g2o", Format::G2o, 1, 3500, 0, 5453, 0, 0, 0},
                                           Expected{"pose_graph/MIT.g2o", Format::G2o, 1, 808, 0, 827, 0, 0, 0},
                                           Expected{"pose_graph/CSAIL.g2o", Format::G2o, 0, 0, 0, 1172, 0, 0, 0},
                                           Expected{"pose_graph/sphere2500.g2o", Format::G2o, 1, 2500, 0, 4949, 0, 0, 0},
                                           Expected{"pose_graph/smallGrid3D.g2o", Format::G2o, 1, 125, 0, 297, 0, 0, 0},
                                           Expected{"pose_graph/tinyGrid3D.g2o", Format::G2o, 1, 9, 0, 11, 0, 0, 0}),
                         [](const ::testing::TestParamInfo<Expected>& instance) {
                           return std::filesystem::path(instance.param.file).stem().string();
                         });

/// Seconds of the processor, not of a clock that goes on while others have it; the least of three.
double seconds_to_parse(int edges) {
  std::string text;
  const std::string tail =
      " 0.1 0.25 -0.125 0 0 0.6 0.8 10.5 0 0 0 0 0 10.25 0 0 0 0 10.125 0 0 0 400.021 0.00193512 2.06612 399.993 0.496977 99.203\n";
  for (int i = 0; i < edges; ++i) text += "EDGE_SE3:QUAT " + std::to_string(i) + " " + std::to_string(i + 1) + tail;
  double least = std::numeric_limits<double>::infinity();
  for (int round = 0; round < 3; ++round) {
    const std::clock_t begin = std::clock();
    EXPECT_EQ(parsed(text, Format::G2o).edges.size(), static_cast<std::size_t>(edges));
    least = std::min(least, static_cast<double>(std::clock() - begin) / CLOCKS_PER_SEC);
  }
  return least;
}

TEST(Parsing, TakesTimeInProportionToTheEdges) { EXPECT_LT(seconds_to_parse(80'000), 16 * seconds_to_parse(10'000)); }  // 64 if quadratic

}  // namespace
}  // namespace holdfast
