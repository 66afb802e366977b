#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <holdfast/graph/gradient.hpp>
#include <holdfast/solvers/detail/clock.hpp>
#include <holdfast/solvers/linear/internal/block_cholesky.hpp>
#include <holdfast/solvers/second_order.hpp>
#include <optional>
#include <random>
#include <sstream>

namespace holdfast {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;

constexpr double kDamping = 1e-3;         // of the diagonal, in M
constexpr double kMoved = 1e-4;           // by a finite difference, in the norm of M: sigmas, about
constexpr double kMostMoved = 1e-3;       // by it, of any component [m, rad]
constexpr double kLeastDecrease = 1e-10;  // of the cost, by a step off a saddle: less is rounding

std::vector<int> elimination_order(const Symbolic& symbolic, const std::vector<int>& variable) {
  std::vector<int> order;
  for (int node : symbolic.order) order.push_back(variable[node]);
  return order;
}

/// The curvature of Graph::cost at one point.
class CurvatureCheck {
 public:
  CurvatureCheck(const Graph& graph, const Values& values)
      : graph_(graph),
        values_(values),
        resolved_(graph, values),
        symbolic_(analyze(block_graph(graph, resolved_, variable_))),
        normal_(graph, resolved_, elimination_order(symbolic_, variable_)),
        cholesky_(symbolic_, normal_.pattern()),
        gradient_(graph),
        moved_(values) {}

  /// False where the cost cannot be modelled here: H is not finite, or no damping makes it positive definite.
  bool factor_model() {
    cost_ = normal_.linearize(graph_, resolved_, values_, Curvature::irls);
    const auto is_finite = [](double x) { return std::isfinite(x); };
    if (!std::isfinite(cost_) || !std::all_of(normal_.H().begin(), normal_.H().end(), is_finite)) return false;
    std::vector<double> damping = block_scales();
    for (double& d : damping) d *= kDamping;
    for (int i = 0; i < 8; ++i) {
      if (cholesky_.factor(normal_.H(), damping)) return true;
      for (double& d : damping) d *= 10;
    }
    return false;
  }

