// Every factor × variable types × loss as a factor of GTSAM.
#include <gtsam/linear/JacobianFactor.h>
#include <gtsam/linear/VectorValues.h>

#include <holdfast/adapters/gtsam/gtsam.hpp>

#include "tests/adapters/hosts.hpp"

namespace holdfast::testing {
namespace {

HostEvaluator in_gtsam(const Draw& draw, const Loss& loss, double weight) {
  const auto term = holdfast::detail::gtsam_term(draw.term(loss, weight));
  gtsam::KeyVector keys;
  for (const Key key : draw.keys) keys.push_back(gtsam_key(key));
  const auto factor = std::make_shared<GtsamFactor>(term, keys);
  return [factor, slots = term.slots, keys](const Values& values) {
    const gtsam::Values theirs = to_gtsam(values);
    HostAnswer answer{factor->error(theirs), {}};
    const gtsam::VectorValues gradient = factor->linearize(theirs)->gradientAtZero();
    for (std::size_t k = 0; k < keys.size(); ++k) {
      std::vector<double> x(slots[k]->ambient);
      slots[k]->read(theirs, keys[k], x.data());
      append_in_our_tangent(*slots[k], x.data(), gradient.at(keys[k]), answer.gradient);
    }
    return answer;
  };
}

TEST(GtsamEveryFactor, CostAndGradientAreHoldfasts) { expect_every_factor_agrees(in_gtsam); }

}  // namespace
}  // namespace holdfast::testing
