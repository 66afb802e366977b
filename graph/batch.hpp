// A batch: the factors of one type and one loss, side by side. One virtual call works on a range of factors; inside, all sizes
// are fixed and nothing is allocated. Solvers, reports and adapters see factors through this interface only.
#pragma once

#include <algorithm>
#include <cstring>
#include <holdfast/graph/detail/normal_blocks.hpp>
#include <holdfast/graph/values.hpp>
#include <memory>
#include <typeindex>
#include <vector>

namespace holdfast {

class FactorBatch {
 public:
  FactorBatch(std::string name, Loss loss) : name_(std::move(name)), loss_(loss) {}
  virtual ~FactorBatch() = default;

  const std::string& name() const { return name_; }
  const Loss& loss() const { return loss_; }
  virtual std::type_index factor_type() const = 0;
  virtual int size() const = 0;
  virtual int residual_dim() const = 0;
  virtual bool is_linear() const = 0;
  virtual bool is_convex() const = 0;
  /// The variables of every factor of this batch.
  const std::vector<std::type_index>& types() const { return types_; }
  const std::vector<const char*>& type_names() const { return type_names_; }
  const std::vector<int>& dims() const { return dims_; }
  int arity() const { return static_cast<int>(dims_.size()); }
  int total_dim() const { return total_dim_; }
  const Key* keys(int i) const { return keys_.data() + static_cast<std::size_t>(i) * dims_.size(); }
  double weight(int i) const { return weights_[i]; }
  const double* weights() const { return weights_.data(); }
  std::string describe(int i) const;  ///< "RangeBall(A11, L0)"

  /// r of factors [first, last), residual_dim doubles each, and their Jacobians (residual_dim × total_dim, column-major) unless J
  /// is null. index: the pool index of each variable of each factor of the batch (Resolved::Batch).
  virtual void evaluate(const Values& values, const int* index, int first, int last, double* r, double* J) const = 0;

  /// The same for factor i at variables given by their ambient coordinates (foreign solvers own their memory).
  virtual void evaluate_at(int i, const double* const* ambient, double* r, double* J) const = 0;

  /// Each factor's part of the normal equations: the blocks (a, b), a ≥ b, of its H, column by column of blocks, each
  /// column-major dims[a] × dims[b]; then its gradient; then its cost: stride() doubles a factor.
  virtual void contributions(const Values& values, const int* index, int first, int last, Curvature curvature, double* out) const = 0;
  int stride() const { return stride_; }
  /// The same where r and J of factors [first, last) are known already, as evaluate() writes them.
  virtual void contributions_at(const double* r, const double* J, int first, int last, Curvature curvature, double* out) const = 0;
  /// J δ of factors [first, last); offsets: where in δ each variable of each factor of the batch begins, −1: a fixed one.
  virtual void apply_jacobians(const double* J, const int* offsets, int first, int last, const double* delta, double* out) const = 0;

  /// Each factor's part of Jᵀ W r̈ (total_dim doubles, then a 0): r̈, the second derivative of the residual along δ, by finite difference
  /// from `moved` = values ⊕ hδ; W = w ρ' at the values. offsets as for apply_jacobians.
  virtual void curvatures(const Values& values, const Values& moved, double h, const double* delta, const int* index, const int* offsets,
                          int first, int last, double* out) const = 0;

  /// Each factor's part of the gradient (total_dim doubles), then its cost.
  virtual void gradients(const Values& values, const int* index, int first, int last, double* out) const = 0;

  /// Σ w ½ρ over factors [first, last).
  double cost(const Values& values, const int* index, int first, int last) const;
  /// w ½ρ of one factor from its residual; weights (unless null): w ρ' of each component.
  double cost_of(int i, const double* r, double* weights) const;

  virtual std::unique_ptr<FactorBatch> clone() const = 0;
  /// Its factors' convex counterparts (factor.hpp, relaxed()) under the same keys, weights and loss; null where they have none.
  virtual std::unique_ptr<FactorBatch> relaxed() const { return nullptr; }
  /// Its factors say relative_pose() (factor.hpp).
  virtual bool measures_relative_poses() const { return false; }
  /// What factor i measures, a variable of types()[0], and its information, dim × dim.
  virtual void relative_pose(int i, void* measured, double* information) const { (void)i, (void)measured, (void)information; }
  virtual void remove(int i) = 0;  ///< the last one takes its place

