#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <Eigen/SparseCholesky>
#include <algorithm>
#include <holdfast/graph/detail/union_find.hpp>
#include <holdfast/graph/observability.hpp>

namespace holdfast {
namespace {

using Sparse = Eigen::SparseMatrix<double>;
using Eigen::MatrixXd;
using Eigen::VectorXd;

constexpr double kShift = 1e-15;      // on the unit diagonal of H: a pivot of exactly zero would stop Eigen
constexpr double kGaugeNull = 1e-11;  // a rigid motion this free gives its name to a free direction
constexpr std::size_t kMostListed = 20;

// H = Σ w JᵀJ scaled to a unit diagonal, and what it was scaled by.
struct Scaled {
  Sparse H;
  VectorXd scale;                     // 1/√H_ii; 0 where H_ii = 0
  std::vector<bool> has_idle_factor;  // by variable: some factor's Jacobian is zero here
};

struct Assembly {
  std::vector<Eigen::Triplet<double>> entries;
  std::vector<bool> idle;
};

void assemble_factor(const FactorBatch& batch, int i, const int* variable, const Resolved& resolved, const MatrixXd& J, Assembly& out) {
  int row = 0;
  for (int a = 0; a < batch.arity(); row += batch.dims()[a++]) {
    const Resolved::Variable& va = resolved.variables()[variable[a]];
    const auto Ja = J.middleCols(row, batch.dims()[a]);
    if (Ja.isZero(0)) out.idle[variable[a]] = true;
    if (va.offset < 0) continue;
    int column = 0;
    for (int b = 0; b < batch.arity(); column += batch.dims()[b++]) {
      const Resolved::Variable& vb = resolved.variables()[variable[b]];
      if (vb.offset < 0 || vb.offset > va.offset) continue;
      const MatrixXd block = batch.weight(i) * Ja.transpose() * J.middleCols(column, batch.dims()[b]);
      for (int r = 0; r < block.rows(); ++r)
        for (int c = 0; c < block.cols(); ++c) out.entries.emplace_back(va.offset + r, vb.offset + c, block(r, c));
    }
  }
}

Scaled scaled_hessian(const Graph& graph, const Resolved& resolved, const Values& values) {
  Assembly assembly;
  assembly.idle.assign(resolved.variables().size(), false);
  for (std::size_t b = 0; b < graph.batches().size(); ++b) {
    const FactorBatch& batch = *graph.batches()[b];
    VectorXd r(batch.residual_dim());
    MatrixXd J(batch.residual_dim(), batch.total_dim());
    for (int i = 0; i < batch.size(); ++i) {
      batch.evaluate(values, resolved.batches()[b].index.data(), i, i + 1, r.data(), J.data());
      if (J.allFinite())
        assemble_factor(batch, i, &resolved.batches()[b].variable[static_cast<std::size_t>(i) * batch.arity()], resolved, J, assembly);
    }
  }
  const int n = resolved.tangent_dim();
  Scaled scaled{Sparse(n, n), VectorXd::Zero(n), std::move(assembly.idle)};
  scaled.H.setFromTriplets(assembly.entries.begin(), assembly.entries.end());
  for (int i = 0; i < n; ++i) {
    const double d = scaled.H.coeff(i, i);
    scaled.scale[i] = d > 0 ? 1 / std::sqrt(d) : 0;
  }
  scaled.H = scaled.scale.asDiagonal() * scaled.H * scaled.scale.asDiagonal();
  return scaled;
}

std::vector<GraphComponent> find_components(const Graph& graph, const Resolved& resolved) {
  detail::UnionFind tied(static_cast<int>(resolved.variables().size()));
  for (std::size_t b = 0; b < graph.batches().size(); ++b) {
    const int arity = graph.batches()[b]->arity();
    const std::vector<int>& variable = resolved.batches()[b].variable;
    for (std::size_t f = 0; f < variable.size(); f += arity)
      for (int k = 1; k < arity; ++k) {
        for (int j = 0; j < k; ++j)  // a fixed variable ties nothing, but the others are tied
          if (resolved.variables()[variable[f + j]].offset >= 0 && resolved.variables()[variable[f + k]].offset >= 0)
            tied.unite(variable[f + j], variable[f + k]);
      }
  }
  std::vector<int> number(resolved.variables().size(), -1);
  std::vector<GraphComponent> components;
  for (std::size_t v = 0; v < number.size(); ++v) {
    if (resolved.variables()[v].offset < 0) continue;
    int& n = number[tied.root(static_cast<int>(v))];
    if (n < 0) {
      n = static_cast<int>(components.size());
      components.emplace_back();
    }
    components[n].variables.push_back(static_cast<int>(v));
  }
  return components;
}

/// Whether every variable is held, one after the other: a fixed one is, and so is one whose factors to variables that are held already have
/// Jacobians of full rank together, none weak beside all of its factors. Then J z = 0 has no other solution than z = 0, and nothing has to
/// be factored. That is so in most problems: poses along their odometry from the one that is fixed, landmarks from poses.
class HeldVariables {
 public:
  HeldVariables(const Graph& graph, const Resolved& resolved, const Values& values)
      : graph_(graph), resolved_(resolved), factors_of_(resolved.variables().size()) {
    for (const Resolved::Variable& v : resolved.variables()) {
      is_held_.push_back(v.offset < 0);
      begin_.push_back(information_.size());
      information_.resize(information_.size() + static_cast<std::size_t>(v.dim) * v.dim, 0.0);
    }
    diagonal_.assign(resolved.tangent_dim(), 0.0);
    for (std::size_t b = 0; b < graph.batches().size(); ++b) {
      const FactorBatch& batch = *graph.batches()[b];
      std::vector<double> r(static_cast<std::size_t>(batch.size()) * batch.residual_dim());
      J_.emplace_back(r.size() * batch.total_dim());
      batch.evaluate(values, resolved.batches()[b].index.data(), 0, batch.size(), r.data(), J_.back().data());
      for (int i = 0; i < batch.size(); ++i) add_factor(static_cast<int>(b), i);
    }
  }

