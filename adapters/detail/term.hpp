// One term w ½ρ of a cost without its types: what the adapters hand to foreign graphs.
//
//   Term(factor)                          // the factor's own default loss and weight
//   Term(factor, loss, weight)
//   Term(factor, keys, loss, weight)      // of a host with keys of its own: messages name these, else x0, x1, …
//
// It evaluates the factor on ambient coordinates (a variable's own memory), the Jacobian with respect to our tangent.
#pragma once

#include <holdfast/graph/graph.hpp>

namespace holdfast {

class Term {
 public:
  /// Throws BadNumber or BadOption where Graph::add would.
  template <class F, class = typename F::Variables>
  explicit Term(const F& factor) : Term(factor, numbered<F>()) {}
  template <class F, class = typename F::Variables>
  Term(const F& factor, const Loss& loss, double weight = 1) : Term(factor, numbered<F>(), loss, weight) {}
  template <class F, class = typename F::Variables>
  Term(const F& factor, const Graph::Keys<F>& keys) : Term(alone(factor, keys), static_cast<F*>(nullptr)) {}
  template <class F, class = typename F::Variables>
  Term(const F& factor, const Graph::Keys<F>& keys, const Loss& loss, double weight = 1)
      : Term(alone(factor, keys, loss, weight), static_cast<F*>(nullptr)) {}
  /// Factor `index` of a batch that outlives the term.
  Term(const FactorBatch& batch, int index) : batch_(std::shared_ptr<const FactorBatch>(), &batch), index_(index) {}

  const FactorBatch& batch() const { return *batch_; }
  const Loss& loss() const { return batch_->loss(index_); }
  double weight() const { return batch_->weight(index_); }
  int residual_dim() const { return batch_->residual_dim(); }
  int total_dim() const { return batch_->total_dim(); }
  int arity() const { return batch_->arity(); }
  const std::vector<int>& dims() const { return batch_->dims(); }

  /// r, and J (residual_dim × total_dim, column-major) unless it is null.
  void evaluate(const double* const* ambient, double* r, double* J) const { batch_->evaluate_at(index_, ambient, r, J); }
  /// The factor with its loss and weight in a graph of ours, under these keys. BadOption where the type of the factor is not known any more
  /// (it came by its batch).
  void add_to(Graph& graph, const std::vector<Key>& keys) const {
    if (!add_) require_type();
    add_(*batch_, graph, keys);
  }
  /// The same factor under the same loss and weight: doubles within the tolerance, everything else to the bit. A factor of a type without
  /// fields() (graph/fields.hpp), or of functions, is the same as itself and its copies alone.
  bool equals(const Term& other, double tolerance) const;
  /// w ½ρ of a residual; weights (unless null): w ρ' of each component.
  double cost(const double* r, double* weights) const { return batch_->cost_of(index_, r, weights); }

 private:
  template <class F>
  Term(std::shared_ptr<const Graph> graph, F*) : batch_(graph, graph->batches().front().get()), index_(0), add_(add_again<F>) {}

  template <class F, class... LossAndWeight>
  static std::shared_ptr<const Graph> alone(const F& factor, const Graph::Keys<F>& keys, const LossAndWeight&... more) {
    auto graph = std::make_shared<Graph>();
    graph->add(factor, keys, more...);
    return graph;
  }
  template <class F>
  static void add_again(const FactorBatch& batch, Graph& graph, const std::vector<Key>& keys) {
    std::array<Key, F::Variables::size> all;
    std::copy_n(keys.begin(), all.size(), all.begin());
    graph.add(static_cast<const Batch<F>&>(batch).factors().front(), all, batch.loss(0), batch.weight(0));
  }
  [[noreturn]] void require_type() const;
  /// For a host without keys: the variables of the factor are x0, x1, …
  template <class F>
  static Graph::Keys<F> numbered() {
    std::array<Key, F::Variables::size> keys;
    for (std::size_t k = 0; k < keys.size(); ++k) keys[k] = Key('x', k);
    return keys;
  }

  std::shared_ptr<const FactorBatch> batch_;
  int index_;
  void (*add_)(const FactorBatch&, Graph&, const std::vector<Key>&) = nullptr;
};

}  // namespace holdfast
