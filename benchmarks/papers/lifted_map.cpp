#include <cmath>
#include <holdfast/benchmarks/papers/lifted_map.hpp>

namespace holdfast::bench {

template <int S>
LiftedMap<S>::LiftedMap(const Network<S>& network, Missing missing)
    : steps_(static_cast<int>(network.steps.size())),
      nodes_(static_cast<int>(network.steps[0].nodes.size())),
      beta_(network.longest_step),
      sigma_(network.options.sigma),
      coupled_(missing == Missing::coupled) {
  int packets = 0;
  for (const auto& step : network.steps) packets += static_cast<int>(step.packets.size());
  const int positions = steps_ * nodes_ * S;
  b_ = start_ = Eigen::VectorXd::Zero(positions + packets * (S + 1));
  Vector<S> middle = Vector<S>::Zero();
  for (const Vector<S>& anchor : network.steps[0].anchors) middle += anchor / static_cast<double>(network.steps[0].anchors.size());
  for (int i = 0; i < positions; i += S) start_.segment<S>(i) = middle;
  for (int k = 0; k < steps_; ++k)
    for (const auto& packet : network.steps[k].packets) {
      const int edge = static_cast<int>(edges_.size()), y = positions + edge * (S + 1), omega = y + S;
      const bool received = packet.received;
      edges_.push_back({at(k, packet.node), packet.to_anchor ? -1 : at(k, packet.other), y, received ? -1 : omega,
                        received ? packet.distance : packet.previous});
      if (received) b_.segment<S>(y) += network.options.kappa / packet.distance * packet.direction;
      if (!received) {
        start_[omega] = packet.previous;
        b_[omega] = packet.previous / (kDistanceStep * kDistanceStep);
      }
      if (packet.to_anchor && (received || coupled_)) {
        const Vector<S> pull = network.steps[k].anchors[packet.other] / (sigma_ * sigma_);
        b_.segment<S>(at(k, packet.node)) += pull;
        b_.segment<S>(y) += pull;
      }
    }
}

template <int S>
Eigen::VectorXd LiftedMap<S>::multiply(const Eigen::VectorXd& z, unsigned parts) const {
  Eigen::VectorXd out = Eigen::VectorXd::Zero(z.size());
  for (const Edge& edge : edges_) {
    if (edge.omega >= 0 && (parts & (edge.to < 0 ? kUpsilon : kOmega))) out[edge.omega] += z[edge.omega] / (kDistanceStep * kDistanceStep);
    if (!(parts & (edge.to < 0 ? kAnchors : kNodes)) || (edge.omega >= 0 && !coupled_)) continue;
    Vector<S> e = -z.segment<S>(edge.from) - z.segment<S>(edge.y);
    if (edge.to >= 0) e += z.segment<S>(edge.to);
    e /= sigma_ * sigma_;
    out.segment<S>(edge.from) -= e;
    out.segment<S>(edge.y) -= e;
    if (edge.to >= 0) out.segment<S>(edge.to) += e;
  }
  if (parts & kWalk)
    for (int i = nodes_ * S; i < steps_ * nodes_ * S; ++i) {
      const double move = (z[i] - z[i - nodes_ * S]) / (beta_ * beta_);
      out[i] += move;
      out[i - nodes_ * S] -= move;
    }
  return out;
}

// By power iteration, from a vector that no symmetry makes orthogonal to the answer.
template <int S>
double LiftedMap<S>::largest(unsigned parts) const {
  Eigen::VectorXd v(start_.size());
  for (int i = 0; i < v.size(); ++i) v[i] = 1.5 + std::sin(1.0 + i * i);
  double value = 0;
  for (int i = 0; i < 1000; ++i) {
    v.normalize();
    v = multiply(v, parts);
    value = v.norm();
    if (value == 0) return 0;
  }
  return value;
}

template <int S>
double LiftedMap<S>::printed_m() const {
  double m = steps_ * nodes_ / (beta_ * beta_);
  for (const Edge& edge : edges_)
    if (edge.omega >= 0) m += 1 / (kDistanceStep * kDistanceStep);
  return m;
}

template <int S>
double LiftedMap<S>::printed_L() const {
  double L = 0;
  for (const unsigned part : {kNodes, kAnchors, kWalk, kOmega, kUpsilon}) L += largest(part);
  return L;
}

template <int S>
void LiftedMap<S>::project_on_cone(Eigen::Ref<Vector<S>> y, double& omega) {
  const double n = y.norm();
  if (n <= omega) return;
  const double nearest = std::max(0.0, (n + omega) / 2);
  y *= n > 0 ? nearest / n : 0;
  omega = nearest;
}

template <int S>
void LiftedMap<S>::project(LiftedSteps steps, Eigen::VectorXd& z) const {
  for (const Edge& edge : edges_) {
    if (edge.omega >= 0 && steps == LiftedSteps::restarted) {
      project_on_cone(z.segment<S>(edge.y), z[edge.omega]);
      continue;
    }
    const double radius = edge.omega >= 0 ? std::max(0.0, z[edge.omega]) : edge.distance, n = z.segment<S>(edge.y).norm();
    if (n > radius) z.segment<S>(edge.y) *= radius / n;
  }
}

template <int S>
int LiftedMap<S>::minimize(LiftedSteps steps, int most_iterations, const std::function<bool(const Eigen::VectorXd& x)>& done) {
  const bool printed = steps == LiftedSteps::printed;
  const double L = printed ? printed_L() : 1.01 * largest_eigenvalue(), root = std::sqrt(printed_m() / L);
  const int positions = steps_ * nodes_ * S;
  z_ = start_;
  Eigen::VectorXd ahead = z_, next;
  double t = 1;
  for (int iteration = 1; iteration <= most_iterations; ++iteration) {
    next = ahead - (multiply(ahead, kAll) - b_) / L;  // (39)
    project(steps, next);
    double beta = (1 - root) / (1 + root);  // (38)
    if (!printed) {
      const bool uphill = (ahead - next).dot(next - z_) > 0;
      const double t_next = uphill ? 1 : (1 + std::sqrt(1 + 4 * t * t)) / 2;
      beta = uphill ? 0 : (t - 1) / t_next;
      t = t_next;
    }
    ahead = next + beta * (next - z_);
    z_ = next;
    if (done(z_.head(positions))) return iteration;
  }
  return most_iterations;
}

template <int S>
Tracks<S> LiftedMap<S>::tracks() const {
  Tracks<S> tracks(steps_);
  for (int k = 0; k < steps_; ++k)
    for (int i = 0; i < nodes_; ++i) tracks[k].push_back(z_.segment<S>(at(k, i)));
  return tracks;
}

template class LiftedMap<2>;
template class LiftedMap<3>;

}  // namespace holdfast::bench
