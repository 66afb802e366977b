// One factor in a graph of its own, under any loss, and its plainest possible evaluation: what the conformance tests of all back-ends
// run over every factor × variable type × loss. Only the first part knows factor types; the lists of factors are spread over several
// sources (test_backends_*.cpp) because they take long to compile.
#pragma once

#include <gtest/gtest.h>

#ifdef HOLDFAST_WITH_CERES
#include <holdfast/solvers/ceres.hpp>
#endif

#include "problems.hpp"
#include "samples.hpp"

namespace holdfast::testing {

// ---- from a factor type to a problem without types

struct Draw {
  std::string label;
  int residual_dim = 0;
  std::vector<Key> keys;
  Values at;                                                                        ///< random values
  std::function<void(Graph&, const Loss&, double)> add;                             ///< the factor, with a loss and a weight
  std::function<void(Graph&)> add_priors;                                           ///< tight ones, whose means are a little off `at`
  std::function<void(const Values&, Eigen::VectorXd&, Eigen::MatrixXd&)> residual;  ///< r and J of the factor itself, called directly
};

template <class F, std::size_t... I>
Draw draw_of(std::mt19937_64& rng, std::index_sequence<I...>) {
  using Vars = typename F::Variables;
  const F factor = Sample<F>::factor(rng);
  const auto x = Sample<F>::variables(rng);
  const std::array<Key, sizeof...(I)> keys{Key(static_cast<char>('C' - I), 7 + 3 * I)...};
  Draw draw;
  draw.label = factor_name<F>() + " on" + ((std::string(" ") + Vars::template type<I>::name()) + ...);
  draw.residual_dim = F::residual_dim;
  draw.keys.assign(keys.begin(), keys.end());
  (draw.at.insert(keys[I], std::get<I>(x)), ...);
  draw.add = [factor, keys](Graph& graph, const Loss& loss, double weight) { graph.add(factor, keys, loss, weight); };
  const auto means = std::make_tuple(std::get<I>(x).retract(random_vector<Vars::template type<I>::dim>(rng, 0.1))...);
  draw.add_priors = [keys, means](Graph& graph) {
    (graph.add(Prior<typename Vars::template type<I>>::from_sigmas(std::get<I>(means), Vector<Vars::template type<I>::dim>::Constant(0.1)),
               {keys[I]}),
     ...);
  };
  draw.residual = [factor, keys](const Values& values, Eigen::VectorXd& r, Eigen::MatrixXd& jacobian) {
    Jacobians<F> J;
    r = factor(values.at<typename Vars::template type<I>>(keys[I])..., &J);
    jacobian = J.all;
  };
  return draw;
}

template <class F>
Draw draw_of(std::mt19937_64& rng) {
  return draw_of<F>(rng, std::make_index_sequence<F::Variables::size>{});
}

/// fn(draw) for a few random instances of every factor of a list.
template <class List, class Fn>
void for_each_draw(int draws, const Fn& fn) {
  for_each_type<List>([&](auto tag) {
    std::mt19937_64 rng(21);
    for (int i = 0; i < draws; ++i) {
      const Draw draw = draw_of<typename decltype(tag)::type>(rng);
      SCOPED_TRACE(draw.label + ", draw " + std::to_string(i));
      fn(draw);
    }
  });
}

// ---- cost and gradient, by hand and by everybody

struct Expected {
  double cost;
  std::vector<double> gradient;  ///< in Resolved's tangent
  double scale;                  ///< what the gradient's rounding is relative to: Σ |J| |w r|
};

inline Expected evaluated_by_hand(const Draw& draw, const Graph& graph, const Loss& loss, double weight) {
  Eigen::VectorXd r;
  Eigen::MatrixXd J;
  draw.residual(draw.at, r, J);
  const ReferenceTerm term = reference_term(loss, weight, r);
  const Eigen::VectorXd g = J.transpose() * term.weights.cwiseProduct(r);
  const double scale = (J.transpose().cwiseAbs() * term.weights.cwiseProduct(r).cwiseAbs()).maxCoeff();
  const Resolved resolved(graph, draw.at);
  Expected expected{term.cost, std::vector<double>(resolved.tangent_dim()), scale};
  for (const Resolved::Variable& v : resolved.variables()) {
    int column = 0;
    for (std::size_t k = 0; draw.keys[k] != v.key; ++k) column += draw.at.pool(draw.at.slot(draw.keys[k]).pool).dim();
    for (int c = 0; v.offset >= 0 && c < v.dim; ++c) expected.gradient[v.offset + c] = g[column + c];
  }
  return expected;
}

inline void expect_close(const Expected& expected, double cost, const std::vector<double>& gradient, const char* who) {
  EXPECT_NEAR(cost, expected.cost, 1e-10 * expected.cost) << who;
  ASSERT_EQ(gradient.size(), expected.gradient.size()) << who;
  for (std::size_t i = 0; i < gradient.size(); ++i)
    EXPECT_NEAR(gradient[i], expected.gradient[i], 1e-10 * expected.scale) << who << " " << i;
}

inline void expect_same_cost_and_gradient(const Draw& draw, const Loss& loss, bool fix_first) {
  SCOPED_TRACE(loss.str());
  constexpr double weight = 0.6;
  Graph graph;
  draw.add(graph, loss, weight);
  if (fix_first) graph.fix(draw.keys[0]);
  const Expected expected = evaluated_by_hand(draw, graph, loss, weight);
  expect_close(expected, graph.cost(draw.at), gradient(graph, draw.at).value, "holdfast");
#ifdef HOLDFAST_WITH_CERES
  const CeresEvaluation ceres = evaluate_with_ceres(graph, draw.at);
  expect_close(expected, ceres.cost, ceres.gradient, "ceres");
#endif
}

/// What a back-end says of one step is what our cost and gradient say of the values it hands back.
inline void expect_honest_step(const std::string& backend, const Draw& draw, const Loss& loss) {
  SCOPED_TRACE(backend + " " + loss.str());
  Graph graph;
  draw.add(graph, loss, 0.6);
  draw.add_priors(graph);
  Values values = draw.at;
  Options options;
  options.max_iterations = 1;
  const double first = graph.cost(values);
  const Summary summary = solve(backend, graph, values, options);
  ASSERT_TRUE(summary.usable()) << summary.str();
  EXPECT_NEAR(summary.cost_first, first, 1e-12 * first);
  EXPECT_NEAR(summary.cost, graph.cost(values), 1e-12 * first);
  EXPECT_LE(summary.cost, first * (1 + 1e-12));
  EXPECT_LE(summary.iterations, 1);
}

/// With tight priors the optimum near the start is the only one: everybody finds it.
inline void expect_same_optimum(const Draw& draw, const Loss& loss) {
  SCOPED_TRACE(loss.str());
  Graph graph;
  draw.add(graph, loss, 0.6);
  draw.add_priors(graph);
  double least = INFINITY;
  std::vector<std::pair<std::string, double>> costs;
  for (const std::string& backend : backend_names()) {
    Values values = draw.at;
    const Summary summary = solve(backend, graph, values);
    ASSERT_TRUE(summary.usable()) << backend << ": " << summary.str();
    costs.emplace_back(backend, graph.cost(values));
    least = std::min(least, costs.back().second);
  }
  for (const auto& [backend, cost] : costs) EXPECT_NEAR(cost, least, 1e-6 * least + 1e-12) << backend;
}

// ---- the tests of one list of factors

template <class List>
void expect_conforming_evaluation() {
  int count = 0;
  for_each_draw<List>(4, [&](const Draw& draw) {
    const bool fix_first = draw.keys.size() > 1 && ++count % 2 == 0;
    for (const Loss& loss : every_loss(draw.residual_dim)) expect_same_cost_and_gradient(draw, loss, fix_first);
  });
}

template <class List>
void expect_conforming_steps() {
  for_each_draw<List>(1, [](const Draw& draw) {
    for (const Loss& loss : every_loss(draw.residual_dim))
      for (const std::string& backend : backend_names()) expect_honest_step(backend, draw, loss);
  });
}

template <class List>
void expect_conforming_optima() {
  for_each_draw<List>(1, [](const Draw& draw) {
    for (const Loss& loss : {Loss(Squared{}), Loss(Huber{}), per_component(Huber{}), Loss(PseudoHuber{})}) expect_same_optimum(draw, loss);
  });
}

#define HOLDFAST_CONFORMANCE_TESTS(List)                                              \
  TEST(List, CostAndGradientAreThoseByHand) { expect_conforming_evaluation<List>(); } \
  TEST(List, EveryBackendIsHonestAboutAStep) { expect_conforming_steps<List>(); }     \
  TEST(List, EveryBackendFindsTheSameOptimum) { expect_conforming_optima<List>(); }

}  // namespace holdfast::testing
