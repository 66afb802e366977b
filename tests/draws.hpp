// Every factor × variable types of samples.hpp, and a user's own, without their types: what the conformance tests of factors, back-ends and
// hosts run over. The factors are compiled once, for all of them (draws/*.cpp).
#pragma once

#include <functional>
#include <holdfast/adapters/ceres/block_layout.hpp>
#include <holdfast/adapters/detail/term.hpp>
#include <random>

namespace holdfast::testing {

struct Draw {
  std::string label;
  int residual_dim = 0;
  bool linear = false, convex = false;  ///< as the factor says of itself
  std::vector<Key> keys;
  std::function<Values(std::mt19937_64&)> values;                                     ///< random ones, by key
  std::function<void(Graph&, const Loss&, double weight)> add;                        ///< the factor
  std::function<void(Graph&, const Values& near, std::mt19937_64&)> add_priors;       ///< tight ones, whose means are a little off
  std::function<Eigen::VectorXd(const Values&, Eigen::MatrixXd* jacobian)> residual;  ///< the factor itself, called directly; an entry that
                                                                                      ///< it leaves unwritten is NaN
  holdfast::detail::Layouts layouts;                                                  ///< our own memory of each variable
  std::function<Term(const Loss&, double weight)> term;                               ///< what an adapter's typed front makes of the factor
};

std::vector<Draw> linear_draws(std::mt19937_64& rng);
std::vector<Draw> range_draws(std::mt19937_64& rng);
std::vector<Draw> missing_draws(std::mt19937_64& rng);
std::vector<Draw> direction_draws(std::mt19937_64& rng);
std::vector<Draw> state_draws(std::mt19937_64& rng);
std::vector<Draw> own_draws(std::mt19937_64& rng);

/// A new random instance of every factor.
inline std::vector<Draw> every_draw(std::mt19937_64& rng) {
  std::vector<Draw> all;
  for (auto list : {linear_draws, range_draws, missing_draws, direction_draws, state_draws, own_draws})
    for (Draw& draw : list(rng)) all.push_back(std::move(draw));
  return all;
}

}  // namespace holdfast::testing
