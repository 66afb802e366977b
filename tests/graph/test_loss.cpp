#include <gtest/gtest.h>

#include <holdfast/factors/prior.hpp>

#include "tests/problems.hpp"

namespace holdfast {
namespace {

using testing::default_loss;
using testing::kLossKinds;
using testing::reference_rho;
using testing::reference_slope;

constexpr double kFractions[] = {1e-3, 0.1, 0.5, 0.9, 1.1, 2, 10, 1000};  // of the squared threshold: both branches

/// fn(loss, block size) for every kind, three thresholds, two block sizes.
template <class Fn>
void for_each_loss(const Fn& fn) {
  for (int kind = 0; kind < kLossKinds; ++kind)
    for (const double factor : {0.3, 1.0, 4.0})
      for (const int d : {1, 3}) {
        Loss loss = default_loss(kind);
        loss.scale *= factor;
        SCOPED_TRACE(loss.str() + " of " + std::to_string(d));
        fn(loss, d);
      }
}

double slope_at_zero(const Loss& loss, int d) {
  if (loss.kind == Loss::Kind::Absolute) return 1 / loss.scale;
  if (loss.kind == Loss::Kind::StudentT) return (loss.scale + d) / loss.scale;
  return 1;
}

TEST(Loss, IsItsFormula) {
  for_each_loss([](const Loss& loss, int d) {
    for (const double fraction : kFractions) {
      const double s = fraction * loss.scale * loss.scale;
      EXPECT_NEAR(loss.rho(s, d).value / reference_rho(loss, s, d), 1, 1e-12) << s;
      EXPECT_NEAR(loss.rho(s, d).first, reference_slope(loss, s, d), 1e-12 * slope_at_zero(loss, d)) << s;
    }
  });
}

TEST(Loss, StartsAtZeroWithTheStatedSlope) {
  for_each_loss([](const Loss& loss, int d) {
    const Rho zero = loss.rho(0, d);
    EXPECT_EQ(zero.value, 0);
    EXPECT_DOUBLE_EQ(zero.first, slope_at_zero(loss, d));
    for (const double s : {1e-20, 1e-12})  // no cancellation near zero
      EXPECT_NEAR(loss.rho(s, d).value / s, zero.first, 1e-7 * zero.first) << s;
  });
}

TEST(Loss, DerivativesAreThoseOfTheValue) {
  for_each_loss([](const Loss& loss, int d) {
    for (const double fraction : kFractions) {
      const double s = fraction * loss.scale * loss.scale, h = 1e-5 * s;
      const Rho here = loss.rho(s, d), up = loss.rho(s + h, d), down = loss.rho(s - h, d);
      const double steepness = slope_at_zero(loss, d);
      EXPECT_NEAR(here.first, (up.value - down.value) / (2 * h), 1e-7 * steepness) << s;
      EXPECT_NEAR(here.second, (up.first - down.first) / (2 * h), 1e-7 * steepness / s) << s;
    }
  });
}

TEST(Loss, RisesAndIsConcave) {
  for_each_loss([](const Loss& loss, int d) {
    Rho before = loss.rho(0, d);
    for (double s = 1e-6; s < 1e6; s *= 1.3) {
      const Rho rho = loss.rho(s, d);
      EXPECT_GE(rho.first, 0) << s;
      EXPECT_LE(rho.second, 0) << s;
      EXPECT_GE(rho.value, before.value) << s;
      EXPECT_LE(rho.first, before.first) << s;
      before = rho;
    }
  });
}

TEST(Loss, HasNoJumpAtItsThreshold) {
  for_each_loss([](const Loss& loss, int d) {
    const double c2 = loss.scale * loss.scale;
    EXPECT_NEAR(loss.rho(c2 * (1 + 1e-12), d).value, loss.rho(c2 * (1 - 1e-12), d).value, 1e-9 * c2 * slope_at_zero(loss, d));
  });
}

TEST(Loss, StaysFiniteForEnormousResiduals) {
  for_each_loss([](const Loss& loss, int d) {
    for (const double s : {1e100, 1e200, 1e290}) {
      const Rho rho = loss.rho(s, d);
      EXPECT_TRUE(std::isfinite(rho.value) && std::isfinite(rho.first) && std::isfinite(rho.second)) << s;
    }
  });
}

TEST(Loss, LetsANonFiniteResidualThrough) {
  for (const Loss& loss : {Loss(Squared{}), Loss(Absolute{}), Loss(Huber{}), Loss(PseudoHuber{}), Loss(Cauchy{})})
    EXPECT_FALSE(std::isfinite(loss.rho(NAN).value)) << loss.str();
}

TEST(Loss, BoundedOnesLevelOut) {
  EXPECT_NEAR(Loss(GemanMcClure{3}).rho(1e12).value, 9, 1e-9);
  EXPECT_NEAR(Loss(Welsch{3}).rho(1e12).value, 9, 1e-9);
  EXPECT_DOUBLE_EQ(Loss(Tukey{3}).rho(1e12).value, 3);
  EXPECT_DOUBLE_EQ(Loss(TruncatedSquares{3}).rho(1e12).value, 9);
}

TEST(Loss, OneSidedIsSquaredWhereThePredictionIsTooLong) {
  for (int kind = 0; kind < kLossKinds; ++kind) {
    const Loss loss = one_sided(default_loss(kind));
    for (const double r : {0.1, 1.0, 30.0}) {
      EXPECT_DOUBLE_EQ(loss.rho_of_component(r).value, r * r);
      EXPECT_EQ(loss.rho_of_component(r).first, 1);
      EXPECT_EQ(loss.rho_of_component(r).second, 0);
      EXPECT_DOUBLE_EQ(loss.rho_of_component(-r).value, default_loss(kind).rho(r * r).value);
    }
  }
}

// A block of components costs ρ(‖r‖²), its components one by one Σ ρ(r_c²).
TEST(Loss, PerComponentAddsUpOverTheComponents) {
  constexpr Key a('A', 0);
  const auto prior = Prior<Point2>::from_sigmas(Point2(0, 0), Vector<2>(1, 1));
  Values values;
  values.insert(a, Point2(3, -1));
  for (int kind = 0; kind < kLossKinds; ++kind) {
    const Loss loss = default_loss(kind);
    const auto cost = [&](const Loss& chosen) {
      Graph graph;
      graph.add(prior, {a}, chosen, 0.7);
      return graph.cost(values);
    };
    EXPECT_NEAR(cost(loss), 0.35 * reference_rho(loss, 10, 2), 1e-12) << loss.str();
    EXPECT_NEAR(cost(per_component(loss)), 0.35 * (reference_rho(loss, 9, 1) + reference_rho(loss, 1, 1)), 1e-12) << loss.str();
    EXPECT_NEAR(cost(one_sided(per_component(loss))), 0.35 * (9 + reference_rho(loss, 1, 1)), 1e-12) << loss.str();
  }
}

// exp(−½ρ) is Student's density up to a constant: its integral over the line is that of the normalised density.
TEST(Loss, StudentTIsTheLikelihood) {
  const double nu = 3;
  double integral = 0;
  for (double r = -2000; r < 2000; r += 0.01) integral += 0.01 * std::exp(-0.5 * Loss(StudentT{nu}).rho(r * r).value);
  EXPECT_NEAR(integral, std::sqrt(nu * kPi) * std::tgamma(nu / 2) / std::tgamma((nu + 1) / 2), 1e-6);
}

TEST(LossText, IsReadBack) {
  for (int kind = 0; kind < kLossKinds; ++kind)
    for (const bool component : {false, true})
      for (const bool sided : {false, true}) {
        Loss loss = default_loss(kind);
        loss.per_component = component;
        loss.one_sided = sided;
        EXPECT_EQ(Loss::parse(loss.str()), loss) << loss.str();
      }
}

TEST(LossText, HoldsEveryDigitOfTheThreshold) {
  for (const double a : {1.0 / 3, 1.345678901234, 1e-7 / 3, 123456789.123})
    EXPECT_EQ(Loss::parse(Loss(Huber{a}).str()), Loss(Huber{a})) << Loss(Huber{a}).str();
}

TEST(LossText, IsWhatUsersWrite) {
  EXPECT_EQ(Loss::parse("squared"), Loss(Squared{}));
  EXPECT_EQ(Loss::parse("huber"), Loss(Huber{}));
  EXPECT_EQ(Loss::parse("huber:1.5"), Loss(Huber{1.5}));
  EXPECT_EQ(Loss::parse("student_t:3:component"), per_component(StudentT{3}));
  EXPECT_EQ(Loss::parse("tukey:4.685:one_sided"), one_sided(Tukey{4.685}));
  EXPECT_EQ(Loss::parse("cauchy:component:one_sided"), one_sided(per_component(Cauchy{})));
}

TEST(LossText, RefusesWhatIsNoLoss) {
  for (const char* text : {"", ":", "hubert", "Huber", "huber:-1", "huber:0", "huber:nan", "huber:inf", "huber:2x", "huber:two",
                           "huber:1e999", "cauchy:1e-200", "tukey:1e200", " huber", "huber:2 "})
    EXPECT_THROW(Loss::parse(text), BadOption) << text;
}

// Silently dropping what follows an empty part would change the meaning of the text.
TEST(LossText, RefusesEmptyAndRepeatedParts) {
  for (const char* text : {"huber:", "huber::component", "huber:2:", "huber:2:3", "squared:5"})
    EXPECT_THROW(Loss::parse(text), BadOption) << text;
}

TEST(LossText, ErrorListsTheNames) {
  try {
    Loss::parse("hubert:2");
    FAIL();
  } catch (const BadOption& error) {
    EXPECT_NE(std::string(error.what()).find("hubert:2"), std::string::npos);
    for (int kind = 0; kind < kLossKinds; ++kind) {
      Loss loss = default_loss(kind);
      const std::string text = loss.str();
      EXPECT_NE(std::string(error.what()).find(text.substr(0, text.find(':'))), std::string::npos);
    }
  }
}

TEST(LossRules, ThresholdIsPositive) {
  for (const double scale : {0.0, -1.0, static_cast<double>(NAN), static_cast<double>(INFINITY), 1e-200, 1e200}) {  // the last: no square
    EXPECT_THROW(Loss(Huber{scale}).validate(1), BadNumber) << scale;
    EXPECT_THROW(Loss(StudentT{scale}).validate(1), BadNumber) << scale;
  }
}

TEST(LossRules, OneSidedNeedsASign) {
  EXPECT_THROW(one_sided(Huber{}).validate(2), BadOption);
  EXPECT_NO_THROW(one_sided(Huber{}).validate(1));
  EXPECT_NO_THROW(one_sided(per_component(Huber{})).validate(2));
}

}  // namespace
}  // namespace holdfast
