#include <algorithm>
#include <cmath>
#include <holdfast/graph/internal/scratch.hpp>
#include <holdfast/graph/linear_prior.hpp>

namespace holdfast {
namespace {

/// The ambient coordinates of the variables.
const double* const* gather(const Values& values, const std::vector<const PoolBase*>& types, const int* index) {
  static thread_local std::vector<const double*> x;
  x.clear();
  for (std::size_t k = 0; k < types.size(); ++k)
    for (const auto& pool : values.pools())
      if (pool->type() == types[k]->type()) x.push_back(std::as_const(*pool).data(index[k]));
  return x.data();
}

/// C += Aᵀ B of column-major blocks: A is m × rows, B is m × cols.
void add_product(const double* A, const double* B, int m, int rows, int cols, double* C) {
  for (int c = 0; c < cols; ++c)
    for (int r = 0; r < rows; ++r) {
      double sum = 0;
      for (int k = 0; k < m; ++k) sum += A[r * m + k] * B[c * m + k];
      C[c * rows + r] += sum;
    }
}

}  // namespace

void LinearPrior::add_variable(Key key, const PoolBase& type, const double* at) {
  keys.push_back(key);
  types.push_back(&type);
  x0.insert(x0.end(), at, at + type.ambient());
}

void LinearPrior::clear() {
  keys.clear();
  types.clear();
  x0.clear();
  A.clear();
  b.clear();
  rows = 0;
  constant = 0;
}

int LinearPrior::columns() const {
  int sum = 0;
  for (const PoolBase* type : types) sum += type->dim();
  return sum;
}

void LinearPrior::validate() const {
  std::size_t ambient = 0;
  for (const PoolBase* type : types) ambient += type->ambient();
  if (keys.empty() || keys.size() != types.size() || x0.size() != ambient)
    fail<BadNumber>("LinearPrior: ", keys.size(), " keys, ", types.size(), " types and ", x0.size(),
                    " coordinates do not fit; enter each variable by add_variable()");
  if (rows < 1 || A.size() != static_cast<std::size_t>(rows) * columns() || b.size() != static_cast<std::size_t>(rows))
    fail<BadNumber>("LinearPrior: rows = ", rows, " > 0, A of ", A.size(), " = rows × ", columns(), " and b of ", b.size(),
                    " = rows must fit");
  for (const std::vector<double>* numbers : {&x0, &A, &b})
    if (!std::all_of(numbers->begin(), numbers->end(), [](double x) { return std::isfinite(x); }))
      fail<BadNumber>("LinearPrior: a number of ",
                      numbers == &x0  ? "x0"
                      : numbers == &A ? "A"
                                      : "b",
                      " is not finite; leave the prior out");
}

LinearPriorBatch::LinearPriorBatch() : FactorBatch("LinearPrior", typeid(LinearPrior), Squared{}) {}

void LinearPriorBatch::hold(const LinearPrior& prior) {
  prior_ = prior;
  types_.clear();
  type_names_.clear();
  dims_.clear();
  bool linear = true;
  for (const PoolBase* type : prior.types) {
    types_.push_back(type->type());
    type_names_.push_back(type->type_name());
    dims_.push_back(type->dim());
    linear = linear && type->is_vector_space();
  }
  set_sizes(prior_.rows);
  is_linear_ = is_convex_ = linear;
  const int n = total_dim();
  JtJ_.assign(linear ? static_cast<std::size_t>(n) * n : 0, 0.0);
  if (linear) add_product(prior_.A.data(), prior_.A.data(), prior_.rows, n, n, JtJ_.data());
}

// δ_k = x0_k.local(x_k).
void LinearPriorBatch::local(const double* const* x, double* delta) const {
  const double* at = prior_.x0.data();
  for (int k = 0; k < arity(); ++k) {
    prior_.types[k]->local_ambient(at, x[k], delta);
    at += prior_.types[k]->ambient();
    delta += dims()[k];
  }
}

// r = b + A δ.
void LinearPriorBatch::residual(const double* delta, double* r) const {
  const int m = prior_.rows;
  std::copy(prior_.b.begin(), prior_.b.end(), r);
  for (int c = 0; c < total_dim(); ++c)
    for (int k = 0; k < m; ++k) r[k] += prior_.A[static_cast<std::size_t>(c) * m + k] * delta[c];
}

// J_k = A_k ∂δ_k/∂x_k.
void LinearPriorBatch::times_local_jacobians(const double* const* x, double* J) const {
  const int m = prior_.rows;
  std::copy(prior_.A.begin(), prior_.A.end(), J);
  const double* at = prior_.x0.data();
  const double* A = prior_.A.data();
  for (int k = 0; k < arity(); ++k) {
    const PoolBase& type = *prior_.types[k];
    const int d = dims()[k];
    if (!type.is_vector_space()) {
      double* D = scratch<struct LocalJacobian>(static_cast<std::size_t>(d) * d);
      type.local_jacobian_ambient(at, x[k], D);
      Eigen::Map<Eigen::MatrixXd>(J, m, d).noalias() =
          Eigen::Map<const Eigen::MatrixXd>(A, m, d) * Eigen::Map<const Eigen::MatrixXd>(D, d, d);
    }
    at += type.ambient();
    A += static_cast<std::ptrdiff_t>(m) * d;
    J += static_cast<std::ptrdiff_t>(m) * d;
  }
}

void LinearPriorBatch::evaluate(const Values& values, const int* index, int first, int last, double* r, double* J) const {
  if (first < last) evaluate_at(0, gather(values, prior_.types, index), r, J);
}

void LinearPriorBatch::evaluate_at(int, const double* const* x, double* r, double* J) const {
  double* delta = scratch<struct Delta>(total_dim());
  local(x, delta);
  residual(delta, r);
  if (J != nullptr) times_local_jacobians(x, J);
}

}  // namespace holdfast
