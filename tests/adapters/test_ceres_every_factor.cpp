// Every factor × variable types × loss in a user's ceres::Problem, on our own memory layout with our manifold.
#include <ceres/ceres.h>

#include <holdfast/adapters/ceres/ceres.hpp>

#include "tests/adapters/hosts.hpp"

namespace holdfast::testing {
namespace {

HostEvaluator in_ceres(const Draw& draw, const Loss& loss, double weight) {
  auto problem = std::make_shared<ceres::Problem>();
  auto memory = std::make_shared<std::vector<std::vector<double>>>();
  std::vector<double*> blocks;
  for (const BlockLayout* layout : draw.layouts) memory->emplace_back(layout->size);
  for (std::size_t k = 0; k < memory->size(); ++k) {
    blocks.push_back((*memory)[k].data());
    problem->AddParameterBlock(blocks[k], draw.layouts[k]->size, holdfast::detail::ceres_manifold(*draw.layouts[k]));
  }
  holdfast::detail::ceres_add(*problem, draw.term(loss, weight), draw.layouts, blocks);
  return [problem, memory, keys = draw.keys, layouts = draw.layouts, blocks](const Values& values) {
    Values x = values;
    for (std::size_t k = 0; k < keys.size(); ++k) layouts[k]->write(x.pool(x.slot(keys[k]).pool).data(x.slot(keys[k]).index), blocks[k]);
    HostAnswer answer;
    ceres::Problem::EvaluateOptions options;
    options.parameter_blocks = blocks;
    problem->Evaluate(options, &answer.cost, nullptr, &answer.gradient, nullptr);
    return answer;
  };
}

TEST(CeresEveryFactor, CostAndGradientAreHoldfasts) { expect_every_factor_agrees(in_ceres); }

}  // namespace
}  // namespace holdfast::testing
