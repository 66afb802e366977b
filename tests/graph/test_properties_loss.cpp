// The contract of losses (graph/loss.hpp) at any threshold and any residual.
#include <holdfast/graph/batch.hpp>

#include "tests/problems.hpp"
#include "tests/properties.hpp"

namespace holdfast {
namespace {

using properties::decades;

Loss any_loss() {
  Loss loss = testing::default_loss(*rc::gen::inRange(0, testing::kLossKinds).as("kind"));
  if (loss.kind != Loss::Kind::Squared) loss.scale = decades(-6, 6);
  return loss;
}

RC_GTEST_PROP(LossProperties, TextReadsBackAsTheSameLoss, ()) {
  Loss loss = any_loss();
  loss.per_component = *rc::gen::arbitrary<bool>();
  loss.one_sided = *rc::gen::arbitrary<bool>();
  RC_ASSERT(Loss::parse(loss.str()) == loss);
}

RC_GTEST_PROP(LossProperties, RisesEverMoreSlowlyFromZero, ()) {
  const Loss loss = any_loss();
  const int d = *rc::gen::inRange(1, 7).as("block");
  const double s = decades(-12, 12), more = s * (1 + decades(-3, 3));
  const Rho zero = loss.rho(0, d), here = loss.rho(s, d), there = loss.rho(more, d);
  RC_ASSERT(zero.value == 0);
  RC_ASSERT(here.value >= 0 && here.first >= 0 && here.second <= 0);
  RC_ASSERT(here.first <= zero.first);
  RC_ASSERT(there.value >= here.value * (1 - 1e-14));
  RC_ASSERT(there.first <= here.first * (1 + 1e-14));
  RC_ASSERT(there.value <= (here.value + here.first * (more - s)) * (1 + 1e-13));  // below its tangent: the IRLS model bounds the cost
}

RC_GTEST_PROP(LossProperties, SlopeIsThatOfTheValue, ()) {
  const Loss loss = any_loss();
  const double knee = loss.kind == Loss::Kind::StudentT ? loss.scale : loss.scale * loss.scale, s = knee * decades(-4, 3);
  RC_PRE(std::abs(s / knee - 1) > 1e-3);  // away from the knee
  const double h = 1e-5 * s;
  const double numeric = (loss.rho(s + h, 2).value - loss.rho(s - h, 2).value) / (2 * h);
  const Rho here = loss.rho(s, 2);
  RC_ASSERT(std::abs(numeric - here.first) <= 1e-8 * here.first + 1e-9 * here.value / s);
}

RC_GTEST_PROP(LossProperties, WeighsEveryModelPositively, ()) {
  Loss loss = any_loss();
  loss.per_component = *rc::gen::arbitrary<bool>();
  loss.one_sided = loss.per_component && *rc::gen::arbitrary<bool>();
  std::mt19937_64 rng = properties::any_rng();
  const Vector<3> r = testing::random_vector<3>(rng, decades(-6, 6));
  for (const Curvature curvature : {Curvature::irls, Curvature::newton, Curvature::bound}) {
    Vector<3> gradient, hessian;
    const TermWeight w = row_weights<3>(loss, 2.5, r.data(), 3, curvature, gradient.data(), hessian.data());
    RC_ASSERT((gradient.array() >= 0).all() && (hessian.array() >= 0).all() && w.cost >= 0);
    RC_ASSERT(hessian.minCoeff() + w.rank_one * r.squaredNorm() >= -1e-12 * hessian.maxCoeff());  // H stays positive semidefinite
  }
}

}  // namespace
}  // namespace holdfast
