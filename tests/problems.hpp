// Small problems that tests of graph/, solvers/ and the back-ends share, and what these tests ask about them.
#pragma once

#include <holdfast/factors/between.hpp>
#include <holdfast/factors/huber_measurement.hpp>
#include <holdfast/factors/position_step.hpp>
#include <holdfast/factors/prior.hpp>
#include <holdfast/factors/range.hpp>
#include <holdfast/factors/range_ball.hpp>
#include <holdfast/factors/relative_point.hpp>
#include <holdfast/factors/von_mises_bearing.hpp>
#include <holdfast/factors/white_acceleration.hpp>
#include <holdfast/graph/gradient.hpp>
#include <holdfast/solvers/table.hpp>
#include <holdfast/testing.hpp>

namespace holdfast::testing {

// ---- losses

inline constexpr int kLossKinds = 10;

/// Every kind with its own default threshold.
inline Loss default_loss(int kind) {
  static const Loss all[kLossKinds]{Squared{},      Absolute{}, Huber{}, PseudoHuber{},      Cauchy{},
                                    GemanMcClure{}, Welsch{},   Tukey{}, TruncatedSquares{}, StudentT{}};
  return all[kind];
}

/// A loss as a user writes one: c² ln(1 + s/c²).
struct UsersLoss {
  double c = 2;
  Rho rho(double s) const {
    const double u = 1 / (1 + s / (c * c));
    return {c * c * std::log1p(s / (c * c)), u, -u * u / (c * c)};
  }
};

/// Every kind and a user's own, per block and per component, and one-sided where a residual of this size has a sign.
inline std::vector<Loss> every_loss(int residual_dim) {
  std::vector<Loss> all;
  for (int kind = 0; kind <= kLossKinds; ++kind) {
    const Loss loss = kind < kLossKinds ? default_loss(kind) : Loss(UsersLoss{});
    all.insert(all.end(), {loss, per_component(loss), one_sided(per_component(loss))});
    if (residual_dim == 1) all.push_back(one_sided(loss));
  }
  return all;
}

/// ρ as the formulas of loss.hpp have it, in the plainest code.
inline double reference_rho(const Loss& loss, double s, int d) {
  const double c = loss.scale, c2 = c * c, root = std::sqrt(s);
  switch (loss.kind) {
    case Loss::Kind::Squared:
      return s;
    case Loss::Kind::Absolute:
      return 2 * (std::sqrt(s + c2) - c);
    case Loss::Kind::Huber:
      return root <= c ? s : 2 * c * root - c2;
    case Loss::Kind::PseudoHuber:
      return 2 * c2 * (std::sqrt(1 + s / c2) - 1);
    case Loss::Kind::Cauchy:
      return c2 * std::log(1 + s / c2);
    case Loss::Kind::GemanMcClure:
      return c2 * s / (c2 + s);
    case Loss::Kind::Welsch:
      return c2 * (1 - std::exp(-s / c2));
    case Loss::Kind::Tukey:
      return root <= c ? c2 / 3 * (1 - std::pow(1 - s / c2, 3)) : c2 / 3;
    case Loss::Kind::TruncatedSquares:
      return std::min(s, c2);
    case Loss::Kind::StudentT:
      return (c + d) * std::log(1 + s / c);
    case Loss::Kind::Own:
      return loss.rho(s, d).value;
  }
  return NAN;
}

/// ρ'(s), differentiated by hand.
inline double reference_slope(const Loss& loss, double s, int d) {
  const double c = loss.scale, c2 = c * c, root = std::sqrt(s);
  switch (loss.kind) {
    case Loss::Kind::Squared:
      return 1;
    case Loss::Kind::Absolute:
      return 1 / std::sqrt(s + c2);
    case Loss::Kind::Huber:
      return root <= c ? 1 : c / root;
    case Loss::Kind::PseudoHuber:
      return 1 / std::sqrt(1 + s / c2);
    case Loss::Kind::Cauchy:
      return c2 / (c2 + s);
    case Loss::Kind::GemanMcClure:
      return c2 * c2 / ((c2 + s) * (c2 + s));
    case Loss::Kind::Welsch:
      return std::exp(-s / c2);
    case Loss::Kind::Tukey:
      return root <= c ? (1 - s / c2) * (1 - s / c2) : 0;
    case Loss::Kind::TruncatedSquares:
      return root <= c ? 1 : 0;
    case Loss::Kind::StudentT:
      return (c + d) / (c + s);
    case Loss::Kind::Own:
      return loss.rho(s, d).first;
  }
  return NAN;
}

/// w ½ρ of a whole residual, and w ρ' of each of its components.
struct ReferenceTerm {
  double cost = 0;
  Eigen::VectorXd weights;
};
inline ReferenceTerm reference_term(const Loss& loss, double weight, const Eigen::VectorXd& r) {
  const int m = static_cast<int>(r.size());
  ReferenceTerm term{0, Eigen::VectorXd(m)};
  const bool block = !loss.per_component && !loss.one_sided;
  for (int c = 0; c < m; ++c) {
    const double s = block ? r.squaredNorm() : r[c] * r[c];
    const bool harmless = loss.one_sided && r[c] > 0;
    if (!block || c == 0) term.cost += 0.5 * weight * (harmless ? s : reference_rho(loss, s, block ? m : 1));
    term.weights[c] = weight * (harmless ? 1 : reference_slope(loss, s, block ? m : 1));
  }
  return term;
}

// ---- solving

/// To the bottom, whatever the back-end.
inline Options to_the_bottom() {
  Options options;
  options.max_iterations = 20000;
  options.cost_tolerance = 1e-14;
  options.gradient_tolerance = 1e-10;
  return options;
}

inline Summary solve(const std::string& backend, const Graph& graph, Values& values, const Options& options = to_the_bottom()) {
  return make_backend(backend, options)->solve(graph, values);
}

inline double max_gradient(const Graph& graph, const Values& values) {
  double largest = 0;
  for (double g : gradient(graph, values).value) largest = std::max(largest, std::abs(g));
  return largest;
}

/// The largest component of b ⊖ a over all keys of a, whatever the order the keys came in.
inline double largest_difference(Values a, Values b) {
  double largest = 0;
  for (Key key : a.keys()) {
    PoolBase& from = a.pool(a.slot(key).pool);
    PoolBase& to = b.pool(b.slot(key).pool);
    Eigen::VectorXd delta(from.dim());
    from.local_ambient(from.data(a.slot(key).index), to.data(b.slot(key).index), delta.data());
    largest = std::max(largest, delta.cwiseAbs().maxCoeff());
  }
  return largest;
}

/// The same keys with the same doubles, bit by bit.
inline bool same_bits(Values a, Values b) {
  if (a.keys() != b.keys()) return false;
  for (Key key : a.keys()) {
    PoolBase& pool = a.pool(a.slot(key).pool);
    const double* x = pool.data(a.slot(key).index);
    const double* y = b.pool(b.slot(key).pool).data(b.slot(key).index);
    if (std::memcmp(x, y, sizeof(double) * static_cast<std::size_t>(pool.ambient())) != 0) return false;
  }
  return true;
}

/// Every free variable moved by normal noise in its tangent.
inline Values perturbed(const Graph& graph, const Values& values, double sigma, std::mt19937_64& rng) {
  const Resolved resolved(graph, values);
  std::normal_distribution<double> normal;
  std::vector<double> delta(resolved.tangent_dim());
  for (double& d : delta) d = sigma * normal(rng);
  Values moved = values;
  resolved.retract(values, delta.data(), moved);
  return moved;
}

// ---- a rigid motion of the world

template <int Space>
struct Motion {
  Matrix<Space, Space> R;
  Vector<Space> t;
};

template <class T, int Axes, int Order>
Kinematic<T, Axes, Order> moved(const Motion<Axes>& world, const Kinematic<T, Axes, Order>& x) {
  Kinematic<T, Axes, Order> out;
  for (int k = 0; k < Order; ++k) {
    Vector<Axes> d = world.R * x.derivative(k);
    if (k == 0) d += world.t;
    for (int axis = 0; axis < Axes; ++axis) out.value[axis * Order + k] = d[axis];
  }
  return out;
}
inline Turning2 moved(const Motion<2>& world, const Turning2& x) { return {moved(world, x.motion()), x.turn_rate()}; }
inline Pose2 moved(const Motion<2>& world, const Pose2& x) { return {Vector<2>(world.R * x.p + world.t), Vector<2>(world.R * x.heading)}; }
inline Pose3 moved(const Motion<3>& world, const Pose3& x) {
  return {Vector<3>(world.R * x.p + world.t), so3::Quaternion<double>(Eigen::Quaterniond(Eigen::Matrix3d(world.R))) * x.q};
}

// ---- problems

struct SmallProblem {
  Graph graph;
  Values truth;  ///< where every residual is zero if noise = 0
  Values start;
};

template <class V>
V random_step(std::mt19937_64& rng, double length, double turn) {
  Vector<V::dim> delta = Vector<V::dim>::Zero();
  constexpr int n = V::space_dim;
  delta.template head<n>() = length * Vector<n>::Unit(0) + random_vector<n>(rng, 0.1 * length);
  delta.template tail<rotation_dim<n>>() = random_vector<rotation_dim<n>>(rng, turn);
  return V{}.retract(delta);
}

/// A walk of poses with odometry, loop closures and landmarks seen by RelativePoint, Range and VonMisesBearingBody; a prior on the first
/// pose. V: Pose2 or Pose3. The start is the truth perturbed.
template <class V>
SmallProblem slam(std::uint64_t seed, int poses, double noise, const Loss& loss = Squared{}, double start_sigma = 0.05) {
  using Point = std::conditional_t<V::space_dim == 2, Point2, Point3>;
  constexpr int n = V::space_dim;
  constexpr Agent A('A'), L('L');
  std::mt19937_64 rng(seed);
  SmallProblem problem;
  V x;
  for (int i = 0; i < poses; ++i, x = x * random_step<V>(rng, 1, 0.3)) problem.truth.insert(A(i), x);
  const int landmarks = 3;
  for (int l = 0; l < landmarks; ++l) problem.truth.insert(L(l), Point(random_vector<n>(rng, 6)));

  const auto pose = [&](int i) { return problem.truth.at<V>(A(i)); };
  const auto measured = [&](int a, int b) { return (pose(a).inverse() * pose(b)).retract(random_vector<V::dim>(rng, noise)); };
  Vector<V::dim> sigmas = Vector<V::dim>::Constant(0.1);
  problem.graph.add(Prior<V>::from_sigmas(pose(0), sigmas), {A(0)});
  for (int i = 1; i < poses; ++i) problem.graph.add(Between<V>::from_sigmas(measured(i - 1, i), sigmas), {A(i - 1), A(i)});
  for (int i = 0; i + 4 < poses; i += 2) problem.graph.add(Between<V>::from_sigmas(measured(i, i + 4), sigmas), {A(i), A(i + 4)}, loss);
  for (int i = 0; i < poses; ++i) {
    const Key landmark = L(i % landmarks);
    const Vector<n> offset = pose(i).to_body(problem.truth.at<Point>(landmark).position() - pose(i).p);
    if (i % 2 == 0)
      problem.graph.add(RelativePoint<V, Point>::from_sigmas(offset + random_vector<n>(rng, noise), Vector<n>::Constant(0.2)),
                        {A(i), landmark}, loss);
    problem.graph.add(Range<V, Point>{offset.norm() + random_vector<1>(rng, noise).cwiseAbs()[0], 0.2}, {A(i), landmark}, loss);
    problem.graph.add(VonMisesBearingBody<V, Point>{(offset.normalized() + random_vector<n>(rng, 0.1 * noise)).normalized(), 20},
                      {A(i), landmark}, loss);
  }
  problem.start = perturbed(problem.graph, problem.truth, start_sigma, rng);
  return problem;
}

/// Convex: points with priors, tied by range balls and steps (paper C). Some ranges are far too short.
template <class Point>
SmallProblem range_balls(std::uint64_t seed, int points, const Loss& loss) {
  constexpr int n = Point::space_dim;
  constexpr Agent P('P');
  std::mt19937_64 rng(seed);
  SmallProblem problem;
  for (int i = 0; i < points; ++i) problem.truth.insert(P(i), Point(random_vector<n>(rng, 5)));
  for (int i = 0; i < points; ++i) {
    problem.graph.add(
        Prior<Point>::from_sigmas(Point(problem.truth.at<Point>(P(i)).value + random_vector<n>(rng, 0.5)), Vector<n>::Constant(2)), {P(i)});
    if (i > 0) problem.graph.add(PositionStep<Point, Point>{3}, {P(i - 1), P(i)}, loss);
    for (int j = 0; j < i; ++j) {
      const double distance = (problem.truth.at<Point>(P(i)).value - problem.truth.at<Point>(P(j)).value).norm();
      problem.graph.add(RangeBall<Point, Point>{distance * (uniform(rng, 0, 1) < 0.2 ? 0.3 : 0.95), 0.5}, {P(i), P(j)}, loss);
    }
  }
  problem.start = perturbed(problem.graph, problem.truth, 3, rng);
  return problem;
}

/// Convex: a target that agents measure now and then (paper A), the last noise an outlier.
template <class V>
SmallProblem tracking(std::uint64_t seed, int steps, double noise, const Loss& loss) {
  constexpr int n = V::space_dim;
  using Square = Matrix<n, n>;
  constexpr Agent T('T');
  constexpr double dt = 0.5;
  std::mt19937_64 rng(seed);
  SmallProblem problem;
  V x{random_vector<V::dim>(rng)};
  for (int k = 0; k < steps; ++k) {
    problem.truth.insert(T(k), x);
    for (int axis = 0; axis < n; ++axis) x.value[2 * axis] += dt * x.value[2 * axis + 1];
  }
  const auto motion = WhiteAcceleration<V>::exact(dt, 1, 0.3 * Matrix<V::dim, V::dim>::Identity() + 0.1 * Matrix<V::dim, V::dim>::Ones());
  for (int k = 0; k < steps; ++k) {
    if (k > 0) problem.graph.add(motion, {T(k - 1), T(k)});
    const Vector<n> agent = random_vector<n>(rng, 3), error = random_vector<n>(rng, k % 5 == 4 ? 20 * noise : noise);
    if (k % 3 != 2)
      problem.graph.add(
          HuberMeasurement<V>::of_position(agent - problem.truth.at<V>(T(k)).position() + error, agent, Square(0.2 * Square::Identity())),
          {T(k)}, loss);
  }
  problem.start = perturbed(problem.graph, problem.truth, 2, rng);
  return problem;
}

}  // namespace holdfast::testing
