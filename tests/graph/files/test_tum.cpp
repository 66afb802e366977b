// Trajectories, and files that are whole or not there.
#include <sys/resource.h>
#include <sys/stat.h>
#include <unistd.h>

#include <csignal>
#include <holdfast/graph/files/atomic.hpp>
#include <holdfast/graph/files/tum.hpp>
#include <iterator>

#include "tests/graph/files/helpers.hpp"

namespace holdfast {
namespace {

using namespace testing_io;

TEST(Tum, Lines) {
  EXPECT_EQ(to_tum({{1248362857.700000048, Pose3({1, 2, 3}, Pose3::Rotation(0.8, 0, 0, 0.6))}}), "1248362857.7 1 2 3 0 0 0.6 0.8\n");
  EXPECT_EQ(to_tum({{0.5, Point2(1, -2.5)}, {1, Point3(1, 2, 3)}, {2, Pose2(4, 5, 0)}}),
            "0.5 1 -2.5 0 0 0 0 1\n1 1 2 3 0 0 0 1\n2 4 5 0 0 0 0 1\n");
  std::istringstream line(to_tum({{0, Pose2(0, 0, 2.0)}}));
  std::vector<double> numbers{std::istream_iterator<double>(line), {}};
  ASSERT_EQ(numbers.size(), 8u);
  EXPECT_NEAR(2 * std::atan2(numbers[6], numbers[7]), 2.0, 1e-15);
  expect_message<BadFile>([] { to_tum({{0, Point2(std::nan(""), 0)}}); }, {"cannot write '0 nan'", "not finite"});
}

TEST(Tum, OneFilePerAgent) {
  const TemporaryDirectory directory;
  Values values;
  constexpr Agent A('A'), B('b'), L('L'), S('/'), robot('r', 1234), other('r', 5), labelled('\0', 'A' << 16);
  for (int i : {10, 2, 1}) values.insert(A(static_cast<unsigned>(i)), Pose2(i, 0, 0));
  values.insert(B(0), Pose3({1, 2, 3}, Pose3::Rotation::Identity()));
  values.insert(L(0), Point2(1, 1));
  values.insert(S(3), Pose2(1, 1, 0));
  values.insert(robot(0), Pose2(1, 1, 0));
  values.insert(robot(1), Pose2(2, 1, 0));
  values.insert(other(9), Pose2(3, 1, 0));
  values.insert(labelled(1), Pose2(4, 1, 0));
  const std::vector<std::string> paths = write_tum_directory(directory / "new/dir", values, {{A(1), 7.5}, {A(2), 6.5}, {A(10), 8.5}});
  const std::string base = directory / "new/dir/";
  EXPECT_EQ(paths, (std::vector<std::string>{base + "agent_0_4259840.tum", base + "agent_47.tum", base + "A.tum", base + "b.tum",
                                             base + "r5.tum", base + "r1234.tum"}));
  EXPECT_EQ(content(base + "A.tum"), "6.5 2 0 0 0 0 0 1\n7.5 1 0 0 0 0 0 1\n8.5 10 0 0 0 0 0 1\n");
  EXPECT_EQ(content(base + "b.tum"), "0 1 2 3 0 0 0 1\n");  // no time stamps: the step
  EXPECT_EQ(content(base + "r5.tum"), "9 3 1 0 0 0 0 1\n");
  EXPECT_EQ(content(base + "r1234.tum"), "0 1 1 0 0 0 0 1\n1 2 1 0 0 0 0 1\n");
  expect_message<BadFile>([&] { write_tum_directory(directory / "x", values, {{A(1), 7.5}}); }, {"A2 has no time stamp"});
  EXPECT_FALSE(std::filesystem::exists(directory / "x"));
  put(directory / "file", "");
  expect_message<BadFile>([&] { write_tum_directory(directory / "file/x", values, {}); }, {"cannot make the directory", "file/x"});
}

TEST(Tum, TimesOfVertices) {
  const Dataset data = parsed("VERTEX_SE2 1.5 A0 0 0 0\nVERTEX_XY L0 0 0\n", Format::PyFG);
  EXPECT_EQ(vertex_times(data), (std::unordered_map<Key, double>{{Key('A', 0), 1.5}}));
}

TEST(Atomic, WritesAndReplaces) {
  const TemporaryDirectory directory;
  atomic_write(directory / "a", "one");
  EXPECT_EQ(content(directory / "a"), "one");
  ::chmod((directory / "a").c_str(), 0640);
  atomic_write(directory / "a", "");
  EXPECT_EQ(content(directory / "a"), "");
  struct stat status {};
  ::stat((directory / "a").c_str(), &status);
  EXPECT_EQ(status.st_mode & 0777, 0640u);
  EXPECT_EQ(directory.files(), 1u);
}

TEST(Atomic, FailureIsNamedAndLeavesNothing) {
  const TemporaryDirectory directory;
  expect_message<BadFile>([&] { atomic_write(directory / "none/a", "x"); }, {"cannot write", "none/a", "No such file"});
  std::filesystem::create_directory(directory / "d");
  expect_message<BadFile>([&] { atomic_write(directory / "d", "x"); }, {"cannot write", "a directory"});
  expect_message<BadFile>([&] { atomic_write("/dev/null", "x"); }, {"/dev/null", "no regular file"});
  EXPECT_EQ(directory.files(), 1u);
}

TEST(Atomic, FullDiskLeavesTheOldFile) {
  const TemporaryDirectory directory;
  put(directory / "a", "old");
  rlimit before{};
  ::getrlimit(RLIMIT_FSIZE, &before);
  const rlimit small{1000, before.rlim_max};
  const auto handler = std::signal(SIGXFSZ, SIG_IGN);
  ::setrlimit(RLIMIT_FSIZE, &small);
  expect_message<BadFile>([&] { atomic_write(directory / "a", std::string(5000, 'x')); }, {"cannot write", "File too large", "as it was"});
  ::setrlimit(RLIMIT_FSIZE, &before);
  std::signal(SIGXFSZ, handler);
  EXPECT_EQ(content(directory / "a"), "old");
  EXPECT_EQ(directory.files(), 1u);
}

TEST(Atomic, RecordThatDoesNotFitLeavesTheOldFile) {
  const TemporaryDirectory directory;
  put(directory / "a", "old");
  const Dataset data = parsed("VERTEX_SE2 1 0 0 0\n", Format::G2o);
  Dataset broken = data;
  broken.edges.push_back({RangeEdge{Key('x', 1), Key('x', 2), 1, 1}, {}, 0});
  expect_message<BadFile>([&] { write_g2o(directory / "a", broken); }, {"range x1 x2"});
  EXPECT_EQ(content(directory / "a"), "old");
  EXPECT_EQ(directory.files(), 1u);
}

}  // namespace
}  // namespace holdfast