  bool all() {
    while (!ready_.empty()) {
      const int factor = ready_.back();
      ready_.pop_back();
      use(factor);
    }
    return std::all_of(is_held_.begin(), is_held_.end(), [](char held) { return held != 0; });
  }

 private:
  static constexpr double kLeastPivot = 1e-9;  // of the diagonal of H: far above what is_unobservable() calls nothing

  struct Factor {
    int batch, index, open;  // variables that are not held
  };
  const int* variables_of(const Factor& f) const {
    return &resolved_.batches()[f.batch].variable[static_cast<std::size_t>(f.index) * graph_.batches()[f.batch]->arity()];
  }
  Eigen::Map<const MatrixXd> jacobian(const Factor& f) const {
    const FactorBatch& batch = *graph_.batches()[f.batch];
    const std::ptrdiff_t size = static_cast<std::ptrdiff_t>(batch.residual_dim()) * batch.total_dim();
    return {J_[f.batch].data() + size * f.index, batch.residual_dim(), batch.total_dim()};
  }
  void add_factor(int batch, int i) {
    const FactorBatch& factors = *graph_.batches()[batch];
    Factor factor{batch, i, 0};
    const Eigen::Map<const MatrixXd> J = jacobian(factor);
    if (!(factors.weight(i) > 0) || !J.allFinite()) return;
    const int number = static_cast<int>(factors_.size());
    const int* v = variables_of(factor);
    int column = 0;
    for (int k = 0; k < factors.arity(); column += factors.dims()[k++]) {
      if (is_held_[v[k]] != 0) continue;
      ++factor.open;
      factors_of_[v[k]].push_back(number);
      for (int c = 0; c < factors.dims()[k]; ++c)
        diagonal_[resolved_.variables()[v[k]].offset + c] += factors.weight(i) * J.col(column + c).squaredNorm();
    }
    factors_.push_back(factor);
    if (factor.open == 1) ready_.push_back(number);
  }
  void use(int number) {
    const Factor& factor = factors_[number];
    const FactorBatch& batch = *graph_.batches()[factor.batch];
    const int* v = variables_of(factor);
    int column = 0, k = 0;
    while (k < batch.arity() && is_held_[v[k]] != 0) column += batch.dims()[k++];
    if (k == batch.arity()) return;
    const int variable = v[k], dim = batch.dims()[k];
    const auto J = jacobian(factor).middleCols(column, dim);
    Eigen::Map<MatrixXd> S(&information_[begin_[variable]], dim, dim);
    S.noalias() += batch.weight(factor.index) * J.transpose() * J;
    if (!is_strong(S, Eigen::Map<const VectorXd>(&diagonal_[resolved_.variables()[variable].offset], dim))) return;
    is_held_[variable] = 1;
    for (const int other : factors_of_[variable])
      if (--factors_[other].open == 1) ready_.push_back(other);
  }
  /// S has no direction that is weak beside the diagonal of H.
  static bool is_strong(const Eigen::Map<MatrixXd>& S, const VectorXd& diagonal) {
    if (!(diagonal.minCoeff() > 0)) return false;
    const VectorXd scale = diagonal.cwiseSqrt().cwiseInverse();
    const Eigen::LLT<MatrixXd> llt(scale.asDiagonal() * S * scale.asDiagonal());
    return llt.info() == Eigen::Success && llt.matrixLLT().diagonal().cwiseAbs2().minCoeff() > kLeastPivot;
  }

