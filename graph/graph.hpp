// The graph: factors on keys. cost(x) = Σ w_i ½ρ_i(s_i) over its factors (conventions, "Cost"), the one number that scores the
// answer of every back-end.
//
// References. What at() returns and batches() are valid until a factor is added or removed; a FactorId until its factor is removed.
// Threads. Any number may call const members at once, and solve the same graph from values of their own; a non-const member needs the graph
// for itself. No state is shared between graphs.
#pragma once

#include <holdfast/graph/detail/factor_type.hpp>
#include <holdfast/graph/function_factor.hpp>
#include <holdfast/graph/keys.hpp>
#include <holdfast/graph/linear_prior.hpp>
#include <optional>
#include <unordered_set>

namespace holdfast {

class Graph {
 public:
  Graph();
  Graph(const Graph& other);
  Graph(Graph&& other) noexcept;
  Graph& operator=(const Graph& other);
  Graph& operator=(Graph&& other) noexcept;

  template <class F>
  using Keys = FactorKeys<F::Variables::size>;

  /// Adds a factor with its own default loss and weight. Throws BadNumber (from the factor's validate()), BadKey where a key occurs twice.
  template <class F>
  FactorId add(const F& factor, const Keys<F>& keys) {
    if constexpr (detail::HasDefaultLoss<F>::value)
      return add(factor, keys, F::default_loss());
    else
      return add(factor, keys, Loss{});
  }
  template <class F>
  FactorId add(const F& factor, const Keys<F>& keys, const Loss& loss) {
    if constexpr (detail::HasDefaultWeight<F>::value)
      return add(factor, keys, loss, factor.default_weight());
    else
      return add(factor, keys, loss, 1.0);
  }
  /// weight ≥ 0 scales the whole term.
  template <class F>
  FactorId add(const F& factor, const Keys<F>& keys, const Loss& loss, double weight) {
    return Batch<F>::add_to(*this, factor, keys.data(), loss, weight);
  }
  /// The factor of run-time size (graph/linear_prior.hpp). Throws BadNumber, BadKey.
  FactorId add(const LinearPrior& prior);
  /// Factors of run-time functions (graph/function_factor.hpp): as many as keys.size() / types.size(). Throws BadOption, BadKey.
  std::vector<FactorId> add(const std::shared_ptr<const FunctionFactors>& function, const std::vector<Key>& keys, const Loss& loss = {});
  /// A copy of a factor of another graph, whatever it is, with its loss and weight. Throws BadKey.
  FactorId add_from(const Graph& other, FactorId id);
  void remove(FactorId id);
  bool contains(FactorId id) const;

  /// The factor itself: its numbers may be changed between solves, the structure stays.
  template <class F>
  F& at(FactorId id) {
    static_assert(!std::is_same_v<F, LinearPrior>, "what follows from a LinearPrior's numbers is kept: remove it, and add another");
    return const_cast<F&>(static_cast<const Graph*>(this)->at<F>(id));
  }
  template <class F>
  const F& at(FactorId id) const {
    const Place& place = checked(id);
    const FactorBatch& batch = *batches_[place.batch];
    if (batch.factor_type() != typeid(F)) fail<BadType>("factor ", batch.describe(place.index), " is no ", factor_name<F>());
    if constexpr (std::is_same_v<F, LinearPrior>)
      return static_cast<const LinearPriorBatch&>(batch).prior();
    else
      return static_cast<const Batch<F>&>(batch).factors()[place.index];
  }

  /// Changes the weight of a factor; the structure stays. Throws BadKey, BadNumber.
  void set_weight(FactorId id, double weight);
  /// Changes the loss of a whole batch; the structure stays. Throws BadKey, BadNumber, BadOption.
  void set_loss(int batch, const Loss& loss);
  /// Changes the loss of one factor. Within its family (another threshold) the structure stays; a loss of another kind, or with other
  /// flags, moves it to another batch: the id stays valid, the structure is a new one. Throws BadKey, BadNumber, BadOption.
  void set_loss(FactorId id, const Loss& loss);

