#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <holdfast/benchmarks/papers/variance_constrained.hpp>

namespace holdfast::bench {
namespace {

template <int S>
struct Fix {
  Vector<S> position = Vector<S>::Zero();
  Matrix<S, S> covariance = Matrix<S, S>::Zero();
  bool received = false;
};

/// The information-weighted mean of a_k − d u over the anchors' packets to a node; where they are lost, what they would have said of R.
template <int S>
Fix<S> fix_of(const Network<S>& network, const typename Network<S>::Step& step, int node) {
  const double sigma2 = network.options.sigma * network.options.sigma;
  Matrix<S, S> information = Matrix<S, S>::Zero();
  Vector<S> sum = Vector<S>::Zero();
  Fix<S> fix;
  bool first = true;
  for (const auto& packet : step.packets) {
    if (packet.node != node || !packet.to_anchor) continue;
    if (std::exchange(first, false)) fix.received = packet.received;
    const Matrix<S, S> along = packet.direction * packet.direction.transpose();
    const Matrix<S, S> W =
        along / sigma2 + network.options.kappa / (packet.distance * packet.distance) * (Matrix<S, S>::Identity() - along);
    information += W;
    sum += W * (step.anchors[packet.other] - packet.distance * packet.direction);
  }
  fix.covariance = information.inverse();
  if (fix.received) fix.position = fix.covariance * sum;
  return fix;
}

}  // namespace

template <int S>
Tracks<S> variance_constrained(const Network<S>& network) {
  constexpr double kEpsilon = 1;
  using Square = Matrix<S, S>;
  const double arriving = 1 - network.options.lost, beta2 = network.longest_step * network.longest_step;
  const int nodes = static_cast<int>(network.steps[0].nodes.size());
  std::vector<Vector<S>> x(nodes);
  std::vector<Square> P(nodes);
  Tracks<S> tracks;
  for (std::size_t k = 0; k < network.steps.size(); ++k) {
    for (int i = 0; i < nodes; ++i) {
      const Fix<S> y = fix_of(network, network.steps[k], i);
      if (k == 0) {
        x[i] = y.position;
        P[i] = y.covariance;
        continue;
      }
      const Square predicted = P[i] + beta2 * Square::Identity();
      const Square second_moment = (1 + kEpsilon) * predicted + (1 + 1 / kEpsilon) * x[i] * x[i].transpose();
      const Square innovation = arriving * arriving * predicted + arriving * (1 - arriving) * second_moment + y.covariance;
      const Square K = innovation.llt().solve(arriving * predicted).transpose();
      x[i] += K * (y.position - arriving * x[i]);
      P[i] = predicted - K * innovation * K.transpose();
    }
    tracks.push_back(x);
  }
  return tracks;
}

template Tracks<2> variance_constrained<2>(const Network<2>&);
template Tracks<3> variance_constrained<3>(const Network<3>&);

}  // namespace holdfast::bench
