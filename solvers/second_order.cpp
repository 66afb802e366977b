#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <holdfast/graph/gradient.hpp>
#include <holdfast/solvers/detail/clock.hpp>
#include <holdfast/solvers/irls/internal/newton_system.hpp>
#include <holdfast/solvers/second_order.hpp>
#include <memory>
#include <optional>
#include <random>
#include <sstream>

namespace holdfast {
namespace {

using detail::NewtonSystem;
using Eigen::MatrixXd;
using Eigen::VectorXd;

constexpr double kDamping = 1e-3;         // of the diagonal, in M
constexpr double kMoved = 1e-4;           // by a finite difference, in the norm of M: sigmas, about
constexpr double kMostMoved = 1e-3;       // by it, of any component [m, rad]
constexpr double kLeastDecrease = 1e-10;  // of the cost, by a step off a saddle: less is rounding

/// True where Lanczos on n unknowns would have shown a negative eigenvalue after k steps from a random vector. Its part in the first
/// vector, 1/√n of it or so, grows by 1 + 2γ + 2√(γ² + γ) a step, where γ is how far below the other eigenvalues it lies in widths of
/// theirs (the growth of a Chebyshev polynomial outside of its interval). What is asked for is ten times as much as makes it whole.
bool would_have_shown(double least, double most, int k, int n) {
  constexpr double kMargin = 10, kLeastWidth = 1e-3;
  if (!(least > 0)) return false;
  const double gamma = least / std::max(most - least, kLeastWidth * least);
  const double growth = 1 + 2 * gamma + 2 * std::sqrt(gamma * gamma + gamma);
  return 0.5 * std::pow(growth, k - 1) >= kMargin * std::sqrt(n);
}

/// The curvature of Graph::cost at one point, against the model M that a NewtonSystem has factored.
class CurvatureCheck {
 public:
  CurvatureCheck(const Graph& graph, const Values& values, NewtonSystem& system)
      : graph_(graph), values_(values), system_(system), gradient_(graph), moved_(values) {
    cost_ = gradient_(graph_, system_.resolved(), values_, here_, &system_.pool());
  }

  /// M = H + λ D at the values. False where the cost cannot be modelled here: H is not finite, or no damping makes it positive definite.
  bool factor_model() {
    cost_ = system_.linearize(graph_, values_, Curvature::irls);
    const auto is_finite = [](double x) { return std::isfinite(x); };
    if (!std::isfinite(cost_) || !std::all_of(system_.diagonal().begin(), system_.diagonal().end(), is_finite)) return false;
    return system_.factor_by_blocks(kDamping);
  }

  enum class Difference { one_sided, central };  ///< of gradients: one or two of them a Lanczos step
  struct Lowest {
    double theta = 0;
    bool is_sure = false;           ///< would_have_shown(), or the whole space was searched
    std::vector<double> direction;  ///< in Resolved's tangent, vᵀMv = 1
  };
  /// Empty where a gradient is not finite.
  std::optional<Lowest> lowest(int steps, double enough, Difference difference) {
    const int n = system_.resolved().tangent_dim();
    const int most = std::min(n, steps);
    MatrixXd Q(n, most), MQ(n, most), T = MatrixXd::Zero(most, most);
    VectorXd Mw = first_vector(), w = solve(Mw), vector;
    Lowest found;
    int k = 0;
    while (k < most && !found.is_sure) {
      orthogonalise(Q.leftCols(k), MQ.leftCols(k), w, Mw);
      const double norm2 = w.dot(Mw);
      if (!(norm2 > kBreakdown * kBreakdown)) break;  // an invariant subspace: all that the first vector reaches
      Q.col(k) = w / std::sqrt(norm2);
      MQ.col(k) = Mw / std::sqrt(norm2);
      const VectorXd p = hessian_times(Q.col(k), difference);
      if (!p.allFinite()) return std::nullopt;
      const VectorXd column = Q.leftCols(k + 1).transpose() * p;
      T.col(k).head(k + 1) = column;
      T.row(k).head(k + 1) = column.transpose();
      ++k;
      const Eigen::SelfAdjointEigenSolver<MatrixXd> eigen(T.topLeftCorner(k, k));
      found.theta = eigen.eigenvalues()[0];
      vector = eigen.eigenvectors().col(0);
      if (found.theta < -enough && k >= std::min(most, kLeastSteps)) break;
      found.is_sure = k == n || (k > 1 && would_have_shown(found.theta, eigen.eigenvalues()[k - 1], k, n));
      if (k == most || found.is_sure) break;
      Mw = p;
      w = solve(Mw);
      scale_down(w, Mw);
    }
    if (k > 0) found.direction = to_tangent(Q.leftCols(k) * vector);
    return found;
  }

