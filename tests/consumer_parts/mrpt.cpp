// A stranger's network of MRPT, solved by holdfast.
#include <cmath>
#include <cstdio>
#include <holdfast/adapters/mrpt/graph.hpp>
#include <holdfast/solvers/table.hpp>

using namespace holdfast;
using mrpt::poses::CPose2D;

int main() {
  mrpt::graphs::CNetworkOfPoses2DInf network;
  network.nodes[0] = CPose2D(0, 0, 0);
  network.nodes[1] = CPose2D(0, 0, 0);
  mrpt::poses::CPosePDFGaussianInf edge;
  edge.mean = CPose2D(1, 2, 0.5);
  edge.cov_inv.setIdentity();
  network.insertEdge(0, 1, edge);
  Problem problem = from_mrpt(network);
  make_backend("irls")->solve(problem.graph, problem.start);
  write_back(problem.start, network);
  const bool right = std::abs(network.nodes[1].phi() - 0.5) < 1e-9 && std::abs(network.nodes[1].y() - 2) < 1e-9;
  std::printf("consumer with MRPT: %s\n", right ? "ok" : "WRONG");
  return right ? 0 : 1;
}
