// holdfast as the optimizer of MRPT's graph-slam engine. A robot drives round twice with odometry that drifts; from the second round on it
// knows places again, and every fifth time is mistaken.
#include <mrpt/graphslam/CGraphSlamEngine.h>
#include <mrpt/obs/CObservationOdometry.h>

#include <fstream>
#include <holdfast/adapters/mrpt/optimizer.hpp>
#include <iostream>

using namespace mrpt::graphslam;
using namespace mrpt::obs;
using mrpt::poses::CPose2D;
using Network = mrpt::graphs::CNetworkOfPoses2DInf;

constexpr int kRound = 30;

Network::constraint_t edge(double x, double y, double phi) {
  Network::constraint_t edge;
  edge.mean = CPose2D(x, y, phi);
  edge.cov_inv.setDiagonal(std::vector<double>{400, 400, 1e4});
  return edge;
}

struct Nodes final : deciders::CNodeRegistrationDecider<Network> {
  bool updateState(CActionCollection::Ptr, CSensoryFrame::Ptr, CObservation::Ptr) override {
    return registerNewNodeAtEnd(edge(1, 0, 2 * M_PI / kRound + 0.005));
  }
};

struct Places final : deciders::CEdgeRegistrationDecider<Network> {
  bool updateState(CActionCollection::Ptr, CSensoryFrame::Ptr, CObservation::Ptr) override {
    const auto last = m_graph->nodeCount() - 1;
    if (last >= kRound) m_graph->insertEdge(last - kRound, last, last % 5 == 0 ? edge(3, -2, 1) : edge(0, 0, 0));
    return true;
  }
};

int main() {
  std::ofstream("engine.ini") << "[VisualizationParameters]\nvisualize_map = false\n[OptimizerParameters]\nholdfast_loss = cauchy:2\n";
  Nodes nodes;
  Places places;
  holdfast::HoldfastGSO<Network> optimizer;
  CGraphSlamEngine<Network> engine("engine.ini", "", "", nullptr, &nodes, &places, &optimizer);
  for (std::size_t k = 0; k < 2 * kRound; ++k) {
    CObservation::Ptr observation = CObservationOdometry::Create();
    observation->timestamp = mrpt::Clock::fromDouble(1000.0 + k);
    engine.execGraphSlamStep(observation, k);
  }
  const CPose2D last = optimizer.answer.at<CPose2D>(holdfast::mrpt_key(2 * kRound));  // at the start again
  std::cout << optimizer.summary.str() << "\nlast node: " << last << '\n';
  return last.norm() < 0.5 ? 0 : 1;
}