  /// values ⊕ t v of the lowest cost, over steps of either sign; false where none is lower.
  bool step_off(const std::vector<double>& direction, Values& best) {
    constexpr int kFirst = -14, kLast = 30;  // t = 2^k
    double lowest = cost_ - kLeastDecrease * std::abs(cost_);
    bool found = false;
    for (const double sign : {1.0, -1.0})
      for (int k = kFirst; k <= kLast; ++k) {
        move(direction, sign * std::ldexp(1, k));
        const double cost = system_.resolved().cost(graph_, moved_, &system_.pool());
        if (cost < lowest) {
          lowest = cost;
          best.assign(moved_);
          found = true;
        } else if (found && cost > cost_) {
          break;
        }
      }
    return found;
  }

 private:
  static constexpr double kBreakdown = 1e-10;
  static constexpr int kLeastSteps = 3;  // the direction is worth a few more than the first sign of it

  VectorXd first_vector() const {
    std::mt19937_64 rng(1);  // its numbers are the same everywhere; those of std::normal_distribution are not
    const std::vector<double> scales = system_.block_scales();
    VectorXd b(static_cast<Eigen::Index>(scales.size()));
    for (Eigen::Index i = 0; i < b.size(); ++i) b[i] = (std::ldexp(static_cast<double>(rng() >> 11), -52) - 1) * std::sqrt(scales[i]);
    return b;
  }

  VectorXd solve(const VectorXd& b) {
    const std::vector<double> rhs(b.data(), b.data() + b.size());
    std::vector<double> x(rhs.size());
    system_.solve_again(rhs, x);
    return Eigen::Map<const VectorXd>(x.data(), b.size());
  }

  template <class Basis>
  static void orthogonalise(const Basis& Q, const Basis& MQ, VectorXd& w, VectorXd& Mw) {
    for (int twice = 0; twice < 2; ++twice) {
      const VectorXd c = MQ.transpose() * w;
      w -= Q * c;
      Mw -= MQ * c;
    }
  }
  /// So that kBreakdown is relative to what came out of M⁻¹∇²f.
  static void scale_down(VectorXd& w, VectorXd& Mw) {
    const double norm = std::sqrt(std::max(0.0, w.dot(Mw)));
    if (!(norm > 0)) return;
    w /= norm;
    Mw /= norm;
  }

  std::vector<double> to_tangent(const VectorXd& ordered) const {
    std::vector<double> tangent(ordered.size());
    system_.to_tangent({ordered.data(), ordered.data() + ordered.size()}, tangent);
    return tangent;
  }
  void move(const std::vector<double>& direction, double t) {
    std::vector<double> delta = direction;
    for (double& d : delta) d *= t;
    system_.resolved().retract(values_, delta.data(), moved_);
  }
  const std::vector<double>& gradient_at(const std::vector<double>& direction, double t, std::vector<double>& g) {
    move(direction, t);
    gradient_(graph_, system_.resolved(), moved_, g, &system_.pool());
    return g;
  }
  VectorXd hessian_times(const VectorXd& q, Difference difference) {
    const std::vector<double> direction = to_tangent(q);
    const double h = std::min(kMoved, kMostMoved / q.cwiseAbs().maxCoeff());
    const bool is_central = difference == Difference::central;
    gradient_at(direction, h, ahead_);
    const std::vector<double>& behind = is_central ? gradient_at(direction, -h, behind_) : here_;
    for (std::size_t i = 0; i < ahead_.size(); ++i) ahead_[i] = (ahead_[i] - behind[i]) / (is_central ? 2 * h : h);
    std::vector<double> p(ahead_.size());
    system_.from_tangent(ahead_, p);
    return Eigen::Map<const VectorXd>(p.data(), q.size());
  }

