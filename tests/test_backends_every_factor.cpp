// Every factor × variable types × loss in every back-end: the cost and the gradient are those by hand, a step is reported honestly, and
// where there is one optimum only, everybody finds it.
#include <gtest/gtest.h>

#include <limits>

#ifdef HOLDFAST_WITH_CERES
#include <holdfast/solvers/ceres/ceres.hpp>
#endif

#include "tests/backends.hpp"
#include "tests/draws.hpp"
#include "tests/problems.hpp"

namespace holdfast::testing {
namespace {

constexpr double kWeight = 0.6;

/// fn(draw, its random values, the generator) for `instances` random instances of every factor.
template <class Fn>
void for_each_draw(int instances, const Fn& fn) {
  std::mt19937_64 rng(21);
  for (int i = 0; i < instances; ++i)
    for (const Draw& draw : every_draw(rng)) {
      SCOPED_TRACE(draw.label + ", instance " + std::to_string(i));
      fn(draw, draw.values(rng), rng);
    }
}

// ---- cost and gradient, by hand and by everybody

struct Expected {
  double cost;
  std::vector<double> gradient;  ///< in Resolved's tangent
  double scale;                  ///< what the gradient's rounding is relative to: Σ |J| |w r|
};

Expected evaluated_by_hand(const Draw& draw, const Values& at, const Graph& graph, const Loss& loss) {
  Eigen::MatrixXd J;
  const Eigen::VectorXd r = draw.residual(at, &J);
  const ReferenceTerm term = reference_term(loss, kWeight, r);
  const Eigen::VectorXd g = J.transpose() * term.weights.cwiseProduct(r);
  const double scale = (J.transpose().cwiseAbs() * term.weights.cwiseProduct(r).cwiseAbs()).maxCoeff();
  const Resolved resolved(graph, at);
  Expected expected{term.cost, std::vector<double>(resolved.tangent_dim()), scale};
  for (const Resolved::Variable& v : resolved.variables()) {
    int column = 0;
    for (std::size_t k = 0; draw.keys[k] != v.key; ++k) column += at.pool(at.slot(draw.keys[k]).pool).dim();
    for (int c = 0; v.offset >= 0 && c < v.dim; ++c) expected.gradient[v.offset + c] = g[column + c];
  }
  return expected;
}

void expect_close(const Expected& expected, double cost, const std::vector<double>& gradient, const char* who) {
  constexpr double kLeast = std::numeric_limits<double>::min();  // smaller numbers have fewer digits
  EXPECT_NEAR(cost, expected.cost, 1e-10 * expected.cost + kLeast) << who;
  ASSERT_EQ(gradient.size(), expected.gradient.size()) << who;
  for (std::size_t i = 0; i < gradient.size(); ++i)
    EXPECT_NEAR(gradient[i], expected.gradient[i], 1e-10 * expected.scale + kLeast) << who << " " << i;
}

void expect_same_cost_and_gradient(const Draw& draw, const Values& at, const Loss& loss, bool fix_first) {
  SCOPED_TRACE(loss.str());
  Graph graph;
  draw.add(graph, loss, kWeight);
  if (fix_first) graph.fix(draw.keys[0]);
  const Expected expected = evaluated_by_hand(draw, at, graph, loss);
  expect_close(expected, graph.cost(at), gradient(graph, at).value, "holdfast");
#ifdef HOLDFAST_WITH_CERES
  const CeresEvaluation ceres = evaluate_with_ceres(graph, at);
  expect_close(expected, ceres.cost, ceres.gradient, "ceres");
#endif
}

TEST(EveryFactor, CostAndGradientAreThoseByHand) {
  int count = 0;
  for_each_draw(4, [&](const Draw& draw, const Values& at, std::mt19937_64&) {
    const bool fix_first = draw.keys.size() > 1 && ++count % 2 == 0;
    for (const Loss& loss : every_loss(draw.residual_dim)) expect_same_cost_and_gradient(draw, at, loss, fix_first);
  });
}

// ---- one step, and the optimum

/// The factor among tight priors on its variables.
Graph held(const Draw& draw, const Values& at, const Loss& loss, std::mt19937_64 rng) {
  Graph graph;
  draw.add(graph, loss, kWeight);
  draw.add_priors(graph, at, rng);
  return graph;
}

/// What a back-end says of one step is what our cost and gradient say of the values it hands back.
void expect_honest_step(const std::string& backend, const Graph& graph, Values values) {
  Options options;
  options.max_iterations = 1;
  const double first = graph.cost(values);
  const Summary summary = solve(backend, graph, values, options);
  ASSERT_TRUE(summary.usable()) << summary.str();
  EXPECT_NEAR(summary.cost_first, first, 1e-12 * first);
  EXPECT_NEAR(summary.cost, graph.cost(values), 1e-12 * first);
  EXPECT_LE(summary.cost, first * (1 + 1e-12));
  if (backend != kGnc) {
    EXPECT_LE(summary.iterations, 1);
  }
}

TEST(EveryFactor, EveryBackendIsHonestAboutAStep) {
  for_each_draw(1, [](const Draw& draw, const Values& at, const std::mt19937_64& rng) {
    for (const Loss& loss : every_loss(draw.residual_dim))
      for (const std::string& backend : every_backend()) {
        SCOPED_TRACE(backend + " " + loss.str());
        expect_honest_step(backend, held(draw, at, loss, rng), at);
      }
  });
}

/// With tight priors the optimum near the start is the only one: everybody finds it.
void expect_same_optimum(const Graph& graph, const Values& at) {
  double least = INFINITY;
  std::vector<std::pair<std::string, double>> costs;
  for (const std::string& backend : every_backend()) {
    Values values = at;
    const Summary summary = solve(backend, graph, values);
    ASSERT_TRUE(summary.usable()) << backend << ": " << summary.str();
    costs.emplace_back(backend, graph.cost(values));
    least = std::min(least, costs.back().second);
  }
  for (const auto& [backend, cost] : costs) EXPECT_NEAR(cost, least, 1e-6 * least + 1e-12) << backend;
}

TEST(EveryFactor, EveryBackendFindsTheSameOptimum) {
  for_each_draw(1, [](const Draw& draw, const Values& at, const std::mt19937_64& rng) {
    for (const Loss& loss : {Loss(Squared{}), Loss(Huber{}), per_component(Huber{}), Loss(PseudoHuber{})}) {
      SCOPED_TRACE(loss.str());
      expect_same_optimum(held(draw, at, loss, rng), at);
    }
  });
}

}  // namespace
}  // namespace holdfast::testing
