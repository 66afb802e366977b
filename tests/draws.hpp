// Every factor × variable types that says HOLDFAST_CONFORMS (tests/conforms.hpp), without its types: what the conformance tests of factors,
// back-ends and foreign libraries run over.
#pragma once

#include <functional>
#include <holdfast/adapters/ceres/block_layout.hpp>
#include <holdfast/adapters/detail/term.hpp>
#include <map>
#include <random>

namespace holdfast::testing {

/// One random instance of a factor.
struct Draw {
  std::string label;
  int residual_dim = 0;
  bool linear = false, convex = false;  ///< as the factor says of itself
  bool validates = false;               ///< it has a validate()
  std::vector<Key> keys;
  std::function<Values(std::mt19937_64&)> values;                                     ///< random ones, by key
  std::function<void(Graph&, const Loss&, double weight)> add;                        ///< the factor
  std::function<void(Graph&, const Values& near, std::mt19937_64&)> add_priors;       ///< tight ones, whose means are a little off
  std::function<Eigen::VectorXd(const Values&, Eigen::MatrixXd* jacobian)> residual;  ///< the factor itself, called directly; an entry that
                                                                                      ///< it leaves unwritten is NaN
  std::function<Eigen::MatrixXd(const Values&)> hessian;                              ///< where the factor has one
  int numbers = 0;                                                                    ///< floating-point numbers in the struct
  std::function<void(Graph&, int number, double bad)> add_spoilt;                     ///< the factor with one of its numbers replaced
  holdfast::detail::Layouts layouts;                                                  ///< our own memory of each variable
  std::function<Term(const Loss&, double weight)> term;                               ///< what an adapter's typed front makes of the factor
};

using MakeDraws = std::vector<Draw> (*)(std::mt19937_64&);
/// What HOLDFAST_CONFORMS has entered, by the text between its brackets.
inline std::map<std::string, MakeDraws>& conforming_factors() {
  static std::map<std::string, MakeDraws> all;
  return all;
}

/// A new random instance of every factor.
inline std::vector<Draw> every_draw(std::mt19937_64& rng) {
  std::vector<Draw> all;
  for (const auto& [text, make] : conforming_factors())
    for (Draw& draw : make(rng)) all.push_back(std::move(draw));
  return all;
}

}  // namespace holdfast::testing
