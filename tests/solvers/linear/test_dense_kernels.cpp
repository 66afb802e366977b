// The dense kernels against Eigen's Cholesky, for every shape of remainder.
#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <holdfast/solvers/linear/internal/dense_kernels.hpp>
#include <random>
#include <vector>

namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;
namespace dense = holdfast::dense;

MatrixXd random_positive(int n, unsigned seed) {
  std::mt19937_64 rng(seed);
  std::normal_distribution<double> normal;
  const MatrixXd R = MatrixXd::NullaryExpr(n, n, [&] { return normal(rng); });
  return R * R.transpose() + n * MatrixXd::Identity(n, n);
}

struct Front {
  int n, k, ld;
  std::vector<double> panel;

  Front(const MatrixXd& H, int columns)
      : n(static_cast<int>(H.rows())), k(columns), ld(dense::leading_dimension(n)), panel(ld * k + 16, 0.0) {
    for (int j = 0; j < k; ++j)
      for (int i = j; i < n; ++i) panel[i + j * ld] = H(i, j);
  }
};

TEST(DenseKernels, PartialFactorAndUpdateAreThoseOfTheWholeCholesky) {
  for (int n = 1; n <= 45; ++n)
    for (int k : {1, 2, 3, 4, 5, 7, 16, 31, 32, 33, 36, 45}) {
      if (k > n) continue;
      const MatrixXd H = random_positive(n, 100 * n + k);
      const MatrixXd L = H.llt().matrixL();
      Front front(H, k);
      ASSERT_TRUE(dense::factor_panel(n, k, front.panel.data(), front.ld));
      for (int j = 0; j < k; ++j)
        for (int i = j; i < n; ++i) ASSERT_NEAR(front.panel[i + j * front.ld], L(i, j), 1e-12 * n) << n << ' ' << k << ' ' << i << ' ' << j;

      const int m = n - k;
      if (m == 0) continue;
      const int ldc = dense::leading_dimension(m);
      std::vector<double> update(ldc * m + 16, NAN);  // what it writes must not depend on what was there
      dense::negative_outer(m, k, front.panel.data() + k, front.ld, update.data(), ldc, 0, m);
      const MatrixXd expected = L.block(k, 0, m, k) * L.block(k, 0, m, k).transpose();
      for (int j = 0; j < m; ++j)
        for (int i = j; i < m; ++i) ASSERT_NEAR(update[i + j * ldc], -expected(i, j), 1e-12 * n) << n << ' ' << k << ' ' << i << ' ' << j;
    }
}

TEST(DenseKernels, ProductsAreThoseOfMatrices) {
  std::mt19937_64 rng(5);
  std::normal_distribution<double> normal;
  const auto random = [&](int rows, int columns) { return MatrixXd(MatrixXd::NullaryExpr(rows, columns, [&] { return normal(rng); })); };
  for (int m = 1; m <= 18; ++m)
    for (int n = 1; n <= 9; ++n)
      for (int k : {1, 3, 8, 17}) {
        const int ld = dense::leading_dimension(m);
        MatrixXd A = MatrixXd::Constant(ld, k + 1, 7), C = MatrixXd::Constant(ld, n + 1, NAN);
        A.topLeftCorner(m, k) = random(m, k);
        const MatrixXd B = random(n, k);
        dense::negative_product(m, n, k, A.data(), ld, B.data(), n, C.data(), ld);
        EXPECT_LT((C.topLeftCorner(m, n) + A.topLeftCorner(m, k) * B.transpose()).norm(), 1e-12 * m * n) << m << ' ' << n << ' ' << k;
      }
}

TEST(DenseKernels, SharedColumnsGiveTheBitsOfOneCall) {
  const int n = 150, k = 20, m = n - k, ldc = dense::leading_dimension(m);
  Front front(random_positive(n, 7), k);
  ASSERT_TRUE(dense::factor_panel(n, k, front.panel.data(), front.ld));
  std::vector<double> whole(ldc * m + 16), parts(ldc * m + 16);
  dense::negative_outer(m, k, front.panel.data() + k, front.ld, whole.data(), ldc, 0, m);
  for (int first = 0; first < m; first += 64)
    dense::negative_outer(m, k, front.panel.data() + k, front.ld, parts.data(), ldc, first, std::min(m, first + 64));
  for (int j = 0; j < m; ++j)
    for (int i = j; i < m; ++i) ASSERT_EQ(whole[i + j * ldc], parts[i + j * ldc]);
}

TEST(DenseKernels, TriangularSolvesInvertTheFactor) {
  for (int n : {1, 2, 3, 4, 5, 8, 13, 30, 41}) {
    const MatrixXd H = random_positive(n, n);
    Front front(H, n);
    ASSERT_TRUE(dense::factor_panel(n, n, front.panel.data(), front.ld));
    const VectorXd x = VectorXd::LinSpaced(n, -1, 2);
    VectorXd b = H * x;
    dense::forward(n, n, front.panel.data(), front.ld, b.data());
    dense::backward(n, n, front.panel.data(), front.ld, b.data());
    EXPECT_LT((b - x).norm(), 1e-11 * n) << n;
  }
}

TEST(DenseKernels, AMatrixThatIsNotPositiveDefiniteIsRefused) {
  for (int bad : {0, 3, 40}) {
    MatrixXd H = random_positive(50, 3);
    H(bad, bad) = -1;
    EXPECT_FALSE(dense::factor_panel(50, 50, Front(H, 50).panel.data(), dense::leading_dimension(50)));
    H(bad, bad) = NAN;
    EXPECT_FALSE(dense::factor_panel(50, 50, Front(H, 50).panel.data(), dense::leading_dimension(50)));
  }
}

}  // namespace
