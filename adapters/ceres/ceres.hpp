// Our factors in a user's own ceres::Problem, on the user's own memory. Link holdfast::ceres. Ceres 2.1 and later.
//
//   ceres_add(problem, Range<Pose2, Point2>{12.3, 0.5}, Huber{2}, {pose, beacon});                  // our own memory layout
//   ceres_add<PositionYaw, Own<Point2>>(problem, Range<Pose2, Point2>{12.3, 0.5}, Huber{2}, {pose, beacon});
//   problem.AddResidualBlock(ceres_cost<PositionYaw, Own<Point2>>(factor), ceres_loss(Huber{2}), pose, beacon);   // the same by hand
//   problem.SetManifold(pose, ceres_manifold<Pose3>());                                             // of our own memory layout
//
// Layouts: block_layout.hpp. The cost functions give d r / d (the user's numbers), so any manifold of the user's own fits, such as
// ceres::EigenQuaternionManifold on Separate<PositionQuaternion<>>.
//
// Ceres robustifies a whole residual block and nothing else. ceres_loss refuses a per-component loss of several components and a
// one-sided one by name; ceres_cost(factor, loss) folds just these into the residual, exactly (solvers/detail/fold.hpp), and takes no loss
// function beside it. ceres_add chooses. Cost and gradient are those of Graph::cost either way.
//
// The other way, from residual blocks to a holdfast graph, there is none: a ceres::CostFunction tells nobody what it measures.
#pragma once

#include <ceres/cost_function.h>
#include <ceres/loss_function.h>
#include <ceres/manifold.h>
#include <ceres/problem.h>

#include <holdfast/adapters/ceres/block_layout.hpp>
#include <holdfast/adapters/detail/term.hpp>

namespace holdfast {

namespace detail {
ceres::CostFunction* ceres_cost(const Term& term, const Layouts& layouts);
ceres::CostFunction* ceres_folded_cost(const Term& term, const Layouts& layouts);
ceres::ResidualBlockId ceres_add(ceres::Problem& problem, const Term& term, const Layouts& layouts, const std::vector<double*>& blocks);
ceres::Manifold* ceres_manifold(const BlockLayout& layout);
}  // namespace detail

/// The residual, whitened, under no loss. Blocks: those of the layouts, one after the other.
template <class... Layouts, class F>
ceres::CostFunction* ceres_cost(const F& factor) {
  return detail::ceres_cost(Term(factor, Squared{}), detail::layouts_of<F, Layouts...>());
}
/// The residual with a per-component or one-sided loss, and the weight, in it. BadOption for a loss of the whole block: ceres_loss has it.
template <class... Layouts, class F>
ceres::CostFunction* ceres_cost(const F& factor, const Loss& loss, double weight = 1) {
  return detail::ceres_folded_cost(Term(factor, loss, weight), detail::layouts_of<F, Layouts...>());
}

/// w ρ(s); null for a squared loss of weight 1. residual_dim: 0 where the loss does not ask for it. BadOption naming a loss that is no
/// function of ‖r‖², or that must know the number of components (StudentT).
ceres::LossFunction* ceres_loss(const Loss& loss, int residual_dim = 0, double weight = 1);

/// Cost function and loss function together, whatever the loss.
template <class... Layouts, class F>
ceres::ResidualBlockId ceres_add(ceres::Problem& problem, const F& factor, const Loss& loss, const std::vector<double*>& blocks,
                                 double weight = 1) {
  return detail::ceres_add(problem, Term(factor, loss, weight), detail::layouts_of<F, Layouts...>(), blocks);
}
/// With the factor's own default loss and weight.
template <class... Layouts, class F>
ceres::ResidualBlockId ceres_add(ceres::Problem& problem, const F& factor, const std::vector<double*>& blocks) {
  return detail::ceres_add(problem, Term(factor), detail::layouts_of<F, Layouts...>(), blocks);
}

/// Our manifold (translation in the world, rotation on the right) on a variable's own memory, or on a layout that is one block.
template <class VariableOrLayout>
ceres::Manifold* ceres_manifold() {
  return detail::ceres_manifold(block_layout<typename detail::LayoutOrOwn<VariableOrLayout>::type>());
}

}  // namespace holdfast
