#include <algorithm>
#include <holdfast/solvers/irls/internal/convex_descent.hpp>
#include <holdfast/solvers/irls/internal/linear_descent.hpp>
#include <holdfast/solvers/irls/internal/nonlinear_descent.hpp>
#include <holdfast/solvers/irls/irls.hpp>
#include <holdfast/solvers/linear/internal/linear_rows.hpp>

namespace holdfast {
namespace {

constexpr int kMaxIterations = 1000;

void require_unknowns(const Resolved& resolved) {
  if (resolved.tangent_dim() == 0) fail<BadProblem>("every variable that a factor touches is fixed; there is nothing to solve for");
}

bool all_linear(const Graph& graph) {
  return std::all_of(graph.batches().begin(), graph.batches().end(), [](const auto& batch) { return batch->is_linear(); });
}

}  // namespace

/// What is kept between solves of one structure.
struct Irls::Workspace {
  Workspace(const Graph& graph, const Values& values, int threads)
      : system(graph, values, threads), nonlinear(graph, values, system), convex(values), linear(system) {}

  detail::NewtonSystem system;
  detail::NonlinearDescent nonlinear;
  detail::ConvexDescent convex;
  detail::LinearFronts linear;
};

Irls::Irls(Options chosen, IrlsOptions of_irls)
    : Backend(std::move(chosen)), irls_options(of_irls), rows_(std::make_unique<detail::LinearRows>()) {}
Irls::~Irls() = default;

detail::NewtonSystem* Irls::last_system(const Graph& graph, const Values& values) {
  return workspace_ && workspace_->system.serves(graph, values, options.threads) ? &workspace_->system : nullptr;
}

Curvature Irls::curvature(const Graph& graph, bool linear) const {
  if (irls_options.reweighting == Reweighting::irls) return Curvature::irls;
  if (irls_options.reweighting == Reweighting::newton) return Curvature::newton;
  const bool convex =
      std::all_of(graph.batches().begin(), graph.batches().end(), [](const auto& batch) { return batch->family().is_convex(); });
  return linear && convex ? Curvature::newton : Curvature::irls;
}

Summary Irls::minimize(const Graph& graph, Values& values) {
  Progress progress(options, kMaxIterations);
  const bool linear = all_linear(graph);
  if (linear && rows_->load(graph, values)) {
    require_unknowns(rows_->resolved());
    progress.watch.lap(progress.summary.seconds_setup);
    detail::descend_linear(graph, values, *rows_, curvature(graph, true), options.cost_tolerance, progress);
    if (progress.summary.usable()) rows_->retract(values);
    return std::move(progress.summary);
  }
  if (!workspace_ || !workspace_->system.serves(graph, values, options.threads))
    workspace_ = std::make_unique<Workspace>(graph, values, options.threads);
  Workspace& w = *workspace_;
  require_unknowns(w.system.resolved());
  progress.watch.lap(progress.summary.seconds_setup);
  if (linear) {
    w.linear.load(graph, values);
    detail::descend_linear(graph, values, w.linear, curvature(graph, true), options.cost_tolerance, progress);
    w.linear.retract(values);
  } else if (irls_options.reweighting == Reweighting::automatic && detail::ConvexDescent::serves(graph)) {
    w.convex.minimize(graph, w.system, values, progress);
  } else {
    w.nonlinear.minimize(graph, w.system, values, {curvature(graph, false), options.cost_tolerance, irls_options.restart}, progress);
  }
  return std::move(progress.summary);
}

}  // namespace holdfast
