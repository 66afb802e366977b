#include <cmath>
#include <holdfast/benchmarks/suites/fista.hpp>
#include <holdfast/graph/gradient.hpp>
#include <holdfast/graph/resolved.hpp>
#include <holdfast/solvers/detail/clock.hpp>

namespace holdfast::bench {
namespace {

/// By scalar of the tangent: twice Σ w ‖J‖² over the factors on its variable, J where every pair is moved apart.
std::vector<double> metric(const Graph& graph, const Resolved& resolved, const Values& values) {
  Values apart = values;
  std::vector<double> move(resolved.tangent_dim());
  for (std::size_t i = 0; i < move.size(); ++i) move[i] = 1e6 * std::sin(1.0 + static_cast<double>(i));
  resolved.retract(values, move.data(), apart);
  std::vector<double> D(move.size(), 0);
  for (std::size_t b = 0; b < graph.batches().size(); ++b) {
    const FactorBatch& batch = *graph.batches()[b];
    Eigen::VectorXd r(batch.residual_dim());
    Eigen::MatrixXd J(batch.residual_dim(), batch.total_dim());
    for (int i = 0; i < batch.size(); ++i) {
      batch.evaluate(apart, resolved.batches()[b].index.data(), i, i + 1, r.data(), J.data());
      int column = 0;
      for (int k = 0; k < batch.arity(); ++k) {
        const int offset = resolved.variables()[resolved.batches()[b].variable[static_cast<std::size_t>(i) * batch.arity() + k]].offset;
        for (int c = 0; c < batch.dims()[k]; ++c, ++column)
          if (offset >= 0) D[offset + c] += 2 * batch.weight(i) * J.col(column).squaredNorm();
      }
    }
  }
  return D;
}

}  // namespace

Summary Fista::minimize(const Graph& graph, Values& values) {
  constexpr int kMaxIterations = 100000, kPatience = 50;
  const int most = options.max_iterations > 0 ? options.max_iterations : kMaxIterations;
  const Stopwatch watch;
  Summary summary;
  const Resolved resolved(graph, values);
  GradientEvaluator evaluate(graph);
  const std::vector<double> D = metric(graph, resolved, values);
  Values x = values, y = values, next = values;
  std::vector<double> g, step(D.size()), move(D.size());
  summary.cost_first = summary.cost = evaluate(graph, resolved, y, g);
  double t = 1, L = 1, patience_cost = summary.cost;
  const auto end = [&](Termination termination, const char* rule) {
    summary.termination = termination;
    summary.rule = rule;
  };
  end(Termination::iteration_limit, "max_iterations reached");
  if (!std::isfinite(summary.cost)) end(Termination::failed, "the cost at the start is not finite");
  while (summary.usable() && summary.iterations < most) {
    if (options.trace) summary.trace.push_back({summary.iterations, summary.cost, 0, watch.seconds()});
    if (watch.seconds() > options.time_limit) {
      end(Termination::time_limit, "time_limit reached");
      break;
    }
    const double cost_y = evaluate(graph, resolved, y, g);
    ++summary.iterations;
    double cost = 0, norm2 = 0;
    for (std::size_t i = 0; i < g.size(); ++i) norm2 += D[i] > 0 ? g[i] * g[i] / D[i] : 0;
    for (;; L *= 2) {
      for (std::size_t i = 0; i < g.size(); ++i) step[i] = D[i] > 0 ? -g[i] / (L * D[i]) : 0;
      resolved.retract(y, step.data(), next);
      cost = resolved.cost(graph, next);
      if (cost <= cost_y - norm2 / (2 * L) + 1e-14 * std::abs(cost_y) || L > 1e30) break;
    }
    resolved.local(x, next, move.data());
    double uphill = 0;
    for (std::size_t i = 0; i < g.size(); ++i) uphill += g[i] * move[i];
    if ((uphill > 0 || cost > summary.cost) && t > 1) {
      t = 1;
      y.assign(x);
      continue;
    }
    const double t_next = (1 + std::sqrt(1 + 4 * t * t)) / 2;
    for (double& m : move) m *= (t - 1) / t_next;
    std::swap(x, next);
    resolved.retract(x, move.data(), y);
    t = t_next;
    summary.cost = std::min(cost, summary.cost);
    if (summary.iterations % kPatience != 0) continue;
    if (patience_cost - summary.cost <= options.cost_tolerance * patience_cost) {
      end(Termination::converged, "the relative decrease of the cost is within cost_tolerance");
      break;
    }
    patience_cost = summary.cost;
  }
  values.assign(x);
  return summary;
}

}  // namespace holdfast::bench
