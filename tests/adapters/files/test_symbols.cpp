// A g2o file of two robots as GTSAM writes it: 64-bit symbols for ids.
#include <gtest/gtest.h>

#include <holdfast/adapters/files/problem.hpp>
#include <holdfast/graph/files/files.hpp>
#include <holdfast/solvers/table.hpp>
#include <sstream>

namespace holdfast {
namespace {

std::string symbol(char robot, std::uint64_t index) { return std::to_string(Key(robot, index).bits()); }

/// Robots a and b drive along x, 1.1 m a step; a's last pose sees b's last 5 m to its left.
std::string two_robots() {
  const std::string information = " 100 0 0 0 0 0 100 0 0 0 0 100 0 0 0 400 0 0 400 0 400\n";
  std::string text;
  for (const char robot : {'a', 'b'})
    for (std::uint64_t i = 0; i < 4; ++i)
      text += "VERTEX_SE3:QUAT " + symbol(robot, i) + " " + std::to_string(i) + (robot == 'a' ? " 0" : " 5") + " 0 0 0 0 1\n";
  for (const char robot : {'a', 'b'})
    for (std::uint64_t i = 0; i < 3; ++i)
      text += "EDGE_SE3:QUAT " + symbol(robot, i) + " " + symbol(robot, i + 1) + " 1.1 0 0 0 0 0 1" + information;
  return text + "EDGE_SE3:QUAT " + symbol('a', 3) + " " + symbol('b', 3) + " 0 5 0 0 0 0 1" + information;
}

TEST(Symbols, OfGtsamAreSolved) {
  EXPECT_EQ(symbol('b', 3), "7061644215716937731");  // as GTSAM writes it
  std::istringstream in(two_robots());
  const Dataset data = parse_g2o(in, "gtsam_symbols.g2o");
  Problem problem = make_problem(data, {Cauchy{0.1}});  // the odometry is under no loss
  EXPECT_EQ(problem.start.keys().front(), Key('a', 0));
  EXPECT_EQ(problem.start.keys().back(), Key('b', 3));
  const Summary summary = make_backend("irls")->solve(problem.graph, problem.start);
  EXPECT_EQ(summary.termination, Termination::converged) << summary.str();
  EXPECT_LT(summary.cost, 1e-12);
  for (std::uint64_t i = 0; i < 4; ++i) {
    EXPECT_LT((problem.start.at<Pose3>(Key('a', i)).p - Vector<3>(1.1 * static_cast<double>(i), 0, 0)).norm(), 1e-6) << i;
    EXPECT_LT((problem.start.at<Pose3>(Key('b', i)).p - Vector<3>(1.1 * static_cast<double>(i), 5, 0)).norm(), 1e-6) << i;
  }
  const Dataset solved = with_values(data, problem.start);
  EXPECT_EQ(to_g2o(solved).find("VERTEX_SE3:QUAT " + symbol('a', 0) + " "), 0u);
}

}  // namespace
}  // namespace holdfast
