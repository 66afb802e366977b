#include <Eigen/LU>
#include <algorithm>
#include <holdfast/benchmarks/papers/flight_tracker.hpp>
#include <holdfast/benchmarks/papers/newton_backend.hpp>
#include <holdfast/solvers/marginals.hpp>

namespace holdfast::bench {

Vector<5> TurningPrior::operator()(const Motion2& x, const Scalar& omega, Jacobians<TurningPrior>* J) const {
  if (J != nullptr) J->all = sqrt_information;
  Vector<5> error;
  error << x.value, omega.value;
  return sqrt_information * (error - mean);
}

namespace {

/// A prior on [x; ω] as marginalisation left it, about where it was linearised.
TurningPrior turning_prior(const LinearPrior& left, Key x) {
  if (left.rows != 5) fail<BadProblem>("a state that is left leaves ", left.rows, " rows of 5: its arrival cost must hold every direction");
  const Eigen::Map<const Matrix<5, 5>> A(left.A.data());
  const Eigen::Map<const Vector<5>> b(left.b.data()), x0(left.x0.data());
  Eigen::PermutationMatrix<5> order;  // from the prior's variables to [x; ω]
  order.indices() << 0, 1, 2, 3, 4;
  if (left.keys[0] != x) order.indices() << 4, 0, 1, 2, 3;
  const Matrix<5, 5> W = A * order.transpose();
  return {order * (x0 - A.partialPivLu().solve(b)), W};
}

}  // namespace

FlightTracker::Window::Window(int states, std::size_t followers, const FlightTracker& tracker)
    : backend(newton_backend(tracker.options_.backend, {}))  // turns are nearly linear, and Huber is convex
{
  backend->options.cost_tolerance = tracker.options_.cost_tolerance;
  for (std::size_t f = 0; f < followers; ++f) {
    samples.emplace_back(states);
    arrivals.push_back(graph.add(TurningPrior{Vector<5>::Zero(), Matrix<5, 5>::Identity()}, {x(f, 0), omega(f, 0)}));
    for (int s = 0; s < states; ++s) {
      values.insert(x(f, s), Motion2());
      values.insert(omega(f, s), Scalar());
      for (int i = 0; i < tracker.options_.spacing; ++i)
        samples[f][s].push_back(graph.add(tracker.sample(i, Vector<2>::Zero()), {x(f, s)}, tracker.options_.loss, 0));
      if (s > 0) graph.add(tracker.turn_, {x(f, s - 1), omega(f, s - 1), x(f, s), omega(f, s)});
    }
  }
}

void FlightTracker::Window::set_arrival(std::size_t follower, const Node& node) {
  graph.at<TurningPrior>(arrivals[follower]) = node.arrival;
}

void FlightTracker::Window::set_sample(std::size_t follower, int state, std::size_t i, const Vector<2>& gps) {
  const FactorId id = samples[follower][state][i];
  graph.at<Sample>(id).known = gps;
  graph.set_weight(id, 1);
}

void FlightTracker::Window::start_at(std::size_t follower, int state, const Node& node) {
  values.update(x(follower, state), node.believed.x);
  values.update(omega(follower, state), node.believed.omega);
}

FlightTracker::Believed FlightTracker::Window::believed(std::size_t follower, int state) const {
  return {values.at<Motion2>(x(follower, state)), values.at<Scalar>(omega(follower, state))};
}

FlightTracker::FlightTracker(double dt, const std::vector<Motion2>& start, const FlightTrackerOptions& options)
    : dt_(dt),
      options_(options),
      turn_{options.spacing * dt, options.q, options.q_turn},
      nodes_(start.size()),
      now_(1, start.size(), *this),
      back_(options.window, start.size(), *this) {
  const Vector<5> sigmas(1, 0.3, 1, 0.3, options.sigma_turn);
  for (std::size_t f = 0; f < start.size(); ++f) {
    Vector<5> mean;
    mean << start[f].value, 0;
    nodes_[f].push_back({{mean, sigmas.cwiseInverse().asDiagonal()}, {start[f], Scalar()}, {}});
    now_.set_arrival(f, nodes_[f].back());
    now_.start_at(f, 0, nodes_[f].back());
  }
}

// r = R^{-1/2} (p + τ v − gps).
FlightTracker::Sample FlightTracker::sample(std::size_t i, const Vector<2>& gps) const {
  const double tau = static_cast<double>(i) * dt_;
  Matrix<2, 4> B = Motion2::position_jacobian();
  B(0, 1) = B(1, 3) = tau;
  return {Vector<2>::Zero(), gps, B, Matrix<2, 2>::Identity() / std::sqrt(options_.R), 1};
}

void FlightTracker::step(const std::vector<Vector<2>>& gps) {
  ++step_;
  const auto place = static_cast<std::size_t>(step_ % options_.spacing);
  if (step_ > 0 && place == 0) complete_states();
  for (std::size_t f = 0; f < gps.size(); ++f) {
    nodes_[f].back().gps.push_back(gps[f]);
    now_.set_sample(f, 0, place, gps[f]);
  }
  now_.solve();
}

// The state is left for the next one: what it knows goes into the next one's arrival cost.
void FlightTracker::complete_states() {
  for (std::size_t f = 0; f < nodes_.size(); ++f) {
    nodes_[f].back().believed = now_.believed(f, 0);
    judge(f);
    nodes_[f].push_back(following(nodes_[f].back()));
    if (static_cast<int>(nodes_[f].size()) > options_.window + 1) nodes_[f].erase(nodes_[f].begin());
    now_.set_arrival(f, nodes_[f].back());
    now_.start_at(f, 0, nodes_[f].back());
    for (const FactorId id : now_.samples[f][0]) now_.graph.set_weight(id, 0);
  }
  if (options_.looks_back && static_cast<int>(nodes_[0].size()) > options_.window) look_back();
}

void FlightTracker::look_back() {
  for (std::size_t f = 0; f < nodes_.size(); ++f) {
    back_.set_arrival(f, nodes_[f].front());
    for (int s = 0; s < options_.window; ++s) {
      const Node& node = nodes_[f][s];
      back_.start_at(f, s, node);
      for (std::size_t i = 0; i < node.gps.size(); ++i) back_.set_sample(f, s, i, node.gps[i]);
    }
  }
  back_.solve();
  for (std::size_t f = 0; f < nodes_.size(); ++f)
    for (int s = 0; s < options_.window; ++s) nodes_[f][s].believed = back_.believed(f, s);
}

void FlightTracker::judge(std::size_t follower) {
  const Node& node = nodes_[follower].back();
  for (std::size_t i = 0; i < node.gps.size(); ++i, ++judged_) {
    const Vector<2> r = sample(i, node.gps[i])(node.believed.x);  // in sigmas
    if (std::sqrt(options_.R) * r.norm() > options_.outlier)
      flags_.push_back({follower, step_ - static_cast<int>(node.gps.size()) + static_cast<int>(i)});
  }
}

FlightTracker::Node FlightTracker::following(const Node& node) {
  const Key x('S', 0), omega('W', 0), next_x('S', 1), next_omega('W', 1);
  const CoordinatedTurn::Prediction ahead = turn_.predicted(node.believed.x, node.believed.omega.value);
  Node next{{}, {Motion2(ahead.mean.head<4>()), Scalar(ahead.mean[4])}, {}};
  Values values;
  values.insert(x, node.believed.x);
  values.insert(omega, node.believed.omega);
  values.insert(next_x, next.believed.x);
  values.insert(next_omega, next.believed.omega);
  Graph leaving;
  leaving.add(node.arrival, {x, omega});
  for (std::size_t i = 0; i < node.gps.size(); ++i) leaving.add(sample(i, node.gps[i]), {x}, options_.loss, 1);
  leaving.add(turn_, {x, omega, next_x, next_omega});
  marginalizer_.eliminate(leaving, values, x);
  const FactorId left = marginalizer_.eliminate(leaving, values, omega);
  next.arrival = turning_prior(std::as_const(leaving).at<LinearPrior>(left), next_x);
  return next;
}

Motion2 FlightTracker::state(std::size_t follower) const {
  const double tau = (step_ % options_.spacing) * dt_;
  const Believed now = now_.believed(follower, 0);
  return Motion2(CoordinatedTurn{tau, options_.q, options_.q_turn}.predicted(now.x, now.omega.value).mean.head<4>());
}

Matrix<4, 4> FlightTracker::covariance(std::size_t follower) const {
  const Believed now = now_.believed(follower, 0);
  const CoordinatedTurn turn{(step_ % options_.spacing) * dt_, options_.q, options_.q_turn};
  const Matrix<5, 5> P = Marginals(now_.graph, now_.values).joint<Motion2, Scalar>(now_.x(follower, 0), now_.omega(follower, 0));
  const Matrix<5, 5> F = turn.predicted(now.x, now.omega.value).F;
  return (F * P * F.transpose() + turn.covariance()).topLeftCorner<4, 4>();
}

Motion2 FlightTracker::smoothed(std::size_t follower, int steps_ago) const {
  const int complete = static_cast<int>(nodes_[follower].size()) - 1;
  const int first = (step_ / options_.spacing - complete) * options_.spacing;  // the step of the first state held
  const int wanted = step_ - steps_ago;
  const Node& node = nodes_[follower][std::clamp((wanted - first) / options_.spacing, 0, complete)];
  const double tau = (wanted - first) % options_.spacing * dt_;
  return Motion2(CoordinatedTurn{tau, options_.q, options_.q_turn}.predicted(node.believed.x, node.believed.omega.value).mean.head<4>());
}

}  // namespace holdfast::bench
