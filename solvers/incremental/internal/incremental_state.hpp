// What an Incremental holds beside its graph and values. Internal.
#pragma once

#include <holdfast/solvers/incremental/incremental.hpp>
#include <holdfast/solvers/incremental/internal/clique_tree.hpp>
#include <set>
#include <unordered_map>
#include <unordered_set>

namespace holdfast {

/// What ties the graph and the values to the tree.
struct Incremental::State {
  static constexpr int kNew = -2;  ///< in a file: a variable that no update has seen
  struct Variable {
    int number = -1;  ///< in the tree; −1: fixed
    Values::Slot slot{-1, -1};
    int dim = 0;
  };
  detail::CliqueTree tree;
  std::unordered_map<Key, Variable> variables;
  std::vector<Key> key_of;              ///< by number in the tree
  std::vector<int> term_of;             ///< by FactorId::number; −1: none
  std::vector<FactorId> factor_of;      ///< by term
  std::vector<std::vector<int>> index;  ///< by batch: the pool index of each variable of each factor
  std::vector<FactorId> new_factors;
  double work = 0, whole = 0;   ///< multiply–add pairs since all was ordered afresh, and of that
  std::unordered_set<int> far;  ///< variables of the tree that may be further than `relinearize` from where they stand
  std::vector<double> contribution, H, g;
  std::vector<char> is_free;
  std::vector<int> numbers;

  // For findings and reports, where they are asked for.
  struct Standing {
    Finding finding;
    FactorId factor;  ///< of a range at zero distance
  };
  std::vector<FactorId> looked_at;  ///< factors that the update at hand has linearised
  std::set<Key> touched;            ///< variables that these, or factors that have gone, are on
  std::vector<Standing> standing;   ///< findings that have not ended

  Variable& of(Key key) {
    const auto it = variables.find(key);
    if (it == variables.end()) fail<BadKey>("there is no variable ", key, "; insert() it first");
    return it->second;
  }
};

}  // namespace holdfast
