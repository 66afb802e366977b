// Robust ranges added to a network of MRPT: the network as a graph, two robots' ranges into it, the answer back into the network.
#include <cmath>
#include <holdfast/adapters/mrpt/graph.hpp>
#include <holdfast/factors/range.hpp>
#include <holdfast/solvers/table.hpp>
#include <iostream>

using namespace holdfast;
using mrpt::poses::CPose2D;

int main() {
  mrpt::graphs::CNetworkOfPoses2DInf network;  // nodes 0 … 9: one robot; 10 … 19: another, 3 m to its left, whose place was guessed
  mrpt::poses::CPosePDFGaussianInf step;
  step.mean = CPose2D(1, 0, 0);
  step.cov_inv.setDiagonal(std::vector<double>{400, 400, 1e4});
  for (int k = 0; k < 20; ++k) {
    network.nodes[k] = k < 10 ? CPose2D(k, 0, 0) : CPose2D(k - 10 + 0.5, 4, 0);
    if (k % 10 != 0) network.insertEdge(k - 1, k, step);
  }

  Problem problem = from_mrpt(network);
  problem.graph.add(Prior<Pose2>::from_sigmas(Pose2(0.5, 4, 0), Vector<3>(2, 2, 0.01)), {mrpt_key(10)});
  for (int k = 0; k < 10; ++k)
    for (int j : {k, 9 - k}) {
      const double range = k == 5 ? 30 : std::hypot(k - j, 3);  // two echoes
      problem.graph.add(Range<Pose2, Pose2>{range, 0.05}, {mrpt_key(k), mrpt_key(10 + j)}, Cauchy{2});
    }
  const Summary summary = make_backend("irls")->solve(problem.graph, problem.start);
  write_back(problem.start, network);

  std::cout << summary.str() << "\nnode 10: " << network.nodes[10] << '\n';
  return (CPose2D(network.nodes[10]) - CPose2D(0, 3, 0)).norm() < 0.05 ? 0 : 1;
}
