#include <gtest/gtest.h>

#include <cmath>
#include <holdfast/graph/error.hpp>
#include <holdfast/solvers/chi_square.hpp>

namespace holdfast {
namespace {

// The tables of textbooks.
TEST(ChiSquare, QuantilesAreThoseOfTheTables) {
  const struct {
    int d;
    double at_95, at_99;
  } tables[] = {{1, 3.841, 6.635},   {2, 5.991, 9.210},   {3, 7.815, 11.345},  {4, 9.488, 13.277},
                {5, 11.070, 15.086}, {6, 12.592, 16.812}, {10, 18.307, 23.209}};
  for (const auto& row : tables) {
    EXPECT_NEAR(chi_square_quantile(0.95, row.d), row.at_95, 6e-4) << row.d;
    EXPECT_NEAR(chi_square_quantile(0.99, row.d), row.at_99, 6e-4) << row.d;
  }
}

TEST(ChiSquare, TailUndoesTheQuantile) {
  for (int d = 1; d <= 12; ++d)
    for (const double p : {1e-6, 0.1, 0.5, 0.9, 0.9999})
      EXPECT_NEAR(chi_square_tail(chi_square_quantile(p, d), d), 1 - p, 1e-12) << d << " " << p;
}

TEST(ChiSquare, IsExponentialOfTwoAndNormalOfOne) {
  EXPECT_DOUBLE_EQ(chi_square_tail(3, 2), std::exp(-1.5));
  EXPECT_NEAR(chi_square_tail(4, 1), 0.0455002638963584, 1e-15);  // beyond two sigmas
  EXPECT_EQ(chi_square_tail(0, 3), 1);
  EXPECT_EQ(chi_square_tail(1e6, 3), 0);
}

TEST(ChiSquare, RefusesWhatIsNoProbability) {
  EXPECT_THROW(chi_square_quantile(0, 3), BadOption);
  EXPECT_THROW(chi_square_quantile(1, 3), BadOption);
  EXPECT_THROW(chi_square_quantile(NAN, 3), BadOption);
  EXPECT_THROW(chi_square_tail(1, 0), BadOption);
}

}  // namespace
}  // namespace holdfast
