#include <Eigen/LU>
#include <algorithm>
#include <holdfast/benchmarks/papers/kalman.hpp>
#include <holdfast/benchmarks/papers/rivals_a.hpp>
#include <holdfast/solvers/table.hpp>

namespace holdfast::bench {
namespace {

using Motion = WhiteAcceleration<Motion2>;
using Square = Matrix<4, 4>;

const Matrix<2, 2> kQ = Matrix<2, 2>::Identity();

/// The first sighting that was received; nothing where none was.
std::optional<Vector<2>> seen_first(const std::vector<Sighting>& sightings) {
  for (const Sighting& sighting : sightings)
    if (sighting.received) return sighting.z;
  return std::nullopt;
}

Motion2 at_rest(const Vector<2>& p) { return {p[0], 0.0, p[1], 0.0}; }

Square covariance_of(const Motion& motion) { return (motion.sqrt_information * motion.sqrt_information).inverse(); }

/// With a symmetric root, as every other factor here has.
Prior<Motion2> prior_of(const Gaussian<4>& state) {
  return {Motion2(state.mean), symmetric_sqrt_information_from_covariance<4>(state.covariance)};
}

/// One window after the other.
class Windowed {
 public:
  Windowed(const Pursuit& pursuit, const WindowedOptions& options)
      : pursuit_(pursuit),
        options_(options),
        chain_(std::vector<Chain::Camera>(pursuit.options.sensors.size(), {kQ, 1}), options.losses),
        backend_(make_backend(options.backend)) {
    backend_->options.cost_tolerance = 0;
  }

  Motion2 step(int k) {
    const auto& sightings = pursuit_.sightings[k];
    const auto first = seen_first(sightings);
    if (!first) return predicted_at(k);
    enter(k, sightings, *first);
    std::optional<Prior<Motion2>> arrival;
    if (options_.anchored) arrival = prior_of(arrivals_.front());
    if (nodes_.size() > 1 || arrival) {
      chain_.set(nodes_, arrival);
      chain_.solve(*backend_, nodes_);
    }
    filtered_ = nodes_.back().state;
    last_ = k;
    return filtered_;
  }

 private:
  Motion2 predicted_at(int k) const { return Motion2(predicted(filtered_, (k - last_) * pursuit_.options.dt)); }

  void enter(int k, const std::vector<Sighting>& sightings, const Vector<2>& z) {
    const double dt = pursuit_.options.dt;
    const Square R = Square::Identity();
    ChainNode node{k, {}, Motion::continuous(1, 1), at_rest(z)};
    Gaussian<4> arrival{node.state.value, Square::Identity()};
    int received = 0;
    for (const Sighting& sighting : sightings) {
      node.z.push_back(sighting.received ? std::optional<Vector<2>>(sighting.z) : std::nullopt);
      received += sighting.received;
    }
    const Matrix<2, 2> Q = kQ / received;
    if (nodes_.empty()) {
      const Matrix<2, 4> C = Motion2::position_jacobian();
      recursion_.P = corrected(arrival, z, C, Q).covariance;
    } else {
      const int m = k - last_;
      const Motion recursive = recursion_.step(dt, m, R, Q);
      node.motion = options_.motion == Motion::Kind::recursive ? recursive : Motion::paper(dt, m, R);
      node.state = predicted_at(k);
      arrival = {node.state.value, covariance_of(recursive)};
    }
    nodes_.push_back(node);
    arrivals_.push_back(arrival);
    if (nodes_.size() > options_.window) {
      nodes_.erase(nodes_.begin());
      arrivals_.erase(arrivals_.begin());
    }
  }

  const Pursuit& pursuit_;
  const WindowedOptions options_;
  Chain chain_;
  std::unique_ptr<Backend> backend_;
  CovarianceRecursion<Motion2> recursion_{Square::Identity()};
  std::vector<ChainNode> nodes_;
  std::vector<Gaussian<4>> arrivals_;  ///< F^m x̂ and P^{[m]} of each node, as when it was new
  Motion2 filtered_;
  int last_ = 0;
};

}  // namespace

ChainLosses robust_losses() { return {per_component(Huber{2}), per_component(Huber{2}), per_component(Huber{2})}; }
ChainLosses least_squares_losses() { return {Squared(), Squared(), Squared()}; }
ChainLosses sum_of_norms_losses(double lambda) { return {Huber{lambda}, Huber{lambda}, Huber{lambda}}; }

Positions kalman_a(const Pursuit& pursuit) {
  const Matrix<2, 4> C = Motion2::position_jacobian();
  Gaussian<4> state{at_rest(*seen_first(pursuit.sightings[0])).value, Square::Identity()};
  Positions positions;
  int last = 0;
  for (int k = 0; k < static_cast<int>(pursuit.truth.size()); ++k) {
    const int m = k - last;
    Gaussian<4> prior = state;
    if (m > 0) {
      const Square noise = covariance_of(Motion::paper(pursuit.options.dt, m, Square::Identity()));
      prior = predicted(state, transition<Motion2>(m * pursuit.options.dt), noise);
    }
    bool received = false;
    for (const Sighting& sighting : pursuit.sightings[k]) {
      if (!sighting.received) continue;
      prior = corrected(prior, sighting.z, C, kQ);
      received = true;
    }
    if (received) {
      state = prior;
      last = k;
    }
    positions.push_back(Motion2(prior.mean).position());
  }
  return positions;
}

Positions windowed_a(const Pursuit& pursuit, const WindowedOptions& options) {
  Windowed windowed(pursuit, options);
  Positions positions;
  for (int k = 0; k < static_cast<int>(pursuit.truth.size()); ++k) positions.push_back(windowed.step(k).position());
  return positions;
}

}  // namespace holdfast::bench
