#include <algorithm>
#include <holdfast/solvers/backend.hpp>
#include <holdfast/solvers/linear/internal/selected_inverse.hpp>
#include <holdfast/solvers/marginals.hpp>
#include <optional>

namespace holdfast {

struct Marginals::Impl {
  struct Variable {
    int dim;
    int block;  // of H; −1: fixed
    std::type_index type;
    const char* type_name;
  };
  std::unordered_map<Key, Variable> variables;
  std::optional<SelectedInverse> inverse;  // none where every variable is fixed

  const Variable& at(Key key) const {
    const auto it = variables.find(key);
    if (it == variables.end())
      fail<BadKey>("key ", key, " has no covariance: no factor of the graph touches it; add its measurements, or ask for another one");
    return it->second;
  }
  bool is_free(const Variable& v) const { return v.block >= 0 && inverse->is_free(v.block); }
  void require_observable(const std::vector<Key>& keys) const;
  Eigen::MatrixXd block(const Variable& a, const Variable& b) const {
    return a.block < 0 || b.block < 0 ? Eigen::MatrixXd::Zero(a.dim, b.dim) : inverse->block(a.block, b.block);
  }
};

Marginals::Marginals(const Graph& graph, const Values& values) : impl_(std::make_unique<Impl>()) {
  if (graph.size() == 0) fail<BadProblem>("the graph has no factors, so no variable has a covariance; add measurements first");
  const Resolved resolved(graph, values);
  for (const Resolved::Variable& v : resolved.variables()) {
    const PoolBase& pool = values.pool(v.pool);
    impl_->variables.emplace(v.key, Impl::Variable{v.dim, -1, pool.type(), pool.type_name()});
  }
  if (resolved.tangent_dim() == 0) return;
  std::vector<int> variable;
  Symbolic symbolic = analyze(block_graph(graph, resolved, variable));
  std::vector<int> order;
  for (int node : symbolic.order) order.push_back(variable[node]);
  NormalEquations normal(graph, resolved, order);
  normal.linearize(graph, resolved, values, Curvature::irls);
  if (!std::all_of(normal.H().begin(), normal.H().end(), [](double x) { return std::isfinite(x); }))
    fail<BadNumber>("the Hessian is not finite at these values: ", resolved.first_non_finite(graph, values).text,
                    "; repair the value or the factor before asking for covariances");
  for (std::size_t b = 0; b < order.size(); ++b) impl_->variables.at(resolved.variables()[order[b]].key).block = static_cast<int>(b);
  impl_->inverse.emplace(std::move(symbolic), normal.pattern(), normal.H());
}

Marginals::Marginals(Marginals&&) noexcept = default;
Marginals& Marginals::operator=(Marginals&&) noexcept = default;
Marginals::~Marginals() = default;

void Marginals::Impl::require_observable(const std::vector<Key>& keys) const {
  std::vector<Key> missing;
  std::string names;
  for (Key key : keys) {
    if (!is_free(at(key)) || std::find(missing.begin(), missing.end(), key) != missing.end()) continue;
    names += (missing.empty() ? "" : ", ") + key.str();
    missing.push_back(key);
  }
  if (missing.empty()) return;
  throw UnobservableError(names + (missing.size() > 1 ? " have" : " has") +
                              " no covariance: the factors leave a direction free at these values (check(graph, values) names it); "
                              "add a prior or a measurement, or fix a variable",
                          missing);
}

std::vector<double> Marginals::covariance(Key key) const {
  const Impl::Variable& v = impl_->at(key);
  impl_->require_observable({key});
  const Eigen::MatrixXd C = impl_->block(v, v);
  return {C.data(), C.data() + C.size()};
}

std::vector<double> Marginals::joint(Key a, Key b) const {
  const Impl::Variable &va = impl_->at(a), &vb = impl_->at(b);
  impl_->require_observable({a, b});
  Eigen::MatrixXd C(va.dim + vb.dim, va.dim + vb.dim);
  C.topLeftCorner(va.dim, va.dim) = impl_->block(va, va);
  C.bottomRightCorner(vb.dim, vb.dim) = impl_->block(vb, vb);
  C.topRightCorner(va.dim, vb.dim) = impl_->block(va, vb);
  C.bottomLeftCorner(vb.dim, va.dim) = C.topRightCorner(va.dim, vb.dim).transpose();
  return {C.data(), C.data() + C.size()};
}

bool Marginals::is_observable(Key key) const { return !impl_->is_free(impl_->at(key)); }

std::vector<Key> Marginals::unobservable() const {
  std::vector<Key> keys;
  for (const auto& [key, variable] : impl_->variables)
    if (impl_->is_free(variable)) keys.push_back(key);
  std::sort(keys.begin(), keys.end());
  return keys;
}

void Marginals::check_type(Key key, std::type_index type, const char* type_name) const {
  const Impl::Variable& v = impl_->at(key);
  if (v.type != type)
    fail<BadType>("key ", key, " is a ", v.type_name, ", not a ", type_name, "; ask for the covariance of a ", v.type_name);
}

}  // namespace holdfast
