#include <algorithm>
#include <cmath>
#include <holdfast/graph/linear_prior.hpp>

namespace holdfast {
namespace {

/// Memory of this thread, kept: solving allocates nothing.
template <int Purpose>
double* scratch(std::size_t size) {
  static thread_local std::vector<double> memory;
  if (memory.size() < size) memory.resize(size);
  return memory.data();
}

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

LinearPriorBatch::LinearPriorBatch() : FactorBatch("LinearPrior", Squared{}) {}

void LinearPriorBatch::hold(const LinearPrior& prior) {
  prior_ = prior;
  size_ = 1;
  types_.clear();
  type_names_.clear();
  dims_.clear();
  is_linear_ = true;
  for (const PoolBase* type : prior.types) {
    types_.push_back(type->type());
    type_names_.push_back(type->type_name());
    dims_.push_back(type->dim());
    is_linear_ = is_linear_ && type->is_vector_space();
  }
  total_dim_ = prior_.columns();
  stride_ = total_dim_ * (total_dim_ + 1) / 2 + total_dim_ + 1;  // with the whole diagonal blocks:
  for (int d : dims_) stride_ += d * (d - 1) / 2;
  const int n = total_dim_;
  H_.assign(is_linear_ ? static_cast<std::size_t>(n) * n : 0, 0.0);
  if (is_linear_) add_product(prior_.A.data(), prior_.A.data(), prior_.rows, n, n, H_.data());
}

// δ_k = x0_k.local(x_k).
void LinearPriorBatch::local(const double* const* x, double* delta) const {
  const double* at = prior_.x0.data();
  for (int k = 0; k < arity(); ++k) {
    prior_.types[k]->local_ambient(at, x[k], delta);
    at += prior_.types[k]->ambient();
    delta += dims_[k];
  }
}

// r = b + A δ.
void LinearPriorBatch::residual(const double* delta, double* r) const {
  const int m = prior_.rows;
  std::copy(prior_.b.begin(), prior_.b.end(), r);
  for (int c = 0; c < total_dim_; ++c)
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
    const int d = dims_[k];
    if (!type.is_vector_space()) {
      double* D = scratch<0>(static_cast<std::size_t>(d) * d);
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
  double* delta = scratch<1>(total_dim_);
  local(x, delta);
  residual(delta, r);
  if (J != nullptr) times_local_jacobians(x, J);
}

double* LinearPriorBatch::gradient_and_cost(const double* r, const double* J, double* out) const {
  const int m = prior_.rows;
  std::fill(out, out + total_dim_, 0.0);
  add_product(J, r, m, total_dim_, 1, out);
  for (int c = 0; c < total_dim_; ++c) out[c] *= weights_[0];
  double s = 0;
  for (int k = 0; k < m; ++k) s += r[k] * r[k];
  out[total_dim_] = 0.5 * weights_[0] * s;
  return out + total_dim_ + 1;
}

void LinearPriorBatch::contributions(const Values& values, const int* index, int first, int last, Curvature curvature, double* out) const {
  if (first >= last) return;
  const int m = prior_.rows;
  double* r = scratch<2>(m);
  if (is_linear_) {
    evaluate(values, index, first, last, r, nullptr);
    return contributions_at(r, prior_.A.data(), first, last, curvature, out);
  }
  double* J = scratch<3>(static_cast<std::size_t>(m) * total_dim_);
  evaluate(values, index, first, last, r, J);
  contributions_at(r, J, first, last, curvature, out);
}

// Squared: all three curvatures are w JᵀJ, and where J is A, AᵀA is known.
void LinearPriorBatch::contributions_at(const double* r, const double* J, int first, int last, Curvature, double* out) const {
  if (first >= last) return;
  const int m = prior_.rows, n = total_dim_;
  const double w = weights_[0];
  int column = 0;
  for (int b = 0; b < arity(); column += dims_[b++]) {
    int row = column;
    for (int a = b; a < arity(); row += dims_[a++]) {
      const int rows = dims_[a], cols = dims_[b];
      std::fill(out, out + rows * cols, 0.0);
      if (is_linear_)
        for (int c = 0; c < cols; ++c) std::copy_n(&H_[static_cast<std::size_t>(column + c) * n + row], rows, out + c * rows);
      else
        add_product(J + static_cast<std::ptrdiff_t>(row) * m, J + static_cast<std::ptrdiff_t>(column) * m, m, rows, cols, out);
      if (w != 1)
        for (int k = 0; k < rows * cols; ++k) out[k] *= w;
      out += rows * cols;
    }
  }
  gradient_and_cost(r, J, out);
}

void LinearPriorBatch::apply_jacobians(const double* J, const int* offsets, int first, int last, const double* delta, double* out) const {
  if (first >= last) return;
  const int m = prior_.rows;
  std::fill(out, out + m, 0.0);
  for (int k = 0; k < arity(); ++k)
    for (int c = 0; c < dims_[k]; ++c, J += m)
      if (offsets[k] >= 0)
        for (int row = 0; row < m; ++row) out[row] += J[row] * delta[offsets[k] + c];
}

void LinearPriorBatch::curvatures(const Values& values, const Values& moved, double h, const double* delta, const int* index,
                                  const int* offsets, int first, int last, double* out) const {
  if (first >= last) return;
  const int m = prior_.rows;
  std::fill(out, out + total_dim_ + 1, 0.0);
  if (is_linear_) return;
  double* r = scratch<2>(m);
  double* J = scratch<3>(static_cast<std::size_t>(m) * total_dim_);
  double* r_moved = scratch<4>(m);
  double* Jd = scratch<5>(m);
  evaluate(moved, index, first, last, r_moved, nullptr);
  evaluate(values, index, first, last, r, J);
  apply_jacobians(J, offsets, first, last, delta, Jd);
  for (int k = 0; k < m; ++k) r[k] = weights_[0] * 2 / h * ((r_moved[k] - r[k]) / h - Jd[k]);
  add_product(J, r, m, total_dim_, 1, out);
}

void LinearPriorBatch::gradients(const Values& values, const int* index, int first, int last, double* out) const {
  if (first >= last) return;
  double* r = scratch<2>(prior_.rows);
  double* J = scratch<3>(static_cast<std::size_t>(prior_.rows) * total_dim_);
  evaluate(values, index, first, last, r, J);
  gradient_and_cost(r, J, out);
}

}  // namespace holdfast
