// Every factor × variable types of samples.hpp, and a user's own, without their types: what the conformance tests of the adapters run over.
// The factors are compiled once (draws_*.cpp), for all hosts.
#pragma once

#include <functional>
#include <holdfast/adapters/block_layout.hpp>
#include <holdfast/adapters/term.hpp>
#include <holdfast/graph/gradient.hpp>
#include <random>

namespace holdfast::testing {

struct HostDraw {
  std::string label;
  int residual_dim = 0;
  std::vector<Key> keys;
  holdfast::detail::Layouts layouts;                            ///< our own memory of each variable
  std::function<Values(std::mt19937_64&)> values;               ///< random ones, by key
  std::function<Term(const Loss&, double weight)> term;         ///< what an adapter's typed front makes of the factor
  std::function<void(Graph&, const Loss&, double weight)> add;  ///< the same factor in a graph of ours
};

std::vector<HostDraw> linear_draws(std::mt19937_64& rng);
std::vector<HostDraw> range_draws(std::mt19937_64& rng);
std::vector<HostDraw> missing_draws(std::mt19937_64& rng);
std::vector<HostDraw> direction_draws(std::mt19937_64& rng);
std::vector<HostDraw> state_draws(std::mt19937_64& rng);
std::vector<HostDraw> own_draws(std::mt19937_64& rng);

/// A new random instance of every factor.
inline std::vector<HostDraw> every_draw(std::mt19937_64& rng) {
  std::vector<HostDraw> all;
  for (auto list : {linear_draws, range_draws, missing_draws, direction_draws, state_draws, own_draws})
    for (HostDraw& draw : list(rng)) all.push_back(std::move(draw));
  return all;
}

}  // namespace holdfast::testing
