#include <gtest/gtest.h>

#include <Eigen/LU>
#include <holdfast/factors/whitening.hpp>
#include <holdfast/graph/variables/so3.hpp>
#include <holdfast/testing.hpp>

namespace holdfast {
namespace {

using testing::random_covariance;

template <class Action>
std::string message_of(Action action) {
  try {
    action();
  } catch (const BadNumber& error) {
    return error.what();
  }
  return "";
}

TEST(Whitening, TurnsTheCovarianceIntoTheIdentity) {
  std::mt19937_64 rng(1);
  for (int i = 0; i < 20; ++i) {
    const Matrix<6, 6> S = random_covariance<6>(rng);
    const auto W = sqrt_information_from_covariance<6>(S);
    const auto symmetric = symmetric_sqrt_information_from_covariance<6>(S);
    EXPECT_TRUE((W * S * W.transpose()).isIdentity(1e-12));
    EXPECT_TRUE((symmetric * S * symmetric).isIdentity(1e-12));
    EXPECT_TRUE(symmetric.isApprox(symmetric.transpose(), 1e-13));
  }
}

TEST(Whitening, IsTheSameFromCovarianceAndInformation) {
  std::mt19937_64 rng(2);
  const Matrix<4, 4> S = random_covariance<4>(rng);
  const auto W = sqrt_information_from_covariance<4>(S);
  EXPECT_TRUE(W.isUpperTriangular(0));
  EXPECT_TRUE(W.isApprox(sqrt_information_from_information<4>(S.inverse()), 1e-11));
}

TEST(Whitening, OfADiagonalIsOneOverSigma) {
  const Matrix<2, 2> expected = Vector<2>(0.5, 0.25).asDiagonal();
  EXPECT_TRUE(sqrt_information_from_sigmas<2>({2, 4}).isApprox(expected));
  EXPECT_TRUE(sqrt_information_from_covariance<2>(Vector<2>(4, 16).asDiagonal()).isApprox(expected));
  EXPECT_TRUE(symmetric_sqrt_information_from_covariance<2>(Vector<2>(4, 16).asDiagonal()).isApprox(expected));
}

TEST(Whitening, DoesNotMindUnits) {
  const Vector<2> units(1e-9, 1e9);
  const Matrix<2, 2> S = units.asDiagonal() * (Matrix<2, 2>() << 2, 1, 1, 2).finished() * units.asDiagonal();
  const auto W = sqrt_information_from_covariance<2>(S);
  EXPECT_TRUE((W * S * W.transpose()).isIdentity(1e-14));
}

// ---- information that says nothing of some directions

/// No entry of Wᵀ W is off by more than `tolerance` of what its two diagonal entries allow.
template <int N>
void expect_root(const Matrix<N, N>& W, const Matrix<N, N>& information, double tolerance) {
  const Matrix<N, N> difference = W.transpose() * W - information;
  for (int i = 0; i < N; ++i)
    for (int j = 0; j < N; ++j)
      EXPECT_LE(std::abs(difference(i, j)), tolerance * std::sqrt(information(i, i) * information(j, j))) << i << " " << j << "\n" << W;
}

TEST(Whitening, KeepsRowsOfZerosAndTheBitsOfTheRest) {
  std::mt19937_64 rng(3);
  const Matrix<3, 3> position = random_covariance<3>(rng);
  Matrix<6, 6> information = Matrix<6, 6>::Zero();  // of a pose: GPS
  information.topLeftCorner<3, 3>() = position;
  const auto W = sqrt_information_from_information<6>(information);
  EXPECT_TRUE((W.topLeftCorner<3, 3>() == sqrt_information_from_information<3>(position)));
  EXPECT_TRUE(W.rightCols<3>().isZero(0));
  EXPECT_TRUE(W.bottomRows<3>().isZero(0));
  EXPECT_TRUE(sqrt_information_from_information<3>(Matrix<3, 3>::Zero()).isZero(0));
}

TEST(Whitening, OfOneDirectionMeasuresThatDirection) {
  const Vector<3> measured(1, 2, 3);  // information on measuredᵀ x, and on nothing else
  const auto W = sqrt_information_from_information<3>(measured * measured.transpose());
  EXPECT_NEAR((W * Vector<3>(1, 1, 1)).norm(), 6, 1e-14);
  EXPECT_NEAR((W * Vector<3>(3, 0, -1)).norm(), 0, 1e-14);
}

TEST(Whitening, OfLowerRankGivesTheInformationInAnyUnits) {
  std::mt19937_64 rng(4);
  for (int rank = 1; rank < 6; ++rank)
    for (double unit : {1.0, 1e-3, 1e6}) {
      const Eigen::MatrixXd rows = Eigen::MatrixXd::NullaryExpr(rank, 6, [&] { return testing::uniform(rng, -1, 1); });
      const Vector<6> units = (Vector<6>() << 1, 1, 1, unit, unit, unit).finished();
      const Matrix<6, 6> information = units.asDiagonal() * (rows.transpose() * rows) * units.asDiagonal();
      SCOPED_TRACE(std::to_string(rank) + " " + std::to_string(unit));
      expect_root<6>(sqrt_information_from_information<6>(0.5 * (information + information.transpose())), information,
                     // Rows are scaled up to 1e-5 of the largest diagonal entry, these have 1e-12 of it: 6 ε · 1e7.
                     unit > 1e3 ? 1.4e-8 : 1e-13);
    }
}

TEST(Whitening, OfAPlaneThatIsTurnedIsSemidefiniteDespiteRounding) {
  std::mt19937_64 rng(5);
  for (double tilt : {0.0, 1e-12, 1e-9, 1e-8, 1e-6, 1e-3, 0.5, 1.5}) {  // [rad]
    const Matrix<3, 3> R = so3::exp<double>(tilt * testing::random_unit<3>(rng)).toRotationMatrix();
    const Matrix<3, 3> turned = R * Vector<3>(400, 300, 0).asDiagonal() * R.transpose();
    const Matrix<3, 3> information = 0.5 * (turned + turned.transpose());
    const auto W = sqrt_information_from_information<3>(information);
    EXPECT_LT((W.transpose() * W - information).cwiseAbs().maxCoeff(), 1e-6) << tilt;
    EXPECT_LT((W * R.col(2)).norm(), 1e-4) << tilt;
  }
}

TEST(Whitening, SymmetricRootsTooMayBeOfLowerRank) {
  const Matrix<2, 2> information = Vector<2>(3, 4) * Vector<2>(3, 4).transpose();  // eigenvalue 25 along (0.6, 0.8)
  const auto W = symmetric_sqrt_information_from_information<2>(information);
  EXPECT_TRUE(W.isApprox((1.0 / 5 * information).eval(), 1e-14)) << W;
  EXPECT_THROW((symmetric_sqrt_information_from_information<2>(-information)), BadNumber);
}

TEST(Whitening, NamesWhatIsWrongWithAMatrix) {
  const Matrix<2, 2> indefinite = (Matrix<2, 2>() << 1, 2, 2, 1).finished();
  const std::string text = message_of([&] { sqrt_information_from_information<2>(indefinite, "Between.information"); });
  EXPECT_NE(text.find("Between.information has the eigenvalue -"), std::string::npos) << text;
  EXPECT_NE(text.find("positive semidefinite"), std::string::npos) << text;
  const std::string of_covariance = message_of([&] { sqrt_information_from_covariance<2>(indefinite, "Between.covariance"); });
  EXPECT_NE(of_covariance.find("Between.covariance has the eigenvalue -"), std::string::npos) << of_covariance;
  EXPECT_NE(of_covariance.find("positive definite"), std::string::npos) << of_covariance;
  const Matrix<2, 2> lopsided = (Matrix<2, 2>() << 1, 0.5, 0, 1).finished();
  const std::string where = message_of([&] { sqrt_information_from_covariance<2>(lopsided); });
  EXPECT_NE(where.find("symmetric"), std::string::npos) << where;
}

TEST(Whitening, RefusesSingularCovariancesAndNonFiniteMatrices) {
  const Matrix<3, 3> flat = Vector<3>(1, 2, 3) * Vector<3>(1, 2, 3).transpose();  // rank one
  EXPECT_THROW(sqrt_information_from_covariance<3>(flat), BadNumber);
  EXPECT_THROW(symmetric_sqrt_information_from_covariance<3>(flat), BadNumber);
  EXPECT_THROW(sqrt_information_from_covariance<3>(Matrix<3, 3>::Zero()), BadNumber);
  EXPECT_THROW(sqrt_information_from_covariance<3>(Matrix<3, 3>::Constant(NAN)), BadNumber);
  EXPECT_THROW(sqrt_information_from_information<3>(Matrix<3, 3>::Constant(NAN)), BadNumber);
  EXPECT_THROW((sqrt_information_from_sigmas<2>({1, -1})), BadNumber);
  EXPECT_THROW((sqrt_information_from_sigmas<2>({1, INFINITY})), BadNumber);
}

}  // namespace
}  // namespace holdfast
