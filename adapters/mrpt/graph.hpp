// MRPT's networks of poses as a graph and values, and back.
//
//   mrpt::graphs::CNetworkOfPoses2DInf network;
//   network.loadFromTextFile("graph.graph", false);                  // true, MRPT's default, fuses parallel edges
//   Problem problem = from_mrpt(network, Cauchy{2});                 // node 17 is key x17; the root is fixed
//   make_backend("irls")->solve(problem.graph, problem.start);
//   write_back(problem.start, network);                              // poses only: ids, edges and annotations stay
//
// CNetworkOfPoses{2D,3D}{,Inf,Cov}, whatever their annotations. Edges that store inverse poses are understood.
#pragma once

#include <mrpt/graphs/CNetworkOfPoses.h>

#include <holdfast/adapters/files/problem.hpp>
#include <holdfast/adapters/mrpt/mrpt.hpp>

namespace holdfast {

template <>
struct MrptConstraint<mrpt::poses::CPose2D> {
  using Pose = Pose2;
  static Pose2 measured(const mrpt::poses::CPose2D& c) { return StandsFor<mrpt::poses::CPose2D>::ours(c); }
  static Matrix<3, 3> information(const mrpt::poses::CPose2D&) { return Matrix<3, 3>::Identity(); }
};
template <>
struct MrptConstraint<mrpt::poses::CPose3D> {
  using Pose = Pose3;
  static Pose3 measured(const mrpt::poses::CPose3D& c) { return StandsFor<mrpt::poses::CPose3D>::ours(c); }
  static Matrix<6, 6> information(const mrpt::poses::CPose3D&) { return Matrix<6, 6>::Identity(); }
};

/// Node 17 is the key x17; ids of 2^32 and more are taken bit by bit (graph/key.hpp). to_mrpt() gives x17 the id 17, whatever it came from.
inline Key mrpt_key(mrpt::graphs::TNodeID id) { return Key::from_id(id); }

namespace detail {
template <class C>
auto mrpt_edge(mrpt::graphs::TNodeID from, mrpt::graphs::TNodeID to, const C& edge) -> Between<typename MrptConstraint<C>::Pose> {
  try {
    return Between<typename MrptConstraint<C>::Pose>::from_information(MrptConstraint<C>::measured(edge),
                                                                       MrptConstraint<C>::information(edge));
  } catch (const BadNumber& error) {
    fail<BadNumber>("edge ", from, " -> ", to, " of the network: ", error.what(),
                    "\nMRPT (2.5.8) takes the information of a TORO file (EDGE2) in g2o's order: read such a file with read_toro, and hand "
                    "over to_mrpt(…)");
  }
}
}  // namespace detail

/// One Between an edge, parallel ones and all, in the order of the network. loss: of every edge but those between consecutive ids.
/// BadKey names an edge of a node that is not there, BadNumber one whose information is none.
template <class Network>
Problem from_mrpt(const Network& network, const Loss& loss = {}) {
  using Theirs = typename Network::constraint_no_pdf_t;
  Problem problem;
  for (const auto& [id, pose] : network.nodes) problem.start.insert(mrpt_key(id), static_cast<const Theirs&>(pose));
  for (const auto& [ids, edge] : network.edges) {
    auto [from, to] = ids;
    for (const auto id : {from, to})
      if (!problem.start.contains(mrpt_key(id)))
        fail<BadKey>("edge ", from, " -> ", to, " of the network has no node ", id, "; add it, or call dijkstra_nodes_estimate()");
    if (network.edges_store_inverse_poses) std::swap(from, to);
    problem.factors.push_back(problem.graph.add(detail::mrpt_edge<typename Network::constraint_t>(ids.first, ids.second, edge),
                                                {mrpt_key(from), mrpt_key(to)}, from + 1 == to || to + 1 == from ? Loss{} : loss));
  }
  if (problem.start.contains(mrpt_key(network.root))) problem.graph.fix(mrpt_key(network.root));
  return problem;
}

/// The poses of the values into the nodes of the same ids; nothing else of the network changes. BadKey where a node has no value.
template <class Network>
void write_back(const Values& values, Network& network) {
  using Theirs = typename Network::constraint_no_pdf_t;
  for (auto& [id, pose] : network.nodes) static_cast<Theirs&>(pose) = values.at<Theirs>(mrpt_key(id));
}

/// A network of the graph's Betweens: each key becomes its id(); the one fixed pose (or the lowest) the root. What a network cannot hold is
/// a BadOption naming it: another factor or variable type, a robust loss, a weight, two fixed poses.
template <class Network>
Network to_mrpt(const Graph& graph, const Values& values) {
  using Constraint = MrptConstraint<typename Network::constraint_t>;
  using Pose = typename Constraint::Pose;
  using Theirs = typename Network::constraint_no_pdf_t;
  Network network;
  for (Key key : values.keys()) {
    if (!values.contains<Pose>(key))
      fail<BadOption>("a network of poses cannot hold ", key, ": it is no ", Pose::name(), "; leave it out of the values");
    static_cast<Theirs&>(network.nodes[key.id()]) = values.at<Theirs>(key);
  }
  for (const auto& batch : graph.batches())
    if (batch->size() > 0 && batch->factor_type() != typeid(Between<Pose>))
      fail<BadOption>("a network of poses cannot hold ", batch->describe(0), "; it has relative poses alone: remove it from the graph");
  graph.for_each_batch<Between<Pose>>([&](const Batch<Between<Pose>>& batch) {
    for (int i = 0; i < batch.size(); ++i) {
      if (batch.loss(i).kind != Loss::Kind::Squared || batch.weight(i) != 1)
        fail<BadOption>("a network of poses cannot hold the loss ", batch.loss(i).str(), " and weight ", batch.weight(i), " of ",
                        batch.describe(i), "; give it to the optimizer instead");
      const Between<Pose>& between = batch.factors()[i];
      const Matrix<Pose::dim, Pose::dim> I = between.sqrt_information.transpose() * between.sqrt_information;
      network.insertEdge(batch.keys(i)[0].id(), batch.keys(i)[1].id(), Constraint::make(between.measured, I));
    }
  });
  if (graph.fixed().size() > 1)
    fail<BadOption>("a network of poses has one root, but ", graph.fixed().size(), " poses are fixed; unfix all but one");
  if (!graph.fixed().empty())
    network.root = graph.fixed().begin()->id();
  else if (!network.nodes.empty())
    network.root = network.nodes.begin()->first;
  return network;
}

}  // namespace holdfast
