#include <holdfast/benchmarks/papers/flight_tracker.hpp>
#include <holdfast/benchmarks/papers/newton_backend.hpp>
#include <holdfast/factors/prior.hpp>

namespace holdfast::bench {

FlightTracker::FlightTracker(double dt, const std::vector<Motion2>& start, const FlightTrackerOptions& options)
    : dt_(dt), options_(options), now_(window_of(1, start)), later_(window_of(options.window, start)), gps_(start.size()) {}

Window FlightTracker::window_of(int states, const std::vector<Motion2>& start) {
  WindowOptions options;
  options.max_states = states;
  Options solver;
  solver.cost_tolerance = options_.cost_tolerance;
  Window window(options, newton_backend(options_.backend, solver));  // turns are nearly linear, and Huber is convex
  for (std::size_t f = 0; f < start.size(); ++f) {
    window.add_agent(agent(f), [this](double seconds) { return CoordinatedTurn{seconds, options_.q, options_.q_turn}; });
    const Turning2 first(start[f], 0);
    window.add_state(agent(f)(0), 0.0, first);
    window.add(Prior<Turning2>::from_sigmas(first, Vector<5>(1, 0.3, 1, 0.3, options_.sigma_turn)), {agent(f)(0)});
  }
  return window;
}

// r = R^{-1/2} (p + τ v − gps).
HuberMeasurement<Turning2> FlightTracker::sample(std::size_t i, const Vector<2>& gps) const {
  const double tau = static_cast<double>(i) * dt_;
  Matrix<2, 5> B = Turning2::position_jacobian();
  B(0, 1) = B(1, 3) = tau;
  return {Vector<2>::Zero(), gps, B, Matrix<2, 2>::Identity() / std::sqrt(options_.R), 1};
}

void FlightTracker::add(Window& window, std::size_t follower, double time, const std::vector<Vector<2>>& gps, std::size_t from) const {
  const Key state = window.at(agent(follower), time);
  for (std::size_t i = from; i < gps.size(); ++i) window.add(sample(i, gps[i]), {state}, options_.loss, 1.0);
}

void FlightTracker::step(const std::vector<Vector<2>>& gps) {
  ++step_;
  const int place = step_ % options_.spacing;
  const double state = (step_ - place) * dt_;  // [s]
  for (std::size_t f = 0; f < gps.size(); ++f) {
    if (step_ > 0 && place == 0) {
      if (options_.looks_back) add(later_, f, state - options_.spacing * dt_, gps_[f]);
      judge(f, now_.newest<Turning2>(agent(f)));
      gps_[f].clear();
    }
    gps_[f].push_back(gps[f]);
    add(now_, f, state, gps_[f], gps_[f].size() - 1);
  }
  now_.step(state);
  if (step_ > 0 && place == 0 && options_.looks_back) later_.step(state - options_.spacing * dt_);
}

void FlightTracker::judge(std::size_t follower, const Turning2& state) {
  for (std::size_t i = 0; i < gps_[follower].size(); ++i, ++judged_) {
    const Vector<2> r = sample(i, gps_[follower][i])(state);  // in sigmas
    if (std::sqrt(options_.R) * r.norm() > options_.outlier)
      flags_.push_back({follower, step_ - static_cast<int>(gps_[follower].size()) + static_cast<int>(i)});
  }
}

}  // namespace holdfast::bench
