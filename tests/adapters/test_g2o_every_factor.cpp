// Every factor × variable types × loss as an edge of g2o.
#include <g2o/core/jacobian_workspace.h>

#include <holdfast/adapters/g2o.hpp>

#include "hosts.hpp"

namespace holdfast::testing {
namespace {

/// An edge that shows its Jacobians, and owns its vertices.
struct ShownEdge {
  holdfast::detail::G2oTerm term;
  std::vector<std::unique_ptr<g2o::OptimizableGraph::Vertex>> vertices;
  std::unique_ptr<G2oAnyEdge> edge;
};

HostEvaluator in_g2o(const HostDraw& draw, const Loss& loss, double weight) {
  holdfast::detail::G2oTerm term{draw.term(loss, weight), {}};
  for (const std::type_index& type : term.term.batch().types()) term.slots.push_back(holdfast::detail::g2o_slot(type));
  return [term, keys = draw.keys](const Values& values) {
    Values x = values;
    ShownEdge shown{term, {}, std::make_unique<G2oAnyEdge>(term)};
    for (std::size_t k = 0; k < keys.size(); ++k) {
      const Values::Slot& slot = x.slot(keys[k]);
      shown.vertices.emplace_back(term.slots[k]->make(x.pool(slot.pool).data(slot.index)));
      shown.edge->setVertex(k, shown.vertices.back().get());
    }
    shown.edge->computeError();
    double chi2 = shown.edge->chi2(), slope = 1;
    if (shown.edge->robustKernel() != nullptr) {
      g2o::Vector3 rho;
      shown.edge->robustKernel()->robustify(chi2, rho);
      chi2 = rho[0];
      slope = rho[1];
    }
    HostAnswer answer{0.5 * chi2, {}};
    term.linearize(shown.edge->vertices(), [&](std::size_t k, const Eigen::MatrixXd& J) {
      const Eigen::VectorXd g = slope * J.transpose() * shown.edge->error();
      std::vector<double> at(term.slots[k]->ambient);
      Eigen::MatrixXd D(J.cols(), J.cols());
      term.slots[k]->read(*shown.vertices[k], at.data());
      term.slots[k]->tangent(at.data(), D.data());
      const Eigen::VectorXd ours = D.transpose().partialPivLu().solve(g);
      answer.gradient.insert(answer.gradient.end(), ours.data(), ours.data() + ours.size());
    });
    return answer;
  };
}

TEST(G2oEveryFactor, CostAndGradientAreHoldfasts) { expect_every_factor_agrees(in_g2o); }

}  // namespace
}  // namespace holdfast::testing