  /// A fixed variable is a constant of the problem.
  void fix(Key key);
  void unfix(Key key);
  bool is_fixed(Key key) const { return fixed_.count(key) != 0; }
  const std::unordered_set<Key>& fixed() const { return fixed_; }

  /// Σ w ½ρ at these values. Throws BadKey, BadType.
  double cost(const Values& values) const;
  /// The whitened residual of one factor, without loss and weight: ‖r‖² is its s. Throws BadKey, BadType.
  Eigen::VectorXd residual(FactorId id, const Values& values) const;
  /// The factors that tie this variable, in the order of batches(); empty where there is none. Looks at every factor.
  std::vector<FactorId> factors_on(Key key) const;

  std::size_t size() const { return places_.size() - free_.size(); }
  const std::vector<std::unique_ptr<FactorBatch>>& batches() const { return batches_; }
  /// Every batch of factors F: fn(const Batch<F>&).
  template <class F, class Fn>
  void for_each_batch(Fn&& fn) const {
    for (const auto& batch : batches_)
      if (batch->factor_type() == typeid(F)) fn(static_cast<const Batch<F>&>(*batch));
  }
  /// Where a factor is now; valid until a factor is removed.
  struct Place {
    int batch = -1;
    int index = -1;
    unsigned generation = 0;
  };
  const Place& place(FactorId id) const { return checked(id); }
  FactorId id_of(int batch, int index) const;  ///< throws BadKey where there is no such batch or factor

  /// The graph with every factor that has a convex counterpart (factor.hpp, relaxed()) replaced by it, and every loss that is not convex by
  /// Huber; FactorIds stay valid.
  Graph relaxed() const;

  /// Changes whenever a factor comes or goes or a variable is fixed or freed.
  std::uint64_t structure() const { return structure_; }

  // ---- for files: a graph made again, batch by batch, with the FactorIds it had.

  struct Numbers {
    std::vector<unsigned> generations;  ///< of every FactorId::number that was given out
    std::vector<int> free;              ///< those without a factor: the last one is given out next
  };
  Numbers numbers() const;
  /// Of a graph without factors. `free` holds every number once. Throws BadKey.
  void set_numbers(const Numbers& numbers);
  /// An empty batch becomes the last one. Whoever has put one more factor into it then gives that its keys, weight and loss, which is of
  /// the batch's family.
  FactorBatch& add_batch(std::unique_ptr<FactorBatch> batch);
  FactorId enter(FactorBatch& batch, const Key* keys, double weight, const Loss& loss);

 private:
  template <class>
  friend class Batch;

  /// The batch of factors of this type under losses of this family; null where there is none.
  FactorBatch* find_batch(std::type_index factor_type, const Loss& loss);
  void check_new(std::string (*name)(), const Key* keys, std::size_t count, const Loss& loss, int residual_dim, double weight) const;
  [[noreturn]] void rethrow_named(const std::string& name, const Key* keys, std::size_t count, const BadNumber& error) const;
  void validate_loss(const FactorBatch& batch, const Loss& loss) const;
  const Place& checked(FactorId id) const;
  void require_batch(int batch) const;
  void take_out(const Place& place);

  std::vector<std::unique_ptr<FactorBatch>> batches_;
  std::vector<Place> places_;  ///< by FactorId::number
  std::vector<int> free_;
  std::unordered_set<Key> fixed_;
  std::uint64_t structure_;
};

template <class F>
FactorId Batch<F>::add_to(Graph& graph, const F& factor, const Key* keys, const Loss& loss, double weight) {
  (void)detail::factor_type_is_entered<F>;
  graph.check_new(factor_name<F>, keys, K, loss, M, weight);
  if constexpr (detail::HasValidate<F>::value) {
    try {
      factor.validate();
    } catch (const BadNumber& error) {
      graph.rethrow_named(factor_name<F>(), keys, K, error);
    }
  }
  FactorBatch* batch = graph.find_batch(typeid(F), loss);
  if (batch == nullptr) batch = &graph.add_batch(std::make_unique<Batch>(loss));
  static_cast<Batch*>(batch)->factors_.push_back(factor);
  return graph.enter(*batch, keys, weight, loss);
}

}  // namespace holdfast
