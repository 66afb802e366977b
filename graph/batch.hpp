// A batch: the factors of one type under losses of one family (their thresholds may differ), side by side. One virtual call evaluates a
// range of factors; inside, all sizes are fixed and nothing is allocated. Solvers, reports and adapters see factors through this interface
// only. What they make of residuals and Jacobians depends on sizes alone and is compiled once in the library
// (graph/internal/block_kernels.hpp); a factor type adds the code that evaluates, copies and removes its factors.
#pragma once

#include <algorithm>
#include <cstring>
#include <holdfast/graph/detail/normal_blocks.hpp>
#include <holdfast/graph/values.hpp>
#include <memory>
#include <typeindex>
#include <vector>

namespace holdfast {

#define HOLDFAST_NOINLINE __attribute__((noinline))

class Graph;
struct BlockKernels;

/// Names one factor of a graph for as long as it is in it.
struct FactorId {
  int number = -1;
  unsigned generation = 0;
};

class FactorBatch {
 public:
  virtual ~FactorBatch() = default;

  const std::string& name() const { return name_; }
  std::type_index factor_type() const { return factor_type_; }
  int size() const { return static_cast<int>(ids_.size()); }
  int residual_dim() const { return residual_dim_; }
  bool is_linear() const { return is_linear_; }
  bool is_convex() const { return is_convex_; }
  bool has_hessian() const { return has_hessian_; }  ///< its factors say hessian() (factor.hpp)
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

  /// Of factor i.
  const Loss& loss(int i) const { return losses_[losses_.size() == 1 ? 0 : i]; }
  /// Every factor has the same.
  bool has_one_loss() const { return losses_.size() == 1; }
  /// Kind and flags are those of every factor; so is the threshold where has_one_loss().
  const Loss& family() const { return losses_.front(); }

  /// r of factors [first, last), residual_dim doubles each, and their Jacobians (residual_dim × total_dim, column-major) unless J
  /// is null. index: the pool index of each variable of each factor of the batch (Resolved::Batch).
  virtual void evaluate(const Values& values, const int* index, int first, int last, double* r, double* J) const = 0;
  /// The same for factor i at variables given by their ambient coordinates (foreign solvers own their memory).
  virtual void evaluate_at(int i, const double* const* ambient, double* r, double* J) const = 0;
  /// hessian() of factors [first, last), total_dim × total_dim each. Only where has_hessian().
  virtual void hessians(const Values& values, const int* index, int first, int last, double* H) const;

  /// Each factor's part of the normal equations: the blocks (a, b), a ≥ b, of its H, column by column of blocks, each
  /// column-major dims[a] × dims[b]; then its gradient; then its cost: stride() doubles a factor.
  void contributions(const Values& values, const int* index, int first, int last, Curvature curvature, double* out) const;
  int stride() const { return stride_; }
  /// The same where r and J of factors [first, last) are known already, as evaluate() writes them. Of linear factors: exact means newton.
  void contributions_at(const double* r, const double* J, int first, int last, Curvature curvature, double* out) const;
  /// J δ of factors [first, last); offsets: where in δ each variable of each factor of the batch begins, −1: a fixed one.
  void apply_jacobians(const double* J, const int* offsets, int first, int last, const double* delta, double* out) const;

  /// Each factor's part of Jᵀ W r̈ (total_dim doubles, then a 0): r̈, the second derivative of the residual along δ, by finite difference
  /// from `moved` = values ⊕ hδ; W = w ρ' at the values. offsets as for apply_jacobians.
  void curvatures(const Values& values, const Values& moved, double h, const double* delta, const int* index, const int* offsets, int first,
                  int last, double* out) const;

  /// Each factor's part of the gradient (total_dim doubles), then its cost.
  void gradients(const Values& values, const int* index, int first, int last, double* out) const;

  /// Σ w ½ρ over factors [first, last).
  double cost(const Values& values, const int* index, int first, int last) const;
  /// w ½ρ of one factor from its residual; weights (unless null): w ρ' of each component.
  double cost_of(int i, const double* r, double* weights) const;

  virtual std::unique_ptr<FactorBatch> clone() const = 0;
  /// True where a factor of the other batch may stand in this one, under a loss of its family.
  virtual bool takes_factors_of(const FactorBatch& other) const { return factor_type_ == other.factor_type_; }
  /// What went wrong in an evaluation since it was last asked (graph/function_factor.hpp), and forgets it; "": nothing.
  virtual std::string take_error() const { return {}; }

