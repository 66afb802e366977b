#include <Eigen/LU>
#include <algorithm>
#include <holdfast/benchmarks/papers/newton_backend.hpp>
#include <holdfast/benchmarks/papers/robust_tracker.hpp>
#include <holdfast/solvers/gnc.hpp>
#include <holdfast/solvers/marginals.hpp>

namespace holdfast::bench {
namespace {

using Motion = WhiteAcceleration<Motion2>;
using Square = Matrix<4, 4>;

constexpr int kFirstStates = 10;    // as long as nobody asks them how fast the target is
constexpr double kLeastSpeed = 1;   // [m/s]: a target at rest may start
constexpr double kAnywhere = 1000;  // σ of the first position [m]
constexpr double kRejected = 3.5;   // [sigmas]
constexpr int kPatience = 5;        // measured states from one acquisition to the next

Square covariance_of(const Motion& motion) { return (motion.sqrt_information.transpose() * motion.sqrt_information).inverse(); }

Gaussian<4> moved(const Gaussian<4>& state, const Motion& motion) {
  return predicted(state, transition<Motion2>(motion.duration()), covariance_of(motion));
}

/// Between two states T apart, t after the first: the cubic through both positions and velocities, which is what white acceleration
/// expects.
Motion2 between(const Motion2& from, const Motion2& to, double t, double T) {
  Motion2 state;
  const double s = t / T;
  for (int i = 0; i < 4; i += 2) {
    const double p = from.value[i], v = from.value[i + 1] * T, ahead = to.value[i] - p, w = to.value[i + 1] * T;
    const double b = 3 * ahead - 2 * v - w, a = v + w - 2 * ahead;
    state.value[i] = p + s * (v + s * (b + s * a));
    state.value[i + 1] = (v + s * (2 * b + s * 3 * a)) / T;
  }
  return state;
}

/// At rest where it is seen; returns the first place.
Vector<2> start_at_measurements(std::vector<ChainNode>& nodes) {
  for (ChainNode& node : nodes)
    for (const auto& z : node.z)
      if (z) node.state = Motion2((*z)[0], 0.0, (*z)[1], 0.0);
  return nodes.front().state.position();
}

std::vector<Chain::Camera> cameras_of(const std::vector<Matrix<2, 2>>& Q) {
  std::vector<Chain::Camera> cameras;
  for (const Matrix<2, 2>& one : Q) cameras.push_back({one, 1});
  return cameras;
}

}  // namespace

RobustTracker::RobustTracker(double dt, const std::vector<Matrix<2, 2>>& Q, const TrackerOptions& options)
    : dt_(dt),
      options_(options),
      cameras_(cameras_of(Q)),
      chain_(cameras_, {options.loss, Squared(), Squared()}),
      backend_(newton_backend(options.backend, {})) {
  backend_->options.cost_tolerance = options.cost_tolerance;
}

void RobustTracker::step(const std::vector<Sighting>& sightings) {
  ++step_;
  if (std::none_of(sightings.begin(), sightings.end(), [](const Sighting& sighting) { return sighting.received; })) return;
  enter(sightings);
  solve();
  reconsider_last();
  if (measured_ >= next_acquisition_ && !explains_the_data()) acquire();
  while (nodes_.size() > options_.window) drop_first();
}

void RobustTracker::enter(const std::vector<Sighting>& sightings) {
  ChainNode node{step_, {}, Motion::continuous(1, 1), {}};
  for (const Sighting& sighting : sightings) node.z.push_back(sighting.received ? std::optional<Vector<2>>(sighting.z) : std::nullopt);
  ++measured_;
  if (nodes_.empty()) {
    const Vector<2> p = *std::find_if(node.z.begin(), node.z.end(), [](const auto& z) { return z.has_value(); })->operator->();
    arrival_ = nothing_known(p);
    node.state = arrival_.mean;
  } else {
    const ChainNode& before = nodes_.back();
    node.motion = motion((step_ - before.step) * dt_, measured_ > kFirstStates ? &before.state : nullptr);
    node.state = state();
  }
  nodes_.push_back(node);
}

double RobustTracker::solve() {
  chain_.set(nodes_, arrival_);
  return chain_.solve(*backend_, nodes_).cost;
}

// Far from its prediction a measurement starts with no weight, and would keep none: the start where it is right gets its chance, too.
void RobustTracker::reconsider_last() {
  for (std::size_t c = 0; c < cameras_.size(); ++c) {
    if (!nodes_.back().z[c] || !is_rejected(nodes_.back(), c)) continue;
    const std::vector<ChainNode> before = nodes_;
    const double cost_before = chain_.graph().cost(chain_.values());
    for (int axis = 0; axis < 2; ++axis) nodes_.back().state.value[2 * axis] = (*nodes_.back().z[c])[axis];
    if (solve() < cost_before) continue;
    nodes_ = before;
    solve();
  }
}

bool RobustTracker::is_rejected(const ChainNode& node, std::size_t camera) const {
  return chain_.squared_residual(node, camera) > kRejected * kRejected;
}

bool RobustTracker::explains_the_data() const {
  std::size_t counted = 0, rejected = 0;
  for (std::size_t i = nodes_.size(); i-- > 0 && counted < options_.recent;)
    for (std::size_t c = 0; c < cameras_.size(); ++c)
      if (nodes_[i].z[c]) {
        ++counted;
        rejected += is_rejected(nodes_[i], c);
      }
  return 2 * rejected <= counted;
}

void RobustTracker::drop_first() {
  const ChainNode& first = nodes_.front();
  for (std::size_t c = 0; c < cameras_.size(); ++c)
    if (first.z[c]) decisions_.push_back({first.step, c, is_rejected(first, c)});
  arrival_ = chain_.marginalized(arrival_, first, nodes_[1]);
  dropped_.push_back(first);
  nodes_.erase(nodes_.begin());
  while (dropped_.size() + nodes_.size() > options_.memory) dropped_.pop_front();
}

void RobustTracker::acquire() {
  next_acquisition_ = measured_ + kPatience;
  std::vector<ChainNode> tracked = remembered(), found = tracked;
  const Prior<Motion2> anywhere = nothing_known(start_at_measurements(found));

  const auto graduated = gnc(newton_backend(options_.backend, backend_->options));
  Chain chain(cameras_, {TruncatedSquares{kRejected}, Squared(), Squared()});
  chain.set(found, anywhere);
  const double cost_found = chain.solve(*graduated, found).cost;
  chain.set(tracked, anywhere);
  const double cost_tracked = chain.solve(*backend_, tracked).cost;
  if (cost_found < cost_tracked * (1 - 1e-6)) go_on_from(found, anywhere);
}

// All that is held, with no opinion on how fast the target is: that comes from what is doubted.
std::vector<ChainNode> RobustTracker::remembered() const {
  std::vector<ChainNode> nodes(dropped_.begin(), dropped_.end());
  nodes.insert(nodes.end(), nodes_.begin(), nodes_.end());
  for (std::size_t i = 1; i < nodes.size(); ++i) nodes[i].motion = motion(nodes[i].motion.duration(), nullptr);
  return nodes;
}

// Without an arrival cost, too.
void RobustTracker::go_on_from(std::vector<ChainNode> found, const Prior<Motion2>& anywhere) {
  if (measured_ > kFirstStates) {
    ++reacquisitions_;
    for (std::size_t i = 1; i < found.size(); ++i) found[i].motion = motion(found[i].motion.duration(), &found[i - 1].state);
  }
  nodes_ = std::move(found);
  dropped_.clear();
  arrival_ = anywhere;
  solve();
}

Motion RobustTracker::motion(double T, const Motion2* from) const {
  Vector<2> along(1, 0);
  double v2 = options_.speed * options_.speed, along_density = options_.turn * v2;
  if (from != nullptr) {
    const Vector<2> v = from->derivative(1);
    v2 = std::clamp(v.squaredNorm(), kLeastSpeed * kLeastSpeed, 4 * v2);
    if (v.norm() > 0) along = v.normalized();
    along_density = options_.along * v2;
  }
  const Vector<2> across(-along[1], along[0]);
  Matrix<2, 2> axis;  // of density 1: axisᵀ axis = [T³/3 T²/2; T²/2 T]⁻¹
  axis << std::sqrt(12 / (T * T * T)), -std::sqrt(3 / T), 0, 1 / std::sqrt(T);
  Motion motion{Motion::Kind::continuous, T, 1, Square::Zero(), Square::Zero()};
  for (int i = 0; i < 2; ++i) {
    motion.sqrt_information.block<2, 2>(0, 2 * i) = along[i] / std::sqrt(along_density) * axis;
    motion.sqrt_information.block<2, 2>(2, 2 * i) = across[i] / std::sqrt(options_.turn * v2) * axis;
  }
  return motion;
}

Prior<Motion2> RobustTracker::nothing_known(const Vector<2>& p) const {
  const double v = options_.speed;
  return Prior<Motion2>::from_sigmas(Motion2(p[0], 0.0, p[1], 0.0), Vector<4>(kAnywhere, v, kAnywhere, v));
}

Motion2 RobustTracker::state() const { return smoothed(0); }

Motion2 RobustTracker::smoothed(int steps_ago) const {
  const int wanted = step_ - steps_ago;
  std::size_t i = nodes_.size() - 1;
  while (i > 0 && nodes_[i].step > wanted) --i;
  const double t = (wanted - nodes_[i].step) * dt_;
  if (i + 1 == nodes_.size() || t <= 0) return Motion2(predicted(nodes_[i].state, t));
  return between(nodes_[i].state, nodes_[i + 1].state, t, nodes_[i + 1].motion.duration());
}

Matrix<4, 4> RobustTracker::covariance() const {
  const ChainNode& last = nodes_.back();
  const Square P = Marginals(chain_.graph(), chain_.values()).covariance<Motion2>(chain_.key(nodes_.size() - 1));
  if (step_ == last.step) return P;
  return moved({last.state.value, P}, motion((step_ - last.step) * dt_, &last.state)).covariance;
}

}  // namespace holdfast::bench
