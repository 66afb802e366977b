#include <algorithm>
#include <holdfast/graph/batch.hpp>
#include <holdfast/graph/detail/gradient_kernel.hpp>
#include <holdfast/graph/internal/block_kernels.hpp>
#include <holdfast/graph/internal/scratch.hpp>

namespace holdfast {
namespace {

constexpr int kStack = 1280;  // doubles: sixteen residuals and Jacobians of 6 × 12

/// Calls visit(i, end, memory) for a few factors at a time; memory: `doubles` for each of them, on the stack where one fits.
template <class Owner, class Visit>
void in_chunks(int first, int last, int doubles, const Visit& visit) {
  double local[kStack];
  double* const memory = doubles > kStack ? scratch<Owner>(doubles) : local;
  const int step = std::max(1, kStack / doubles);
  for (int i = first; i < last; i += step) visit(i, std::min(last, i + step), memory);
}

}  // namespace

FactorBatch::FactorBatch(std::string name, std::type_index factor_type, Loss loss)
    : name_(std::move(name)), factor_type_(factor_type), losses_{std::move(loss)} {}

void FactorBatch::set_sizes(int residual_dim) {
  residual_dim_ = residual_dim;
  total_dim_ = 0;
  stride_ = 1;  // the cost
  for (std::size_t b = 0; b < dims_.size(); ++b) {
    total_dim_ += dims_[b];
    stride_ += dims_[b];
    for (std::size_t a = b; a < dims_.size(); ++a) stride_ += dims_[a] * dims_[b];
  }
  kernels_ = &block_kernels(residual_dim_, dims_);
}

std::string FactorBatch::describe(int i) const {
  std::string text = name_ + "(";
  for (int k = 0; k < arity(); ++k) text += (k ? ", " : "") + keys(i)[k].str();
  return text + ")";
}

void FactorBatch::push_entries(const Key* keys, double weight, const Loss& loss, int id) {
  keys_.insert(keys_.end(), keys, keys + arity());
  weights_.push_back(weight);
  ids_.push_back(id);
  if (size() == 1)
    losses_.assign(1, loss);
  else if (!has_one_loss())
    losses_.push_back(loss);
  else
    set_loss_of(size() - 1, loss);
}

void FactorBatch::erase_entries(int i) {
  const std::ptrdiff_t n = arity();
  std::copy(keys_.end() - n, keys_.end(), keys_.begin() + i * n);
  keys_.resize(keys_.size() - n);
  weights_[i] = weights_.back();
  weights_.pop_back();
  if (!has_one_loss()) {
    losses_[i] = losses_.back();
    losses_.pop_back();
  }
  ids_[i] = ids_.back();
  ids_.pop_back();
}

void FactorBatch::set_loss_of(int i, const Loss& loss) {
  if (has_one_loss()) {
    if (losses_.front() == loss) return;
    losses_.resize(size(), Loss(losses_.front()));
  }
  losses_[i] = loss;
}

void FactorBatch::take_place_of(const FactorBatch& other) {
  keys_ = other.keys_;
  weights_ = other.weights_;
  losses_ = other.losses_;
  ids_ = other.ids_;
}

void FactorBatch::hessians(const Values&, const int*, int, int, double*) const {
  fail<BadType>("factors of type ", name_, " say no hessian(); ask has_hessian() first");
}

void FactorBatch::contributions(const Values& values, const int* index, int first, int last, Curvature curvature, double* out) const {
  const int M = residual_dim_, N = total_dim_;
  const bool exact = takes_hessians(curvature);
  in_chunks<struct Contributions>(first, last, M + M * N + (exact ? N * N : 0), [&](int i, int end, double* r) {
    double* const J = r + static_cast<std::ptrdiff_t>(end - i) * M;
    double* const H = J + static_cast<std::ptrdiff_t>(end - i) * M * N;
    evaluate(values, index, i, end, r, J);
    if (exact) {
      hessians(values, index, i, end, H);
      contributions_from(r, J, H, i, end, curvature, out);
    } else {
      contributions_at(r, J, i, end, curvature, out);
    }
    out += static_cast<std::ptrdiff_t>(end - i) * stride_;
  });
}

void FactorBatch::contributions_at(const double* r, const double* J, int first, int last, Curvature curvature, double* out) const {
  if (JtJ_.empty())
    kernels_->contributions(*this, r, J, first, last, curvature, out);
  else
    contributions_from(r, J, JtJ_.data(), first, last, curvature, out);
}

// With g = Jᵀr of a residual of one component or under a loss of the whole block: w (ρ' H + 2ρ'' g gᵀ), cut off as in row_weights().
void FactorBatch::contributions_from(const double* r, const double* J, const double* matrices, int first, int last, Curvature curvature,
                                     double* out) const {
  const int M = residual_dim_, N = total_dim_;
  for (int i = first; i < last; ++i, r += M, J += static_cast<std::ptrdiff_t>(M) * N, matrices += static_cast<std::ptrdiff_t>(N) * N) {
    double s = 0;
    for (int m = 0; m < M; ++m) s += r[m] * r[m];
    const Rho rho = M == 1 ? loss(i).rho_of_component(*r) : loss(i).rho(s, M);
    const double first_derivative = curvature == Curvature::bound ? loss(i).rho(0, M).first : rho.first;
    const bool bends = (curvature == Curvature::newton || curvature == Curvature::exact) && s > 0 && rho.second != 0;
    const double rank_one = bends ? weight(i) * std::max(2 * rho.second, -(1 - kLeastCurvature) * rho.first / s) : 0;
    double* const v = out + stride_ - N - 1;  // Jᵀ r, where the gradient will be
    if (bends) kernels_->multiply_transposed(*this, J, r, v);
    write_blocks(dims_, matrices, weight(i) * first_derivative, rank_one, v, out);
    kernels_->gradients(*this, r, J, i, i + 1, stride_, v);
    out += stride_;
  }
}

void FactorBatch::apply_jacobians(const double* J, const int* offsets, int first, int last, const double* delta, double* out) const {
  const int n = total_dim_;
  constexpr int kSmall = 64;
  double local[kSmall];
  double* const own = n > kSmall ? scratch<struct OwnPart>(n) : local;
  offsets += static_cast<std::ptrdiff_t>(first) * arity();
  for (int i = first; i < last; ++i, J += static_cast<std::ptrdiff_t>(residual_dim_) * n, out += residual_dim_) {
    double* d = own;
    for (const int dim : dims_) {
      const int offset = *offsets++;
      if (offset >= 0)
        std::copy_n(delta + offset, dim, d);
      else
        std::fill_n(d, dim, 0.0);
      d += dim;
    }
    kernels_->multiply(*this, J, own, out);
  }
}

void FactorBatch::curvatures(const Values& values, const Values& moved, double h, const double* delta, const int* index, const int* offsets,
                             int first, int last, double* out) const {
  const int M = residual_dim_, N = total_dim_;
  if (!JtJ_.empty()) {  // its Jacobian is constant
    std::fill_n(out, static_cast<std::ptrdiff_t>(last - first) * (N + 1), 0.0);
    return;
  }
  in_chunks<struct Curvatures>(first, last, 4 * M + M * N, [&](int begin, int end, double* r) {
    const std::ptrdiff_t rows = static_cast<std::ptrdiff_t>(end - begin) * M;
    double *const r_moved = r + rows, *const Jd = r_moved + rows, *const weights = Jd + rows, *const J = weights + rows;
    evaluate(values, index, begin, end, r, J);
    evaluate(moved, index, begin, end, r_moved, nullptr);
    apply_jacobians(J, offsets, begin, end, delta, Jd);
    for (int i = begin; i < end; ++i)
      cost_of(i, r + static_cast<std::ptrdiff_t>(i - begin) * M, weights + static_cast<std::ptrdiff_t>(i - begin) * M);
    for (std::ptrdiff_t k = 0; k < rows; ++k) weights[k] = weights[k] * 2 / h * ((r_moved[k] - r[k]) / h - Jd[k]);
    for (int i = 0; i < end - begin; ++i, out += N + 1) {
      kernels_->multiply_transposed(*this, J + static_cast<std::ptrdiff_t>(i) * M * N, weights + static_cast<std::ptrdiff_t>(i) * M, out);
      out[N] = 0;
    }
  });
}

void FactorBatch::gradients(const Values& values, const int* index, int first, int last, double* out) const {
  const int M = residual_dim_, N = total_dim_;
  const bool one_block = M == 1 ? !family().one_sided : !family().per_component;
  if (const GradientKernel kernel = one_block ? gradient_kernel(factor_type_) : nullptr) {
    kernel(*this, values, index, first, last, out);
    const bool squared = family().kind == Loss::Kind::Squared;
    for (int i = first; i < last; ++i, out += N + 1) {
      const Rho rho = squared ? Rho{out[N], 1, 0} : loss(i).rho(out[N], M);
      for (int c = 0; c < N; ++c) out[c] *= weights_[i] * rho.first;
      out[N] = 0.5 * weights_[i] * rho.value;
    }
    return;
  }
  in_chunks<struct Gradients>(first, last, M + M * N, [&](int i, int end, double* r) {
    double* const J = r + static_cast<std::ptrdiff_t>(end - i) * M;
    evaluate(values, index, i, end, r, J);
    kernels_->gradients(*this, r, J, i, end, N + 1, out);
    out += static_cast<std::ptrdiff_t>(end - i) * (N + 1);
  });
}

double FactorBatch::cost_of(int i, const double* r, double* weights) const {
  const int m = residual_dim_;
  const Loss& loss = this->loss(i);
  double sum = 0;
  if (loss.per_component || m == 1) {
    for (int c = 0; c < m; ++c) {
      const Rho rho = loss.rho_of_component(r[c]);
      sum += rho.value;
      if (weights != nullptr) weights[c] = weights_[i] * rho.first;
    }
  } else {
    double s = 0;
    for (int c = 0; c < m; ++c) s += r[c] * r[c];
    const Rho rho = loss.rho(s, m);
    sum = rho.value;
    if (weights != nullptr) std::fill(weights, weights + m, weights_[i] * rho.first);
  }
  return 0.5 * weights_[i] * sum;
}

double FactorBatch::cost(const Values& values, const int* index, int first, int last) const {
  double sum = 0;
  in_chunks<struct Cost>(first, last, residual_dim_, [&](int i, int end, double* r) {
    evaluate(values, index, i, end, r, nullptr);
    for (int k = i; k < end; ++k) sum += cost_of(k, r + static_cast<std::ptrdiff_t>(k - i) * residual_dim_, nullptr);
  });
  return sum;
}

}  // namespace holdfast