 protected:
  friend class Graph;
  FactorBatch(std::string name, std::type_index factor_type, Loss loss);
  /// What follows from the types and dimensions of the variables.
  void set_sizes(int residual_dim);

  // What Graph asks of a factor type.
  virtual std::unique_ptr<FactorBatch> make_empty(const Loss& loss) const = 0;
  /// Its factors' convex counterparts (factor.hpp, relaxed()) and nothing else; null where they have none.
  virtual std::unique_ptr<FactorBatch> relaxed_factors() const { return nullptr; }
  virtual void push_from(const FactorBatch& other, int i) = 0;  ///< a copy of factor i of a batch of the same type
  virtual void erase(int i) = 0;                                ///< the last one takes its place

  /// The entries of a new factor, whose numbers have been pushed already.
  void push_entries(const Key* keys, double weight, const Loss& loss, int id);
  void erase_entries(int i);
  void set_loss_of(int i, const Loss& loss);
  /// Takes the place of another batch on the same variables: its keys, weights and losses.
  void take_place_of(const FactorBatch& other);

  std::string name_;
  std::type_index factor_type_;
  int residual_dim_ = 0;
  bool is_linear_ = false, is_convex_ = false, has_hessian_ = false;
  std::vector<std::type_index> types_;
  std::vector<const char*> type_names_;
  std::vector<int> dims_;
  int total_dim_ = 0;
  int stride_ = 0;
  std::vector<double> JtJ_;  ///< of a batch of one factor whose Jacobian is constant: known; empty: it is not

 private:
  /// Contributions from each factor's N × N matrix in place of JᵀJ.
  void contributions_from(const double* r, const double* J, const double* matrices, int first, int last, Curvature curvature,
                          double* out) const;
  bool takes_hessians(Curvature curvature) const {
    return curvature == Curvature::exact && has_hessian_ && (residual_dim_ == 1 || !family().per_component);
  }

  const BlockKernels* kernels_ = nullptr;
  std::vector<Key> keys_;
  std::vector<double> weights_;
  std::vector<Loss> losses_;  ///< one, or one for each factor
  std::vector<int> ids_;      ///< Graph's number of each factor
};

/// What a factor measures as the second variable in the frame of the first (factor.hpp, relative_pose()).
template <class P>
struct MeasuredPose {
  P pose;
  Matrix<P::dim, P::dim> information;
};
/// The batches whose factors measure relative poses of type P:  if (const auto* poses = dynamic_cast<const RelativePoses<P>*>(&batch)) …
template <class P>
class RelativePoses {
 public:
  virtual MeasuredPose<P> measured_pose(int i) const = 0;

 protected:
  ~RelativePoses() = default;
};

namespace detail {

struct NoFacet {};
template <class F, bool = HasRelativePose<F>::value>
struct PoseFacet {
  using type = NoFacet;
};
template <class F>
struct PoseFacet<F, true> {
  using type = RelativePoses<std::decay_t<decltype(std::declval<const F&>().relative_pose())>>;
};

/// Answers the facet's question where there is one.
template <class Derived, class F, class Facet = typename PoseFacet<F>::type>
class PoseFacetOf : public Facet {};
template <class Derived, class F, class P>
class PoseFacetOf<Derived, F, RelativePoses<P>> : public RelativePoses<P> {
 public:
  MeasuredPose<P> measured_pose(int i) const final {
    const F& factor = static_cast<const Derived*>(this)->factors()[i];
    return {factor.relative_pose(), factor.sqrt_information.transpose() * factor.sqrt_information};
  }
};

}  // namespace detail

template <class F>
class Batch final : public FactorBatch, public detail::PoseFacetOf<Batch<F>, F> {
 public:
  using Vars = typename F::Variables;
  static constexpr int M = F::residual_dim;
  static constexpr int N = Vars::total_dim;
  static constexpr int K = Vars::size;

  explicit Batch(const Loss& loss) : FactorBatch(factor_name<F>(), typeid(F), loss) {
    is_linear_ = holdfast::is_linear<F>;
    is_convex_ = holdfast::is_convex<F>;
    has_hessian_ = holdfast::has_hessian<F>;
    describe_variables(All());
  }

  /// What Graph::add does with a factor, once its keys have their number. Not inline: for the usual factors it is in the library
  /// (factors/compiled.cpp), so that those who add them need not compile it. Defined in graph.hpp.
  static FactorId add_to(Graph& graph, const F& factor, const Key* keys, const Loss& loss, double weight);