  const Graph& graph_;
  const Resolved& resolved_;
  std::vector<char> is_held_;
  std::vector<double> information_;  // of each variable from those that are held: dim × dim
  std::vector<std::size_t> begin_;
  std::vector<Factor> factors_;
  std::vector<std::vector<int>> factors_of_;
  std::vector<int> ready_;              // factors with one variable that is not held
  std::vector<std::vector<double>> J_;  // of each batch
  std::vector<double> diagonal_;        // of H
};

// Null vectors of the scaled H, one for each small pivot of L D Lᵀ that vanishes: Lᵀ x = e_j gives H x = d_j L e_j and xᵀ H x = d_j.
std::vector<VectorXd> null_vectors(const Sparse& H, std::size_t most) {
  const auto n = H.rows();
  Sparse shifted = H;
  for (Eigen::Index i = 0; i < n; ++i) shifted.coeffRef(i, i) += kShift;
  const Eigen::SimplicialLDLT<Sparse, Eigen::Lower> ldlt(shifted);
  const VectorXd D = ldlt.vectorD();  // a copy each time it is called
  std::vector<VectorXd> null;
  for (Eigen::Index j = 0; j < n && null.size() < most; ++j) {
    if (!(D[j] <= detail::kSuspectPivot)) continue;
    VectorXd x = VectorXd::Unit(n, j);
    ldlt.matrixU().solveInPlace(x);
    if (!x.allFinite()) continue;
    const double norm2 = x.squaredNorm();  // the diagonal is 1
    if (!detail::is_unobservable(D[j] - kShift * norm2, norm2)) continue;
    null.push_back((ldlt.permutationPinv() * x).normalized());
  }
  return null;
}

// Unit rigid motions (scaled tangent) of a component about its own centre: translations, then rotations.
MatrixXd rigid_motions(const GraphComponent& component, const Resolved& resolved, const Values& values, const Scaled& scaled, int space) {
  VectorXd centre = VectorXd::Zero(space), p(space);
  int count = 0;
  for (int v : component.variables) {
    const Resolved::Variable& variable = resolved.variables()[v];
    if (values.pool(variable.pool).space() != space) continue;
    values.pool(variable.pool).position(variable.index, p.data());
    centre += p;
    ++count;
  }
  centre /= std::max(1, count);
  const int rotations = space == 2 ? 1 : 3;
  MatrixXd G = MatrixXd::Zero(resolved.tangent_dim(), space + rotations);
  for (int v : component.variables) {
    const Resolved::Variable& variable = resolved.variables()[v];
    if (values.pool(variable.pool).space() != space) continue;
    for (int g = 0; g < G.cols(); ++g) {
      VectorXd velocity = VectorXd::Zero(space), w = VectorXd::Zero(rotations), motion(variable.dim);
      if (g < space) {
        velocity[g] = 1;
      } else {  // v + w × p with v = −w × centre turns about the centre
        w[g - space] = 1;
        if (space == 2)
          velocity = -cross<double>(Vector<1>(w), Vector<2>(centre));
        else
          velocity = -cross<double>(Vector<3>(w), Vector<3>(centre));
      }
      values.pool(variable.pool).rigid_motion(variable.index, velocity.data(), w.data(), motion.data());
      for (int c = 0; c < variable.dim; ++c) {
        const double scale = scaled.scale[variable.offset + c];
        G(variable.offset + c, g) = scale > 0 ? motion[c] / scale : 0;
      }
    }
  }
  for (int g = 0; g < G.cols(); ++g)
    if (G.col(g).norm() > 0) G.col(g).normalize();
  return G;
}

/// The motion that has the greatest likeness among those not taken yet.
int most_alike(const VectorXd& likeness, const std::vector<bool>& taken) {
  int most = -1;
  for (int g = 0; g < likeness.size(); ++g)
    if (!taken[g] && (most < 0 || likeness[g] > likeness[most])) most = g;
  return most;
}

// Names the free rigid motions of a component; returns an orthonormal basis of them.
MatrixXd find_gauge(GraphComponent& component, const Resolved& resolved, const Values& values, const Scaled& scaled) {
  static const char* const names2[] = {"translation x", "translation y", "rotation"};
  static const char* const names3[] = {"translation x", "translation y", "translation z", "rotation x", "rotation y", "rotation z"};
  MatrixXd basis(resolved.tangent_dim(), 0);
  for (int space : {2, 3}) {
    const MatrixXd G = rigid_motions(component, resolved, values, scaled, space);
    if (G.isZero(0) || !G.allFinite()) continue;  // not finite: positions so far away that their squares overflow
    Eigen::ColPivHouseholderQR<MatrixXd> qr(G);
    qr.setThreshold(1e-9);  // fewer motions than columns: one point cannot turn about itself
    const MatrixXd Q = qr.householderQ() * MatrixXd::Identity(G.rows(), qr.rank());
    const MatrixXd quotient = Q.transpose() * (scaled.H.selfadjointView<Eigen::Lower>() * Q);
    const Eigen::SelfAdjointEigenSolver<MatrixXd> eigen(quotient);
    std::vector<bool> taken(G.cols(), false);
    for (int k = 0; k < Q.cols(); ++k) {
      if (!(eigen.eigenvalues()[k] <= kGaugeNull)) continue;
      const VectorXd free = Q * eigen.eigenvectors().col(k);
      const int named = most_alike((G.transpose() * free).cwiseAbs(), taken);
      taken[named] = true;
      const std::string name = space == 2 ? names2[named] : names3[named];
      if (std::find(component.gauge.begin(), component.gauge.end(), name) == component.gauge.end()) component.gauge.push_back(name);
      basis.conservativeResize(Eigen::NoChange, basis.cols() + 1);
      basis.rightCols(1) = free;
    }
  }
  return basis;
}

GraphComponent::Direction describe(const VectorXd& x, const GraphComponent& component, const Resolved& resolved, const Scaled& scaled) {
  GraphComponent::Direction direction{};
  double most = -1;
  for (int v : component.variables) {
    const Resolved::Variable& variable = resolved.variables()[v];
    Eigen::Index entry = 0;
    const double size = x.segment(variable.offset, variable.dim).cwiseAbs().maxCoeff(&entry);
    if (size > 1e-6) ++direction.others;
    if (size <= most) continue;
    most = size;
    direction.key = variable.key;
    direction.component = static_cast<int>(entry);
    direction.only_here = scaled.has_idle_factor[v];
  }
  --direction.others;
  return direction;
}

}  // namespace

std::vector<GraphComponent> observability(const Graph& graph, const Resolved& resolved, const Values& values) {
  std::vector<GraphComponent> components = find_components(graph, resolved);
  if (HeldVariables(graph, resolved, values).all()) return components;
  const Scaled scaled = scaled_hessian(graph, resolved, values);
  const std::vector<VectorXd> null = null_vectors(scaled.H, 10 * kMostListed);
  if (null.empty()) return components;
  std::vector<int> component_of(resolved.tangent_dim());
  for (std::size_t c = 0; c < components.size(); ++c)
    for (int v : components[c].variables)
      std::fill_n(component_of.begin() + resolved.variables()[v].offset, resolved.variables()[v].dim, static_cast<int>(c));
  std::vector<MatrixXd> known(components.size());
  std::vector<bool> seen(components.size(), false);
  for (VectorXd x : null) {
    Eigen::Index largest = 0;
    x.cwiseAbs().maxCoeff(&largest);
    const int c = component_of[largest];
    if (!seen[c]) known[c] = find_gauge(components[c], resolved, values, scaled);
    seen[c] = true;
    for (int twice = 0; twice < 2; ++twice) x -= known[c] * (known[c].transpose() * x);
    if (x.norm() < 1e-4) continue;  // one of the rigid motions, or a direction already listed
    x.normalize();
    known[c].conservativeResize(Eigen::NoChange, known[c].cols() + 1);
    known[c].rightCols(1) = x;
    if (components[c].directions.size() < kMostListed)
      components[c].directions.push_back(describe(x, components[c], resolved, scaled));
    else
      ++components[c].more_directions;
  }
  return components;
}

}  // namespace holdfast