 protected:
  friend class Graph;
  void set_variables(std::vector<std::type_index> types, std::vector<const char*> names, std::vector<int> dims);
  /// Takes the place of another batch on the same variables.
  void take_place_of(const FactorBatch& other) { keys_ = other.keys_, weights_ = other.weights_, ids_ = other.ids_; }

  std::string name_;
  Loss loss_;
  std::vector<std::type_index> types_;
  std::vector<const char*> type_names_;
  std::vector<int> dims_;
  int total_dim_ = 0;
  int stride_ = 0;
  std::vector<Key> keys_;
  std::vector<double> weights_;
  std::vector<int> ids_;  ///< Graph's number of each factor
};

template <class F>
class Batch final : public FactorBatch {
 public:
  using Vars = typename F::Variables;
  static constexpr int M = F::residual_dim;
  static constexpr int N = Vars::total_dim;
  static constexpr int K = Vars::size;

  explicit Batch(Loss loss) : FactorBatch(factor_name<F>(), loss) { describe_variables(std::make_index_sequence<K>{}); }

  std::type_index factor_type() const override { return typeid(F); }
  int size() const override { return static_cast<int>(factors_.size()); }
  int residual_dim() const override { return M; }
  bool is_linear() const override { return holdfast::is_linear<F>; }
  bool is_convex() const override { return holdfast::is_convex<F>; }
  const std::vector<F>& factors() const { return factors_; }
  std::vector<F>& factors() { return factors_; }

  void evaluate(const Values& values, const int* index, int first, int last, double* r, double* J) const override {
    const auto pools = pools_of(values, std::make_index_sequence<K>{});
    Jacobians<F> jacobians;
    for (int i = first; i < last; ++i, r += M) {
      Eigen::Map<Vector<M>>(r, M) = call(i, pools, index, J == nullptr ? nullptr : &jacobians, std::make_index_sequence<K>{});
      if (J == nullptr) continue;
      store(jacobians, J);
      J += M * N;
    }
  }

  void evaluate_at(int i, const double* const* ambient, double* r, double* J) const override {
    Jacobians<F> jacobians;
    Eigen::Map<Vector<M>>(r, M) = call_at(i, ambient, J == nullptr ? nullptr : &jacobians, std::make_index_sequence<K>{});
    if (J != nullptr) store(jacobians, J);
  }

  void contributions(const Values& values, const int* index, int first, int last, Curvature curvature, double* out) const override {
    const auto pools = pools_of(values, std::make_index_sequence<K>{});
    Jacobians<F> J;
    for (int i = first; i < last; ++i) {
      const Vector<M> r = call(i, pools, index, &J, std::make_index_sequence<K>{});
      out = contribution(i, r.data(), J.all.data(), curvature, out);
    }
  }

  void contributions_at(const double* r, const double* J, int first, int last, Curvature curvature, double* out) const override {
    for (int i = first; i < last; ++i, r += M, J += M * N) out = contribution(i, r, J, curvature, out);
  }

  void apply_jacobians(const double* J, const int* offsets, int first, int last, const double* delta, double* out) const override {
    for (int i = first; i < last; ++i, J += M * N, out += M) {
      double d[N] = {};
      for (int k = 0; k < K; ++k) {
        const int offset = offsets[static_cast<std::ptrdiff_t>(i) * K + k];
        if (offset >= 0) std::copy_n(delta + offset, Vars::dims[k], d + Vars::offsets[k]);
      }
      std::fill(out, out + M, 0.0);
      for (int n = 0; n < N; ++n)
        for (int m = 0; m < M; ++m) out[m] += J[n * M + m] * d[n];
    }
  }

  void curvatures(const Values& values, const Values& moved, double h, const double* delta, const int* index, const int* offsets, int first,
                  int last, double* out) const override {
    const auto here = pools_of(values, std::make_index_sequence<K>{}), there = pools_of(moved, std::make_index_sequence<K>{});
    Jacobians<F> J;
    for (int i = first; i < last; ++i, out += N + 1) {
      const Vector<M> r = call(i, here, index, &J, std::make_index_sequence<K>{});
      const Vector<M> r_moved = call(i, there, index, nullptr, std::make_index_sequence<K>{});
      const RowWeights<M> w = row_weights<M>(loss_, weights_[i], r, Curvature::irls);
      double Jd[M];
      apply_jacobians(J.all.data(), offsets + static_cast<std::ptrdiff_t>(i) * K, 0, 1, delta, Jd);
      Vector<M> weighted;
      for (int m = 0; m < M; ++m) weighted[m] = w.gradient[m] * 2 / h * ((r_moved[m] - r[m]) / h - Jd[m]);
      for (int n = 0; n < N; ++n) out[n] = J.all.col(n).dot(weighted);
      out[N] = 0;
    }
  }