  struct Lowest {
    double theta = 0;
    std::vector<double> direction;  ///< in Resolved's tangent, vᵀMv = 1
  };
  /// Empty where a gradient is not finite.
  std::optional<Lowest> lowest(int steps, double enough) {
    const int n = resolved_.tangent_dim();
    const int most = std::min(n, steps);
    MatrixXd Q(n, most), MQ(n, most), T = MatrixXd::Zero(most, most);
    VectorXd Mw = first_vector(), w = solve(Mw), vector;
    Lowest found;
    int k = 0;
    while (k < most) {
      orthogonalise(Q.leftCols(k), MQ.leftCols(k), w, Mw);
      const double norm2 = w.dot(Mw);
      if (!(norm2 > kBreakdown * kBreakdown)) break;  // an invariant subspace: all that the first vector reaches
      Q.col(k) = w / std::sqrt(norm2);
      MQ.col(k) = Mw / std::sqrt(norm2);
      const VectorXd p = hessian_times(Q.col(k));
      if (!p.allFinite()) return std::nullopt;
      const VectorXd column = Q.leftCols(k + 1).transpose() * p;
      T.col(k).head(k + 1) = column;
      T.row(k).head(k + 1) = column.transpose();
      ++k;
      const Eigen::SelfAdjointEigenSolver<MatrixXd> eigen(T.topLeftCorner(k, k));
      found.theta = eigen.eigenvalues()[0];
      vector = eigen.eigenvectors().col(0);
      if (found.theta < -enough && k >= std::min(most, kLeastSteps)) break;
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
        const double cost = resolved_.cost(graph_, moved_);
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

  /// By scalar row: the largest diagonal entry of the variable it belongs to; where that is 0, the largest of all; where that is, 1.
  std::vector<double> block_scales() const {
    const BlockPattern& pattern = normal_.pattern();
    std::vector<double> scales(pattern.scalar_size(), 0);
    double largest = 0;
    for (int i = 0; i < pattern.size(); ++i) {
      const double* block = &normal_.H()[pattern.block_begin[pattern.column_begin[i]]];
      double most = 0;
      for (int c = 0; c < pattern.dims[i]; ++c) most = std::max(most, block[c * (pattern.dims[i] + 1)]);
      std::fill_n(scales.begin() + pattern.offsets[i], pattern.dims[i], most);
      largest = std::max(largest, most);
    }
    for (double& s : scales)
      if (s == 0) s = largest > 0 ? largest : 1;
    return scales;
  }

  VectorXd first_vector() const {
    std::mt19937_64 rng(1);  // its numbers are the same everywhere; those of std::normal_distribution are not
    const std::vector<double> scales = block_scales();
    VectorXd b(static_cast<Eigen::Index>(scales.size()));
    for (Eigen::Index i = 0; i < b.size(); ++i) b[i] = (std::ldexp(static_cast<double>(rng() >> 11), -52) - 1) * std::sqrt(scales[i]);
    return b;
  }

  VectorXd solve(const VectorXd& b) {
    const std::vector<double> rhs(b.data(), b.data() + b.size());
    std::vector<double> x(rhs.size());
    cholesky_.solve(rhs, x);
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
    normal_.to_tangent(resolved_, ordered.data(), tangent.data());
    return tangent;
  }
  void move(const std::vector<double>& direction, double t) {
    std::vector<double> delta = direction;
    for (double& d : delta) d *= t;
    resolved_.retract(values_, delta.data(), moved_);
  }
  VectorXd hessian_times(const VectorXd& q) {
    const std::vector<double> direction = to_tangent(q);
    const double h = std::min(kMoved, kMostMoved / q.cwiseAbs().maxCoeff());
    std::vector<double> ahead, behind;
    move(direction, h);
    gradient_(graph_, resolved_, moved_, ahead);
    move(direction, -h);
    gradient_(graph_, resolved_, moved_, behind);
    for (std::size_t i = 0; i < ahead.size(); ++i) ahead[i] = (ahead[i] - behind[i]) / (2 * h);
    VectorXd p(q.size());
    normal_.from_tangent(resolved_, ahead.data(), p.data());
    return p;
  }

  const Graph& graph_;
  const Values& values_;
  Resolved resolved_;
  std::vector<int> variable_;
  Symbolic symbolic_;
  NormalEquations normal_;
  BlockCholesky cholesky_;
  GradientEvaluator gradient_;
  Values moved_;
  double cost_ = 0;
};

/// Looks at the answer. True where it was a saddle, and `values` is off it now.
bool leave(const Graph& graph, Values& values, const SecondOrderOptions& options, SecondOrder& end) {
  const auto not_checked = [&](const char* why) {
    end.verdict = SecondOrder::Verdict::not_checked;
    end.why = why;
    return false;
  };
  end.curvature = 0;
  CurvatureCheck check(graph, values);
  if (!check.factor_model()) return not_checked("the normal equations are not finite or not positive definite at the answer");
  const auto lowest = check.lowest(options.lanczos_steps, options.curvature_tolerance);
  if (!lowest) return not_checked("a gradient near the answer is not finite");
  end.curvature = lowest->theta;
  if (lowest->theta >= -options.curvature_tolerance) {
    end.verdict = end.saddles > 0 ? SecondOrder::Verdict::left_saddle : SecondOrder::Verdict::minimum;
    return false;
  }
  if (end.saddles >= options.max_saddles) return not_checked("the answer is a saddle, and max_saddles is reached");
  Values off = values;
  if (!check.step_off(lowest->direction, off)) return not_checked("the curvature is negative, and yet no step lowers the cost");
  values.assign(off);
  return true;
}

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

const char* to_string(SecondOrder::Verdict verdict) {
  static const char* const names[] = {"second-order minimum", "left a saddle", "not checked"};
  return names[static_cast<int>(verdict)];
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
  while (end.summary.termination == Termination::converged) {
    const Stopwatch watch;
    const bool left = leave(graph, x, options, end);
    end.seconds_check += watch.seconds();
    if (!left) break;
    ++end.saddles;
    Summary again = backend.solve(graph, x);
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
