// Every factor × variable types × loss as a factor of GTSAM.
#include <holdfast/adapters/gtsam.hpp>

#include "hosts.hpp"

namespace holdfast::testing {
namespace {

HostEvaluator in_gtsam(const HostDraw& draw, const Loss& loss, double weight) {
  const Term term = draw.term(loss, weight);
  std::vector<GtsamFactor::Variable> variables;
  gtsam::KeyVector keys;
  for (std::size_t k = 0; k < draw.keys.size(); ++k) {
    variables.push_back({holdfast::detail::gtsam_slot(term.batch().types()[k]), {}, {}});
    keys.push_back(gtsam_key(draw.keys[k]));
  }
  const auto factor = std::make_shared<GtsamFactor>(term, variables, keys);
  return [factor, variables, keys](const Values& values) {
    const gtsam::Values theirs = to_gtsam(values);
    HostAnswer answer{factor->error(theirs), {}};
    const auto linear = factor->linearize(theirs);
    const gtsam::VectorValues gradient = linear->gradientAtZero();
    for (std::size_t k = 0; k < keys.size(); ++k) {  // g_theirs = Dᵀ g_ours
      const int n = variables[k].slot->dim;
      std::vector<double> x(variables[k].slot->ambient);
      Eigen::MatrixXd D(n, n);
      variables[k].slot->read(theirs, keys[k], x.data());
      variables[k].slot->tangent(x.data(), D.data());
      const Eigen::VectorXd ours = D.transpose().partialPivLu().solve(gradient.at(keys[k]));
      answer.gradient.insert(answer.gradient.end(), ours.data(), ours.data() + n);
    }
    return answer;
  };
}

TEST(GtsamEveryFactor, CostAndGradientAreHoldfasts) { expect_every_factor_agrees(in_gtsam); }

}  // namespace
}  // namespace holdfast::testing
