#include <gtest/gtest.h>

#include <holdfast/graph/max_mixture.hpp>
#include <holdfast/testing/loss.hpp>

namespace holdfast {
namespace {

TEST(MaxMixture, InNumbers) {
  const Loss loss = MaxMixture{10};
  EXPECT_DOUBLE_EQ(loss.rho(4).value, 4);
  // Beyond the knee s/100 + 2 ln 10 + 2 ln 9.
  EXPECT_NEAR(loss.rho(100).value, 1 + 2 * std::log(90.0), 1e-12);
  EXPECT_DOUBLE_EQ(loss.rho(100).first, 0.01);
  EXPECT_NEAR(loss.rho(100, 3).value, 1 + 6 * std::log(10.0) + 2 * std::log(9.0), 1e-12);
  EXPECT_DOUBLE_EQ(one_sided(MaxMixture{10}).rho_of_component(50).value, 2500);
  EXPECT_DOUBLE_EQ(one_sided(MaxMixture{10}).rho_of_component(-50).first, 0.01);
}

TEST(MaxMixture, KeepsTheContractOfALoss) {
  for (const double width : {1.5, 3.0, 10.0, 100.0})
    for (const int d : {1, 2, 6}) {
      testing::LossCheck check;
      check.components = d;
      EXPECT_EQ(testing::check_loss(MaxMixture{width}, check), "") << width << ", " << d;
    }
}

TEST(MaxMixture, IsHuberUpToItsKneeWhereItIsToBeConvex) {
  const double knee = MaxMixture{10}.relaxed().a;
  EXPECT_NEAR(Loss(MaxMixture{10}).rho(knee * knee * 1.0001).first, 0.01, 1e-12);
  EXPECT_DOUBLE_EQ(Loss(MaxMixture{10}).rho(knee * knee * 0.9999).first, 1);
  EXPECT_FALSE(Loss(MaxMixture{10}).is_convex());
}

TEST(MaxMixture, HasANameForFiles) {
  register_loss<MaxMixture>();
  EXPECT_EQ(Loss::parse("max_mixture:5:one_sided"), one_sided(MaxMixture{5}));
  EXPECT_THROW(Loss(MaxMixture{1}).validate(1), BadNumber);
}

}  // namespace
}  // namespace holdfast
