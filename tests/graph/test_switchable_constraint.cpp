#include <gtest/gtest.h>

#include <holdfast/factors/prior.hpp>
#include <holdfast/graph/graph.hpp>
#include <holdfast/graph/switchable_constraint.hpp>
#include <holdfast/graph/variables.hpp>
#include <holdfast/solvers/irls/irls.hpp>

namespace holdfast {
namespace {

// h(ω) = ω² s + Ξ (1 − ω)² over a fine grid of the switch.
TEST(SwitchableConstraint, IsTheLeastCostOverItsSwitch) {
  constexpr double c = 1.5, xi = c * c;
  for (const double s : {0.0, 0.2, 2.25, 30.0, 4000.0}) {
    double least = INFINITY, best = 0;
    for (double w = 0; w <= 1; w += 1e-5) {
      const double h = w * w * s + xi * (1 - w) * (1 - w);
      if (h < least) least = h, best = w;
    }
    const Loss loss = SwitchableConstraint{c};
    EXPECT_NEAR(loss.rho(s).value, least, 1e-6) << s;
    EXPECT_NEAR(SwitchableConstraint{c}.switch_at(s), best, 1e-4) << s;
    EXPECT_NEAR(loss.rho(s).first, best * best, 1e-4) << s;
  }
}

TEST(SwitchableConstraint, HasANameForFiles) {
  register_loss<SwitchableConstraint>();
  EXPECT_EQ(Loss::parse("switchable:2"), Loss(GemanMcClure{2}));
  EXPECT_EQ(Loss::parse("switchable"), Loss(GemanMcClure{1}));
  EXPECT_EQ(Loss::parse("switchable:2:one_sided"), one_sided(GemanMcClure{2}));
  EXPECT_THROW(Loss::parse("switchable:-2"), BadOption);
}

/// As the paper has it, with a variable for the switch: ω (x − z).
struct SwitchedPrior {
  double z = 0;
  using Variables = variables<Scalar, Scalar>;
  static constexpr int residual_dim = 1;
  static constexpr auto fields() { return std::tuple(field("z", &SwitchedPrior::z)); }
  Vector<1> operator()(const Scalar& x, const Scalar& w, Jacobians<SwitchedPrior>* J = nullptr) const {
    if (J != nullptr) J->all << w.value, x.value - z;
    return Vector<1>(w.value * (x.value - z));
  }
  void validate() const {}
};

TEST(SwitchableConstraint, EndsWhereSwitchesAsVariablesEnd) {
  constexpr double c = 1.5;
  const double measured[] = {0.1, -0.2, 0.3, 9.0};  // the last one lies
  constexpr Key x('x', 0);
  const auto prior = [](double z, double sigma) { return Prior<Scalar>::from_sigmas(Scalar(z), Vector<1>(sigma)); };
  Graph with_loss, with_switches;
  Values reduced, joint;
  for (Values* values : {&reduced, &joint}) values->insert(x, Scalar(0.5));
  for (int i = 0; i < 4; ++i) {
    const Key w('w', i);
    with_loss.add(prior(measured[i], 1), {x}, SwitchableConstraint{c});
    joint.insert(w, Scalar(1));
    with_switches.add(SwitchedPrior{measured[i]}, {x, w});
    with_switches.add(prior(1, 1 / c), {w});  // of information Ξ = c²
  }
  Options options;
  options.cost_tolerance = 1e-14;
  options.max_iterations = 1000;
  const Summary a = Irls(options).solve(with_loss, reduced), b = Irls(options).solve(with_switches, joint);
  const double at = reduced.at<Scalar>(x).value;
  EXPECT_NEAR(at, joint.at<Scalar>(x).value, 1e-5);
  EXPECT_NEAR(a.cost, b.cost, 1e-9);
  for (int i = 0; i < 4; ++i) {
    const double r = at - measured[i];
    EXPECT_NEAR(joint.at<Scalar>(Key('w', i)).value, SwitchableConstraint{c}.switch_at(r * r), 1e-5) << i;
  }
}

}  // namespace
}  // namespace holdfast