  void gradients(const Values& values, const int* index, int first, int last, double* out) const override {
    const auto pools = pools_of(values, std::make_index_sequence<K>{});
    Jacobians<F> J;
    for (int i = first; i < last; ++i, out += N + 1) {
      const Vector<M> r = call(i, pools, index, &J, std::make_index_sequence<K>{});
      const RowWeights<M> w = row_weights<M>(loss_, weights_[i], r, Curvature::irls);
      for (int n = 0; n < N; ++n) out[n] = J.all.col(n).dot(w.gradient.cwiseProduct(r));
      out[N] = w.cost;
    }
  }

  std::unique_ptr<FactorBatch> clone() const override { return std::make_unique<Batch>(*this); }
  std::unique_ptr<FactorBatch> relaxed() const override {
    if constexpr (detail::HasRelaxed<F>::value) {
      auto convex = std::make_unique<Batch<decltype(std::declval<const F&>().relaxed())>>(loss_);
      for (const F& factor : factors_) convex->factors_.push_back(factor.relaxed());
      convex->take_place_of(*this);
      return convex;
    } else {
      return nullptr;
    }
  }
  bool measures_relative_poses() const override { return detail::HasRelativePose<F>::value; }
  void relative_pose(int i, void* measured, double* information) const override {
    if constexpr (detail::HasRelativePose<F>::value) {
      using Pose = std::decay_t<decltype(factors_[i].relative_pose())>;
      *static_cast<Pose*>(measured) = factors_[i].relative_pose();
      const auto& W = factors_[i].sqrt_information;
      Eigen::Map<Matrix<Pose::dim, Pose::dim>>{information} = W.transpose() * W;
    } else {
      FactorBatch::relative_pose(i, measured, information);
    }
  }
  void remove(int i) override {
    factors_[i] = factors_.back();
    factors_.pop_back();
  }

 private:
  friend class Graph;
  template <class>
  friend class Batch;

  template <std::size_t... I>
  void describe_variables(std::index_sequence<I...>) {
    set_variables({std::type_index(typeid(typename Vars::template type<I>))...}, {Vars::template type<I>::name()...}, {Vars::dims[I]...});
  }
  template <std::size_t... I>
  auto pools_of(const Values& values, std::index_sequence<I...>) const {
    return std::tuple<const typename Vars::template type<I>*...>{values.data<typename Vars::template type<I>>()...};
  }
  /// The factor's own code, compiled once a type and not once a use.
  template <class Pointers, std::size_t... I>
  HOLDFAST_NOINLINE static Vector<M> invoke(const F& factor, const Pointers& x, Jacobians<F>* J, std::index_sequence<I...>) {
    return factor(*std::get<I>(x)..., J);
  }
  template <class Pools, std::size_t... I>
  Vector<M> call(int i, const Pools& pools, const int* index, Jacobians<F>* J, std::index_sequence<I...> all) const {
    const int* mine = index + static_cast<std::ptrdiff_t>(i) * K;
    return invoke(factors_[i], Pools{std::get<I>(pools) + mine[I]...}, J, all);
  }
  template <std::size_t... I>
  Vector<M> call_at(int i, const double* const* ambient, Jacobians<F>* J, std::index_sequence<I...> all) const {
    typename Vars::Tuple x;
    (std::memcpy(static_cast<void*>(&std::get<I>(x)), ambient[I], sizeof(std::get<I>(x))), ...);
    return invoke(factors_[i], std::tuple<const typename Vars::template type<I>*...>{&std::get<I>(x)...}, J, all);
  }
  static void store(const Jacobians<F>& jacobians, double* J) { std::copy_n(jacobians.all.data(), M * N, J); }

  /// Blocks, gradient and cost of factor i; returns where the next factor's begin.
  double* contribution(int i, const double* r, const double* J, Curvature curvature, double* out) const {
    const RowWeights<M> w = row_weights<M>(loss_, weights_[i], Eigen::Map<const Vector<M>>(r), curvature);
    NormalBlocks<M, Vars>::write(r, J, w, out);
    return out + stride();
  }

  std::vector<F> factors_;
};

}  // namespace holdfast
