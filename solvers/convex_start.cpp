#include <algorithm>
#include <array>
#include <holdfast/graph/resolved.hpp>
#include <holdfast/solvers/convex_start.hpp>
#include <holdfast/solvers/table.hpp>
#include <sstream>

namespace holdfast {
namespace {

constexpr int kPatience = 200;  // iterations of irls: what takes longer is a swarm of balls, where nesterov is the faster

/// What is said of one variable by factors of its own: H δ = −g.
struct Own {
  Eigen::MatrixXd H;
  Eigen::VectorXd g;
};

/// The mean position of what is known in a space of two or three dimensions.
struct Centroid {
  Vector<3> sum = Vector<3>::Zero();
  int count = 0;
  Vector<3> mean() const { return count == 0 ? sum : Vector<3>(sum / count); }
  void add(const PoolBase& pool, int i) {
    Vector<3> p = Vector<3>::Zero();
    pool.position(i, p.data());
    sum += p;
    ++count;
  }
};

/// The tangent that moves a position by v and nothing else.
Eigen::VectorXd translation(const PoolBase& pool, int i, const Vector<3>& v) {
  const double no_turn[3] = {};
  Eigen::VectorXd delta(pool.dim());
  pool.rigid_motion(i, v.data(), no_turn, delta.data());
  return delta;
}

void add_own_factors(const FactorBatch& batch, const Resolved::Batch& where, const Values& values, std::vector<Own>& own) {
  const int m = batch.residual_dim(), n = batch.total_dim();
  Eigen::VectorXd r(m);
  Eigen::MatrixXd J(m, n);
  for (int i = 0; i < batch.size(); ++i) {
    batch.evaluate(values, where.index.data(), i, i + 1, r.data(), J.data());
    Own& variable = own[where.variable[i]];
    if (variable.g.size() == 0) variable = {Eigen::MatrixXd::Zero(n, n), Eigen::VectorXd::Zero(n)};
    variable.H += batch.weight(i) * J.transpose() * J;
    variable.g += batch.weight(i) * J.transpose() * r;
  }
}

/// Whether H resists a translation in every direction.
bool is_placed(const Own& own, const PoolBase& pool, int i) {
  for (int axis = 0; axis < pool.space(); ++axis) {
    const Eigen::VectorXd motion = translation(pool, i, Vector<3>::Unit(axis));
    if (!(motion.dot(own.H * motion) > 0)) return false;
  }
  return true;
}

/// Per number of dimensions: where fixed variables are, and where a Gauss–Newton step on its own factors takes a variable.
std::array<Centroid, 4> centroids(const Graph& graph, const Values& values) {
  constexpr double kLeast = 1e-9;  // of H: what its own factors do not say of a variable stays as it is
  const Resolved resolved(graph, values);
  std::vector<Own> own(resolved.variables().size());
  for (std::size_t b = 0; b < graph.batches().size(); ++b)
    if (graph.batches()[b]->arity() == 1) add_own_factors(*graph.batches()[b], resolved.batches()[b], values, own);
  Values placed = values;
  std::array<Centroid, 4> centroid;
  for (std::size_t v = 0; v < own.size(); ++v) {
    const Resolved::Variable& variable = resolved.variables()[v];
    PoolBase& pool = placed.pool(variable.pool);
    const int i = variable.index;
    if (pool.space() == 0) continue;
    if (variable.offset >= 0) {
      if (own[v].g.size() == 0 || !is_placed(own[v], pool, i)) continue;
      Eigen::MatrixXd H = own[v].H;
      H.diagonal().array() += kLeast * H.diagonal().maxCoeff();
      const Eigen::VectorXd delta = H.ldlt().solve(-own[v].g);
      pool.retract(i, values.pool(variable.pool), delta.data());
    }
    centroid[pool.space()].add(pool, i);
  }
  return centroid;
}

Values at_centroid(const Graph& graph, const Values& values) {
  const std::array<Centroid, 4> centroid = centroids(graph, values);
  Values moved = values;
  for (std::size_t p = 0; p < moved.pools().size(); ++p) {
    PoolBase& pool = moved.pool(static_cast<int>(p));
    if (pool.space() == 0) continue;
    for (int i = 0; i < pool.size(); ++i) {
      if (graph.is_fixed(pool.keys()[i])) continue;
      Vector<3> position = Vector<3>::Zero();
      pool.position(i, position.data());
      pool.retract(i, values.pool(static_cast<int>(p)), translation(pool, i, centroid[pool.space()].mean() - position).data());
    }
  }
  return moved;
}

bool all_convex(const Graph& graph) {
  return std::all_of(graph.batches().begin(), graph.batches().end(),
                     [](const auto& batch) { return batch->is_convex() && batch->family().is_convex(); });
}

void add_up(const Summary& first, Summary& second) {
  second.cost_first = first.cost_first;
  second.iterations += first.iterations;
  second.seconds += first.seconds;
  second.seconds_setup += first.seconds_setup;
  second.seconds_linearize += first.seconds_linearize;
  second.seconds_solve += first.seconds_solve;
}

Summary solve_relaxed(const Graph& relaxed, Values& values, Options options) {
  const int limit = options.max_iterations;
  options.max_iterations = limit > 0 ? std::min(limit, kPatience) : kPatience;
  const Summary quick = make_backend("irls", options)->solve(relaxed, values);
  if (quick.termination != Termination::iteration_limit || (limit > 0 && limit <= kPatience) || !all_convex(relaxed)) return quick;
  options.max_iterations = limit > 0 ? limit - kPatience : 0;
  Summary patient = make_backend("nesterov", options)->solve(relaxed, values);
  add_up(quick, patient);
  return patient;
}

}  // namespace

std::string RelaxedStart::str() const {
  std::ostringstream text;
  text << "cost " << cost_centroid << " at the centroid; " << (is_convex ? "convex" : "partly relaxed") << " problem: " << relaxed.cost
       << ", " << relaxed.iterations << " iterations, " << relaxed.seconds << " s (" << relaxed.why() << "); cost there " << cost;
  return text.str();
}

RelaxedStart relaxed_start(const Graph& graph, Values& values, const Options& options) {
  RelaxedStart start;
  const Graph relaxed = graph.relaxed();
  Values x = at_centroid(graph, values);
  start.cost_centroid = graph.cost(x);
  start.is_convex = all_convex(relaxed);
  start.relaxed = solve_relaxed(relaxed, x, options);
  start.cost = graph.cost(x);
  if (start.relaxed.usable()) values.assign(x);
  return start;
}

ConvexStart convex_start(const Graph& graph, Values& values, Backend& backend) {
  Values x = values;
  ConvexStart found;
  found.start = relaxed_start(graph, x, backend.options);
  found.refined = found.start.relaxed.usable() ? backend.solve(graph, x) : found.start.relaxed;
  if (found.refined.usable()) values.assign(x);
  return found;
}

}  // namespace holdfast
