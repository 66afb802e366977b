// Our estimator on paper B's problem: eight followers in one graph, each at an unknown turn rate, with an arrival cost.
//
// A state every `spacing` samples is enough for a drone that flies smoothly; a sample τ after it measures p + τ v (τ ≤ 0.5 s: what the turn
// adds to that, ½ v ω τ² = 1 mm, is left out). The residual is robust one by one.
//   lag 0   the latest state, its samples so far, and the arrival cost: what all before says of it, marginalised
//   (solvers/window/marginalize.hpp)
//           where its next state begins
//   later   `window` states with the turns between them (coordinated_turn.hpp), solved whenever one is complete
// A sample is flagged as an outlier where it is further than `outlier` from the answer of the state that holds it, when that is complete.
#pragma once

#include <holdfast/factors/coordinated_turn.hpp>
#include <holdfast/factors/huber_measurement.hpp>
#include <holdfast/solvers/backend.hpp>
#include <holdfast/solvers/window/marginalize.hpp>
#include <vector>

namespace holdfast::bench {

/// What is known of a state and its turn rate: r = W ([x; ω] − mean).
struct TurningPrior {
  Vector<5> mean;
  Matrix<5, 5> sqrt_information;

  using Variables = variables<Motion2, Scalar>;
  static constexpr int residual_dim = 5;
  static constexpr bool is_linear = true;
  static const char* name() { return "TurningPrior"; }
  Vector<5> operator()(const Motion2& x, const Scalar& omega, Jacobians<TurningPrior>* J = nullptr) const;
};

struct FlightTrackerOptions {
  Loss loss = Huber{2.5};    ///< of a sample
  double R = 0.7;            ///< of a sample, each axis [m²]
  double q = 2e-6;           ///< [m²/s³]
  double q_turn = 5e-6;      ///< [rad²/s³]
  double sigma_turn = 0.03;  ///< of the first turn rate [rad/s]
  int spacing = 16;          ///< samples a state
  int window = 6;            ///< states
  bool looks_back = true;    ///< false: lag 0 alone
  double outlier = 3.5;      ///< [m]: GPS has 1 m
  std::string backend = "irls";
  double cost_tolerance = 0;  ///< of a solve: to the last digit, so that every back-end gives the same numbers
};

class FlightTracker {
 public:
  /// dt: between two samples [s]; start: of each follower, known to 1 m and 0.3 m/s on each axis.
  FlightTracker(double dt, const std::vector<Motion2>& start, const FlightTrackerOptions& options);

  /// A sample of each follower [m].
  void step(const std::vector<Vector<2>>& gps);

  /// Now, from all that came.
  Motion2 state(std::size_t follower) const;
  Matrix<4, 4> covariance(std::size_t follower) const;
  /// So many samples ago, from all that came until the latest complete state; not before the first state of the window.
  Motion2 smoothed(std::size_t follower, int steps_ago) const;

  /// Flagged samples, by follower and step.
  struct Flag {
    std::size_t follower;
    int step;
  };
  const std::vector<Flag>& flags() const { return flags_; }
  /// Samples that have been judged.
  int judged() const { return judged_; }

  struct Believed {
    Motion2 x;
    Scalar omega;
  };
  /// A state and what is known of it.
  struct Node {
    TurningPrior arrival;
    Believed believed;
    std::vector<Vector<2>> gps;  ///< its samples, one every dt
  };
  /// What a state leaves for the next one when it goes, samples at their weights at `believed`; and where that one begins.
  Node following(const Node& node);

 private:
  using Sample = HuberMeasurement<Motion2>;
  /// `states` states of every follower in a graph whose structure stays.
  struct Window {
    Window(int states, std::size_t followers, const FlightTracker& tracker);
    Key x(std::size_t follower, int state) const { return Agent('S', follower)(static_cast<std::uint64_t>(state)); }
    Key omega(std::size_t follower, int state) const { return Agent('W', follower)(static_cast<std::uint64_t>(state)); }
    void set_arrival(std::size_t follower, const Node& node);
    void set_sample(std::size_t follower, int state, std::size_t i, const Vector<2>& gps);
    void start_at(std::size_t follower, int state, const Node& node);
    Believed believed(std::size_t follower, int state) const;
    void solve() { backend->solve(graph, values); }

    Graph graph;
    Values values;
    std::vector<FactorId> arrivals;                           ///< by follower
    std::vector<std::vector<std::vector<FactorId>>> samples;  ///< by follower, state, place
    std::unique_ptr<Backend> backend;
  };

  Sample sample(std::size_t i, const Vector<2>& gps) const;
  void complete_states();
  void judge(std::size_t follower);
  void look_back();

  const double dt_;
  const FlightTrackerOptions options_;
  const CoordinatedTurn turn_;
  std::vector<std::vector<Node>> nodes_;  ///< by follower: the latest `window` complete ones, then the one that fills
  Window now_, back_;
  Marginalizer marginalizer_;
  int step_ = -1;
  std::vector<Flag> flags_;
  int judged_ = 0;
};

}  // namespace holdfast::bench
