#include <gtest/gtest.h>

#include <Eigen/LU>
#include <holdfast/factors/whitening.hpp>
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

TEST(Whitening, NamesWhatIsWrongWithAMatrix) {
  const Matrix<2, 2> indefinite = (Matrix<2, 2>() << 1, 2, 2, 1).finished();
  const std::string text = message_of([&] { sqrt_information_from_information<2>(indefinite, "Between.information"); });
  EXPECT_NE(text.find("Between.information has the eigenvalue -"), std::string::npos) << text;
  EXPECT_NE(text.find("positive definite"), std::string::npos) << text;
  const Matrix<2, 2> lopsided = (Matrix<2, 2>() << 1, 0.5, 0, 1).finished();
  const std::string where = message_of([&] { sqrt_information_from_covariance<2>(lopsided); });
  EXPECT_NE(where.find("symmetric"), std::string::npos) << where;
}

TEST(Whitening, RefusesSingularAndNonFiniteMatrices) {
  const Matrix<3, 3> flat = Vector<3>(1, 2, 3) * Vector<3>(1, 2, 3).transpose();  // rank one
  EXPECT_THROW(sqrt_information_from_covariance<3>(flat), BadNumber);
  EXPECT_THROW(sqrt_information_from_information<3>(flat), BadNumber);
  EXPECT_THROW(symmetric_sqrt_information_from_covariance<3>(flat), BadNumber);
  EXPECT_THROW(sqrt_information_from_covariance<3>(Matrix<3, 3>::Zero()), BadNumber);
  EXPECT_THROW(sqrt_information_from_covariance<3>(Matrix<3, 3>::Constant(NAN)), BadNumber);
  EXPECT_THROW((sqrt_information_from_sigmas<2>({1, -1})), BadNumber);
  EXPECT_THROW((sqrt_information_from_sigmas<2>({1, INFINITY})), BadNumber);
}

}  // namespace
}  // namespace holdfast
