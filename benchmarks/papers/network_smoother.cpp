#include <Eigen/Cholesky>
#include <holdfast/benchmarks/papers/network_smoother.hpp>
#include <holdfast/factors/white_jerk.hpp>
#include <holdfast/solvers/detail/clock.hpp>
#include <holdfast/solvers/marginals.hpp>
#include <holdfast/solvers/table.hpp>

namespace holdfast::bench {
namespace {

constexpr double kTolerance = 0;  // to the last digit: every back-end gives the same numbers

template <int S>
class Smoother {
 public:
  using State = Kinematic<double, S, 3>;
  using Motion = WhiteJerk<State>;

  Smoother(const Network<S>& network, const NetworkSmoother& recipe) : network_(network), backend_(make_backend(recipe.backend)) {
    backend_->options.cost_tolerance = kTolerance;
    const int steps = static_cast<int>(network.steps.size()), nodes = static_cast<int>(network.steps[0].nodes.size());
    const Motion motion = motion_of(recipe.density > 0 ? recipe.density : std::sqrt(kLeastDensity * kGreatestDensity));
    for (int k = 0; k < steps; ++k) {
      for (int i = 0; i < nodes; ++i) {
        values_.insert(node_key(i, k), State());
        if (k > 0) motions_.push_back({graph_.add(motion, {node_key(i, k - 1), node_key(i, k)}), node_key(i, k - 1), node_key(i, k)});
      }
      add_packets<State>(network, k, recipe.missing, graph_, values_);
    }
  }

  ConvexStart start() {
    ConvexStart found = convex_start(graph_, values_, *backend_);
    require(found.refined);
    return found;
  }
  /// Bisection of log q: below the best q the motion's residuals are larger than expected.
  double learn_density() {
    double low = kLeastDensity, high = kGreatestDensity;
    while (high / low > kDensityStep) {
      const double middle = std::sqrt(low * high);
      solve_with(middle);
      (excess(middle) > 0 ? low : high) = middle;
    }
    const double density = std::sqrt(low * high);
    solve_with(density);
    return density;
  }
  Tracks<S> tracks() const {
    Tracks<S> tracks;
    for (std::size_t k = 0; k < network_.steps.size(); ++k) {
      tracks.emplace_back();
      for (std::size_t i = 0; i < network_.steps[k].nodes.size(); ++i)
        tracks.back().push_back(values_.at<State>(node_key(static_cast<int>(i), static_cast<int>(k))).position());
    }
    return tracks;
  }
  double anees() const {
    const Marginals marginals(graph_, values_);
    const Matrix<S, State::dim> C = State::position_jacobian();
    const int middle = static_cast<int>(network_.steps.size() / 2), nodes = static_cast<int>(network_.steps[middle].nodes.size());
    double sum = 0;
    for (int i = 0; i < nodes; ++i) {
      const Vector<S> error = values_.at<State>(node_key(i, middle)).position() - network_.steps[middle].nodes[i];
      const Matrix<S, S> P = C * marginals.covariance<State>(node_key(i, middle)) * C.transpose();
      sum += error.dot(P.llt().solve(error)) / S;
    }
    return sum / nodes;
  }

 private:
  struct Step {
    FactorId id;
    Key from, to;
  };
  static Motion motion_of(double density) { return Motion::continuous(1, density); }
  static void require(const Summary& summary) {
    if (!summary.usable()) fail<BadProblem>("a network of paper C: ", summary.why());
  }

  void solve_with(double density) {
    const Motion motion = motion_of(density);
    for (const Step& step : motions_) graph_.template at<Motion>(step.id) = motion;
    require(backend_->solve(graph_, values_));
  }
  /// Mean of the motion's squared residuals over the posterior, less what is expected.
  double excess(double density) const {
    const Marginals marginals(graph_, values_);
    const Motion motion = motion_of(density);
    double sum = 0;
    for (const Step& step : motions_) {
      Jacobians<Motion> J;
      sum += motion(values_.at<State>(step.from), values_.at<State>(step.to), &J).squaredNorm();
      sum += (J.all * marginals.joint<State, State>(step.from, step.to) * J.all.transpose()).trace();
    }
    return sum / static_cast<double>(motions_.size() * State::dim) - 1;
  }

  const Network<S>& network_;
  std::unique_ptr<Backend> backend_;
  Graph graph_;
  Values values_;
  std::vector<Step> motions_;
};

}  // namespace

template <int S>
SmoothedNetwork<S> smooth(const Network<S>& network, const NetworkSmoother& recipe) {
  const Stopwatch watch;
  Smoother<S> smoother(network, recipe);
  SmoothedNetwork<S> smoothed;
  smoothed.start = smoother.start();
  smoothed.density = recipe.density > 0 ? recipe.density : smoother.learn_density();
  smoothed.seconds = watch.seconds();
  smoothed.tracks = smoother.tracks();
  smoothed.anees = smoother.anees();
  return smoothed;
}

template SmoothedNetwork<2> smooth<2>(const Network<2>&, const NetworkSmoother&);
template SmoothedNetwork<3> smooth<3>(const Network<3>&, const NetworkSmoother&);

}  // namespace holdfast::bench