  const std::vector<F>& factors() const { return factors_; }
  std::vector<F>& factors() { return factors_; }

  void evaluate(const Values& values, const int* index, int first, int last, double* r, double* J) const override {
    const Pointers pools = pools_of(values, All());
    Jacobians<F> jacobians;
    for (int i = first; i < last; ++i, r += M) {
      write(invoke(factors_[i], at(pools, index, i, All()), J == nullptr ? nullptr : &jacobians, All()), r);
      if (J == nullptr) continue;
      std::copy_n(jacobians.all.data(), M * N, J);
      J += M * N;
    }
  }

  void evaluate_at(int i, const double* const* ambient, double* r, double* J) const override {
    typename Vars::Tuple x;
    copy_ambient(ambient, x, All());
    Jacobians<F> jacobians;
    write(invoke(factors_[i], addresses(x, All()), J == nullptr ? nullptr : &jacobians, All()), r);
    if (J != nullptr) std::copy_n(jacobians.all.data(), M * N, J);
  }

  void hessians(const Values& values, const int* index, int first, int last, double* H) const override {
    if constexpr (holdfast::has_hessian<F>) {
      const Pointers pools = pools_of(values, All());
      for (int i = first; i < last; ++i, H += N * N)
        Eigen::Map<Matrix<N, N>>(H, N, N) = hessian_at(factors_[i], at(pools, index, i, All()), All());
    } else {
      FactorBatch::hessians(values, index, first, last, H);
    }
  }

  std::unique_ptr<FactorBatch> clone() const override { return std::make_unique<Batch>(*this); }

 private:
  friend class Graph;
  template <class>
  friend class Batch;
  using All = std::make_index_sequence<K>;
  template <class>
  struct PointersTo;
  template <class... V>
  struct PointersTo<variables<V...>> {
    using type = std::tuple<const V*...>;
  };
  using Pointers = typename PointersTo<Vars>::type;

  std::unique_ptr<FactorBatch> make_empty(const Loss& loss) const override { return std::make_unique<Batch>(loss); }
  std::unique_ptr<FactorBatch> relaxed_factors() const override {
    if constexpr (detail::HasRelaxed<F>::value) {
      auto convex = std::make_unique<Batch<decltype(std::declval<const F&>().relaxed())>>(Loss{});
      for (const F& factor : factors_) convex->factors_.push_back(factor.relaxed());
      return convex;
    } else {
      return nullptr;
    }
  }
  void push_from(const FactorBatch& other, int i) override { factors_.push_back(static_cast<const Batch&>(other).factors_[i]); }
  void erase(int i) override {
    factors_[i] = factors_.back();
    factors_.pop_back();
  }

  template <std::size_t... I>
  void describe_variables(std::index_sequence<I...>) {
    types_ = {std::type_index(typeid(typename Vars::template type<I>))...};
    type_names_ = {Vars::template type<I>::name()...};
    dims_ = {Vars::dims[I]...};
    set_sizes(M);
  }
  template <std::size_t... I>
  static Pointers pools_of(const Values& values, std::index_sequence<I...>) {
    return {values.data<typename Vars::template type<I>>()...};
  }
  template <std::size_t... I>
  static Pointers at(const Pointers& pools, const int* index, int i, std::index_sequence<I...>) {
    const int* mine = index + static_cast<std::ptrdiff_t>(i) * K;
    return {std::get<I>(pools) + mine[I]...};
  }
  template <std::size_t... I>
  static void copy_ambient(const double* const* ambient, typename Vars::Tuple& x, std::index_sequence<I...>) {
    (std::memcpy(static_cast<void*>(&std::get<I>(x)), ambient[I], sizeof(std::get<I>(x))), ...);
  }
  template <std::size_t... I>
  static Pointers addresses(const typename Vars::Tuple& x, std::index_sequence<I...>) {
    return {&std::get<I>(x)...};
  }
  static void write(const Vector<M>& residual, double* r) { std::copy_n(residual.data(), M, r); }
  /// The factor's own code, compiled once a type and not once a use.
  template <std::size_t... I>
  HOLDFAST_NOINLINE static Vector<M> invoke(const F& factor, const Pointers& x, Jacobians<F>* J, std::index_sequence<I...>) {
    return factor(*std::get<I>(x)..., J);
  }
  template <std::size_t... I>
  static Matrix<N, N> hessian_at(const F& factor, const Pointers& x, std::index_sequence<I...>) {
    return factor.hessian(*std::get<I>(x)...);
  }

  std::vector<F> factors_;
};

}  // namespace holdfast
