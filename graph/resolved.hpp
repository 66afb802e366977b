// A graph and its values, resolved once: keys become indices. Reused while neither structure changes.
#pragma once

#include <holdfast/graph/detail/parallel.hpp>
#include <holdfast/graph/graph.hpp>

namespace holdfast {

class Resolved {
 public:
  struct Variable {
    Key key;
    int pool;   ///< in Values
    int index;  ///< in the pool
    int dim;
    int offset;  ///< of its tangent in the problem's; −1: fixed
  };
  struct Batch {
    std::vector<int> index;     ///< pool index of each variable of each factor
    std::vector<int> variable;  ///< number in variables() of each variable of each factor
  };

  /// Throws BadKey for a key without a value, BadType for one of the wrong type; both name the factor.
  Resolved(const Graph& graph, const Values& values) { rebuild(graph, values); }
  Resolved() = default;

  /// The same as a new one, in the memory of the old one.
  void rebuild(const Graph& graph, const Values& values);
  bool matches(const Graph& graph, const Values& values) const {
    return graph_structure_ == graph.structure() && values_structure_ == values.structure();
  }
  /// The variables that some factor touches, pool by pool.
  const std::vector<Variable>& variables() const { return variables_; }
  const std::vector<Batch>& batches() const { return batches_; }
  int tangent_dim() const { return tangent_dim_; }  ///< of the free variables
  int residual_dim() const { return residual_dim_; }

  /// Σ w ½ρ, summed in an order that does not depend on the number of threads.
  double cost(const Graph& graph, const Values& values, ThreadPool* pool = nullptr) const;
  /// to = from ⊕ delta for every free variable; the others keep what `to` holds.
  void retract(const Values& from, const double* delta, Values& to) const;
  /// delta = to ⊖ from.
  void local(const Values& from, const Values& to, double* delta) const;
  /// The first factor, in the graph's order, whose residual is not finite at these values: in words, and its keys (both empty
  /// where there is none).
  struct Culprit {
    std::string text;
    std::vector<Key> keys;
  };
  Culprit first_non_finite(const Graph& graph, const Values& values) const;

 private:
  void resolve_batch(const Graph& graph, const Values& values, int batch);

  std::vector<Variable> variables_;
  std::vector<Batch> batches_;
  int tangent_dim_ = 0;
  int residual_dim_ = 0;
  std::uint64_t graph_structure_ = 0;
  std::uint64_t values_structure_ = 0;
  std::vector<std::vector<int>> numbers_;  // while building: of each variable, by pool and index; −1: no factor touches it
};

/// Calls fn(batch, first, last) for every chunk of factors of the graph; the chunks have a fixed size, so whatever is
/// summed chunk by chunk has the same bits for any number of threads.
struct Chunk {
  int batch, first, last;
};
std::vector<Chunk> chunks_of(const Graph& graph, int factors_per_chunk);

}  // namespace holdfast
