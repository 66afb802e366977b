#include <gtest/gtest.h>

#include <holdfast/graph/dynamic_covariance_scaling.hpp>
#include <holdfast/testing/loss.hpp>

namespace holdfast {
namespace {

TEST(DynamicCovarianceScaling, InNumbers) {
  const Loss loss = DynamicCovarianceScaling{2};  // Φ = 4
  EXPECT_DOUBLE_EQ(loss.rho(3).value, 3);
  EXPECT_DOUBLE_EQ(loss.rho(3).first, 1);
  EXPECT_DOUBLE_EQ(loss.rho(12).value, 8);     // 4 (36 − 4)/16
  EXPECT_DOUBLE_EQ(loss.rho(12).first, 0.25);  // the scaling is 8/16
  EXPECT_DOUBLE_EQ(loss.rho(12).second, -1.0 / 32);
  EXPECT_NEAR(loss.rho(1e12).value, 12, 1e-9);  // 3Φ
}

TEST(DynamicCovarianceScaling, WeighsByTheSquareOfThePublishedScaling) {
  constexpr double c = 1.7, phi = c * c;
  for (const double s : {0.1, 2.8, 2.9, 9.0, 100.0, 1e6}) {
    const double scaling = std::min(1.0, 2 * phi / (phi + s));
    EXPECT_NEAR(DynamicCovarianceScaling{c}.rho(s).first, scaling * scaling, 1e-14) << s;
  }
}

TEST(DynamicCovarianceScaling, KeepsTheContractOfALoss) {
  for (const double c : {0.3, 1.0, 4.0}) EXPECT_EQ(testing::check_loss(DynamicCovarianceScaling{c}), "") << c;
}

TEST(DynamicCovarianceScaling, IsHuberWhereItIsToBeConvex) {
  const Loss loss = DynamicCovarianceScaling{2};
  EXPECT_FALSE(loss.is_convex());
  EXPECT_EQ(loss.relaxed(), Loss(Huber{2}));
}

TEST(DynamicCovarianceScaling, HasANameForFilesAndARuleForItsThreshold) {
  register_loss<DynamicCovarianceScaling>();
  EXPECT_EQ(Loss::parse("dcs"), Loss(DynamicCovarianceScaling{1}));
  EXPECT_EQ(Loss::parse("dcs:2.5:component"), per_component(DynamicCovarianceScaling{2.5}));
  EXPECT_EQ(Loss(DynamicCovarianceScaling{2.5}).str(), "dcs:2.5");
  for (const double bad : {0.0, -1.0, static_cast<double>(NAN), static_cast<double>(INFINITY)})
    EXPECT_THROW(Loss(DynamicCovarianceScaling{bad}).validate(1), BadNumber) << bad;
}

}  // namespace
}  // namespace holdfast
