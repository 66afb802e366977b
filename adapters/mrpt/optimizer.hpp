// Any holdfast back-end as the optimizer of MRPT's graph-slam engine, with robust losses, which MRPT has none of. Link holdfast::mrpt and
// mrpt::graphslam.
//
//   HoldfastGSO<CNetworkOfPoses2DInf> optimizer;
//   optimizer.backend = "irls";
//   optimizer.loss = Cauchy{2};                                     // of every edge but those between consecutive nodes
//   CGraphSlamEngine<CNetworkOfPoses2DInf> engine(config, rawlog, "", nullptr, &nodes, &edges, &optimizer);
//
// The section [OptimizerParameters] of the engine's configuration may name holdfast_backend and holdfast_loss ("cauchy:2"). The whole graph
// is solved, from its present nodes, whenever nodes or edges have come; a solve that fails is logged, and leaves the nodes as they were.
// The engine puts its own Dijkstra estimate over the nodes after every step that registered one, whatever the optimizer: the optimized
// poses are those of `answer`.
#pragma once

#include <mrpt/config/CConfigFile.h>
#include <mrpt/graphslam/interfaces/CGraphSlamOptimizer.h>

#include <holdfast/adapters/mrpt/graph.hpp>
#include <holdfast/solvers/table.hpp>

namespace holdfast {

template <class Network>
class HoldfastGSO : public mrpt::graphslam::optimizers::CGraphSlamOptimizer<Network> {
  using Parent = mrpt::graphslam::optimizers::CGraphSlamOptimizer<Network>;

 public:
  HoldfastGSO() { this->initializeLoggers("HoldfastGSO"); }

  std::string backend = "irls";
  Loss loss;
  Options options;
  Summary summary;  ///< of the last solve
  Values answer;    ///< of the last solve that was usable, by mrpt_key(node)

  bool updateState(mrpt::obs::CActionCollection::Ptr, mrpt::obs::CSensoryFrame::Ptr, mrpt::obs::CObservation::Ptr) override {
    const std::size_t edges = this->m_graph->edges.size();
    if (this->m_graph->nodeCount() == nodes_ && edges == edges_) return true;
    nodes_ = this->m_graph->nodeCount();
    edges_ = edges;
    if (edges_ > 0) optimizeGraph();
    return true;
  }
  bool justFullyOptimizedGraph() const override { return summary.usable(); }

  void loadParams(const std::string& source) override {
    Parent::loadParams(source);
    const mrpt::config::CConfigFile file(source);
    backend = file.read_string("OptimizerParameters", "holdfast_backend", backend);
    loss = Loss::parse(file.read_string("OptimizerParameters", "holdfast_loss", loss.str()));
  }
  void printParams() const override { this->logFmt(mrpt::system::LVL_INFO, "%s", parameters().c_str()); }
  void getDescriptiveReport(std::string* report) const override { *report = parameters() + "\n" + summary.str() + "\n"; }

 protected:
  /// Called with the engine's lock on the graph held.
  void optimizeGraph() override {
    Problem problem = from_mrpt(*this->m_graph, loss);
    summary = make_backend(backend, options)->solve(problem.graph, problem.start);
    if (!summary.usable()) return this->logFmt(mrpt::system::LVL_ERROR, "%s", summary.str().c_str());
    answer = problem.start;
    write_back(answer, *this->m_graph);
  }

 private:
  std::string parameters() const { return "HoldfastGSO: back-end " + backend + ", loss " + loss.str(); }

  std::size_t nodes_ = 0;
  std::size_t edges_ = 0;
};

}  // namespace holdfast