  const Graph& graph_;
  const Values& values_;
  NewtonSystem& system_;
  GradientEvaluator gradient_;
  Values moved_;
  std::vector<double> here_, ahead_, behind_;  // gradients
  double cost_ = 0;
};

/// Looks at the answer. True where it was a saddle, and `values` is off it now.
bool leave(const Graph& graph, Values& values, NewtonSystem& system, const SecondOrderOptions& options, SecondOrder& end) {
  const auto not_checked = [&](const char* why) {
    end.verdict = SecondOrder::Verdict::not_checked;
    end.why = why;
    return false;
  };
  const auto is_minimum = [&] {
    end.verdict = end.saddles > 0 ? SecondOrder::Verdict::left_saddle : SecondOrder::Verdict::minimum;
    return false;
  };
  end.curvature = 0;
  CurvatureCheck check(graph, values, system);
  if (system.is_factored()) {  // near by, by the solve: mostly good enough to see that all is well
    const auto quick = check.lowest(options.lanczos_steps, options.curvature_tolerance, CurvatureCheck::Difference::one_sided);
    if (quick && quick->is_sure && quick->theta > options.curvature_tolerance) {
      end.curvature = quick->theta;
      return is_minimum();
    }
  }
  if (!check.factor_model()) return not_checked("the normal equations are not finite or not positive definite at the answer");
  const auto lowest = check.lowest(options.lanczos_steps, options.curvature_tolerance, CurvatureCheck::Difference::central);
  if (!lowest) return not_checked("a gradient near the answer is not finite");
  end.curvature = lowest->theta;
  if (lowest->theta >= -options.curvature_tolerance) return is_minimum();
  if (end.saddles >= options.max_saddles) return not_checked("the answer is a saddle, and max_saddles is reached");
  Values off = values;
  if (!check.step_off(lowest->direction, off)) return not_checked("the curvature is negative, and yet no step lowers the cost");
  values.assign(off);
  return true;
}

/// A back-end under these options, asked for no more than a solve, for as long as this lives.
class Alone {
 public:
  Alone(Backend& backend, const Options& options) : backend_(backend), before_(backend.options) {
    backend_.options = options;
    backend_.options.second_order = backend_.options.findings = false;
  }
  ~Alone() { backend_.options = before_; }
  Alone(const Alone&) = delete;
  Alone& operator=(const Alone&) = delete;

 private:
  Backend& backend_;
  const Options before_;
};

void add_up(const Summary& before, Summary& now) {
  now.cost_first = before.cost_first;
  now.iterations += before.iterations;
  now.restarts += before.restarts;
  now.seconds += before.seconds;
  now.seconds_setup += before.seconds_setup;
  now.seconds_linearize += before.seconds_linearize;
  now.seconds_solve += before.seconds_solve;
}

}  // namespace

void SecondOrderOptions::validate() const {
  if (lanczos_steps < 1) fail<BadOption>("SecondOrderOptions.lanczos_steps = ", lanczos_steps, ", must be >= 1");
  if (!(curvature_tolerance > 0 && curvature_tolerance < 1))
    fail<BadOption>("SecondOrderOptions.curvature_tolerance = ", curvature_tolerance, ", must be in (0, 1)");
  if (max_saddles < 0) fail<BadOption>("SecondOrderOptions.max_saddles = ", max_saddles, ", must be >= 0");
}

std::string SecondOrder::str() const {
  std::ostringstream text;
  text << to_string(verdict);
  if (verdict == Verdict::not_checked) text << " (" << why << ")";
  if (saddles > 0) text << ", saddles left: " << saddles;
  text << "; " << summary;
  return text.str();
}

SecondOrder second_order_from(const Graph& graph, Values& values, Backend& backend, Summary solved, const SecondOrderOptions& options) {
  options.validate();
  SecondOrder end;
  end.summary = std::move(solved);
  Values x = values;
  Backend& near = backend.near_answer();
  const Alone alone(near, backend.options);
  std::unique_ptr<NewtonSystem> own;  // where the back-end keeps none
  while (end.summary.termination == Termination::converged) {
    const Stopwatch watch;
    NewtonSystem* system = near.last_system(graph, x);
    if (system == nullptr) {
      if (!own) own = std::make_unique<NewtonSystem>(graph, x, near.options.threads);
      system = own.get();
    }
    const bool left = leave(graph, x, *system, options, end);
    end.seconds_check += watch.seconds();
    if (!left) break;
    ++end.saddles;
    Summary again = near.solve(graph, x);
    add_up(end.summary, again);
    end.summary = std::move(again);
  }
  if (end.summary.termination != Termination::converged) {
    end.verdict = SecondOrder::Verdict::not_checked;
    end.why = std::string("the solve did not converge: ") + end.summary.why();
  }
  if (end.summary.usable()) values.assign(x);
  return end;
}

SecondOrder second_order(const Graph& graph, Values& values, Backend& backend, const SecondOrderOptions& options) {
  options.validate();
  Values x = values;
  const Alone alone(backend, backend.options);
  Summary solved = backend.solve(graph, x);
  SecondOrder end = second_order_from(graph, x, backend, std::move(solved), options);
  if (end.summary.usable()) values.assign(x);
  return end;
}

bool may_hide_saddles(const Graph& graph) {
  return std::any_of(graph.batches().begin(), graph.batches().end(), [](const auto& batch) {
    return !batch->is_linear() && batch->residual_dim() < *std::max_element(batch->dims().begin(), batch->dims().end());
  });
}

}  // namespace holdfast
