#include <holdfast/benchmarks/papers/chain.hpp>

namespace holdfast::bench {
namespace {

using Motion = WhiteAcceleration<Motion2>;

}  // namespace

Chain::Measurement Chain::seen(const Camera& camera, const Vector<2>& z) const {
  return Measurement::of_position(-z, Vector<2>::Zero(), camera.Q, camera.weight);
}

void Chain::build(std::size_t nodes, bool has_arrival) {
  graph_ = Graph();
  values_ = Values();
  measurements_.assign(nodes, {});
  motions_.clear();
  arrival_.reset();
  const Motion any_motion = Motion::continuous(1, 1);
  for (std::size_t i = 0; i < nodes; ++i) {
    values_.insert(key(i), Motion2());
    for (const Camera& camera : cameras_)
      measurements_[i].push_back(graph_.add(seen(camera, Vector<2>::Zero()), {key(i)}, losses_.measurement));
    if (i > 0) motions_.push_back(graph_.add(any_motion, {key(i - 1), key(i)}, losses_.motion));
  }
  if (has_arrival) arrival_ = graph_.add(Prior<Motion2>{Motion2(), Matrix<4, 4>::Identity()}, {key(0)}, losses_.arrival);
}

void Chain::set(const std::vector<ChainNode>& nodes, const std::optional<Prior<Motion2>>& arrival) {
  if (measurements_.size() != nodes.size() || arrival_.has_value() != arrival.has_value()) build(nodes.size(), arrival.has_value());
  for (std::size_t i = 0; i < nodes.size(); ++i) {
    const ChainNode& node = nodes[i];
    for (std::size_t c = 0; c < cameras_.size(); ++c) {
      graph_.set_weight(measurements_[i][c], node.z[c] ? cameras_[c].weight : 0);
      if (node.z[c]) graph_.at<Measurement>(measurements_[i][c]).z = -*node.z[c];
    }
    if (i > 0) graph_.at<Motion>(motions_[i - 1]) = node.motion;
    values_.update(key(i), node.state);
  }
  if (arrival) graph_.at<Prior<Motion2>>(*arrival_) = *arrival;
}

Summary Chain::solve(Backend& backend, std::vector<ChainNode>& nodes) {
  Summary summary = backend.solve(graph_, values_);
  polish_(graph_, values_, summary);
  for (std::size_t i = 0; i < nodes.size(); ++i) nodes[i].state = values_.at<Motion2>(key(i));
  return summary;
}

}  // namespace holdfast::bench
