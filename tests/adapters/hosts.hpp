// What the conformance test of every host asks: at 100 random states of every factor × variable types × loss, its cost and its gradient
// are holdfast's, to 1e-9.
#pragma once

#include <gtest/gtest.h>

#include <holdfast/adapters/detail/host_term.hpp>
#include <limits>

#include "tests/draws.hpp"
#include "tests/problems.hpp"

namespace holdfast::testing {

struct HostAnswer {
  double cost = 0;
  std::vector<double> gradient;  ///< in our tangent, the variables in the order of the factor
};
/// Makes the host's problem of one factor, once, and then evaluates it at any values.
using HostEvaluator = std::function<HostAnswer(const Values&)>;
using MakeHostEvaluator = std::function<HostEvaluator(const Draw&, const Loss&, double weight)>;

/// A host's gradient with respect to its own tangent, appended in ours: g_theirs = Dᵀ g_ours.
inline void append_in_our_tangent(const holdfast::detail::HostSlot& slot, const double* x, const Eigen::VectorXd& theirs,
                                  std::vector<double>& gradient) {
  Eigen::MatrixXd D(slot.dim, slot.dim);
  slot.tangent(x, D.data());
  const Eigen::VectorXd ours = D.transpose().partialPivLu().solve(theirs);
  gradient.insert(gradient.end(), ours.data(), ours.data() + ours.size());
}

inline HostAnswer holdfast_answer(const Draw& draw, const Graph& graph, const Values& values) {
  const Gradient all = gradient(graph, values);
  HostAnswer answer{graph.cost(values), {}};
  for (Key key : draw.keys) {
    const auto k = std::find(all.keys.begin(), all.keys.end(), key) - all.keys.begin();
    const int dim = values.pool(values.slot(key).pool).dim();
    answer.gradient.insert(answer.gradient.end(), all.value.begin() + all.offsets[k], all.value.begin() + all.offsets[k] + dim);
  }
  return answer;
}

inline void expect_same_answer(const HostAnswer& host, const HostAnswer& ours) {
  constexpr double kSame = 1e-9, kLeast = std::numeric_limits<double>::min();  // smaller numbers have fewer digits
  EXPECT_NEAR(host.cost, ours.cost, kSame * ours.cost + kLeast);
  ASSERT_EQ(host.gradient.size(), ours.gradient.size());
  double largest = 0;
  for (double g : ours.gradient) largest = std::max(largest, std::abs(g));
  for (std::size_t i = 0; i < ours.gradient.size(); ++i) EXPECT_NEAR(host.gradient[i], ours.gradient[i], kSame * largest + kLeast) << i;
}

/// 10 random instances of every factor at 10 random states each.
inline void expect_every_factor_agrees(const MakeHostEvaluator& make) {
  constexpr int instances = 10, states = 10;
  constexpr double weight = 0.6;
  std::mt19937_64 rng(77);
  for (int instance = 0; instance < instances; ++instance)
    for (const Draw& draw : every_draw(rng)) {
      std::vector<Values> all;
      for (int i = 0; i < states; ++i) all.push_back(draw.values(rng));
      for (const Loss& loss : every_loss(draw.residual_dim)) {
        SCOPED_TRACE(draw.label + " " + loss.str());
        Graph graph;
        draw.add(graph, loss, weight);
        const HostEvaluator evaluate = make(draw, loss, weight);
        for (const Values& values : all) expect_same_answer(evaluate(values), holdfast_answer(draw, graph, values));
        if (::testing::Test::HasFailure()) return;  // one is enough
      }
    }
}

}  // namespace holdfast::testing
