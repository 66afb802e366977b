// Every factor × variable types × loss as an edge of g2o.
#include <holdfast/adapters/g2o/g2o.hpp>

#include "tests/adapters/hosts.hpp"

namespace holdfast::testing {
namespace {

using holdfast::detail::G2oSlot;
using holdfast::detail::G2oSlotOf;

HostEvaluator in_g2o(const Draw& draw, const Loss& loss, double weight) {
  const auto term = holdfast::detail::host_term<G2oSlot, G2oSlotOf>(draw.term(loss, weight));
  return [term, keys = draw.keys](const Values& values) {
    std::vector<std::unique_ptr<g2o::OptimizableGraph::Vertex>> vertices;
    G2oAnyEdge edge(term);
    for (std::size_t k = 0; k < keys.size(); ++k) {
      const Values::Slot& slot = values.slot(keys[k]);
      vertices.emplace_back(term.slots[k]->make(values.pool(slot.pool).data(slot.index)));
      edge.setVertex(k, vertices.back().get());
    }
    edge.computeError();
    g2o::Vector3 rho(edge.chi2(), 1, 0);
    if (edge.robustKernel() != nullptr) edge.robustKernel()->robustify(edge.chi2(), rho);
    HostAnswer answer{0.5 * rho[0], {}};
    holdfast::detail::G2oTerm(term).linearize(edge.vertices(), [&](std::size_t k, const Eigen::MatrixXd& J) {
      std::vector<double> x(term.slots[k]->ambient);
      term.slots[k]->read(*vertices[k], x.data());
      append_in_our_tangent(*term.slots[k], x.data(), rho[1] * J.transpose() * edge.error(), answer.gradient);
    });
    return answer;
  };
}

TEST(G2oEveryFactor, CostAndGradientAreHoldfasts) { expect_every_factor_agrees(in_g2o); }

}  // namespace
}  // namespace holdfast::testing
