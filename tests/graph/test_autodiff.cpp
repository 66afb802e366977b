#include <gtest/gtest.h>

#include <holdfast/factors/between.hpp>
#include <holdfast/factors/range.hpp>
#include <holdfast/graph/autodiff.hpp>
#include <holdfast/testing.hpp>

#include "tests/problems.hpp"

namespace holdfast {
namespace {

using testing::jacobian_error;
using testing::near_identity;
using testing::random_variable;

struct MyRange {
  double distance, sigma;
  using Variables = variables<Pose2, Point2>;
  static constexpr int residual_dim = 1;
  template <class T>
  VectorT<T, 1> residual(const Pose2T<T>& a, const Point2T<T>& b) const {
    using std::sqrt;
    return VectorT<T, 1>((sqrt((a.position() - b.position()).squaredNorm()) - distance) / sigma);
  }
};

/// The translation and the rotation vector of T_a_b, in space.
struct MyBetween {
  using Variables = variables<Pose3, Pose3>;
  static constexpr int residual_dim = 6;
  static const char* name() { return "MyBetween"; }
  template <class T>
  VectorT<T, 6> residual(const Pose3T<T>& a, const Pose3T<T>& b) const {
    const Pose3T<T> T_a_b = a.inverse() * b;
    return Pose3T<T>{}.local(T_a_b);
  }
};

/// One of each kind of variable.
struct MyMixture {
  using Variables = variables<Motion2, Scalar, Pose2>;
  static constexpr int residual_dim = 3;
  template <class T>
  VectorT<T, 3> residual(const Motion2T<T>& x, const ScalarT<T>& s, const Pose2T<T>& y) const {
    using std::exp;
    return VectorT<T, 3>(x.value[1] * s.value, exp(s.value) - y.angle(), (x.derivative(1) - y.p).squaredNorm());
  }
};

TEST(AutoDiff, IsTheHandWrittenFactor) {
  std::mt19937_64 rng(1);
  for (int i = 0; i < 20; ++i) {
    const auto a = random_variable<Pose2>(rng);
    const auto b = random_variable<Point2>(rng);
    Jacobians<AutoDiff<MyRange>> automatic;
    Jacobians<Range<Pose2, Point2>> by_hand;
    const auto r = AutoDiff<MyRange>{{3, 0.5}}(a, b, &automatic);
    EXPECT_NEAR(r[0], (Range<Pose2, Point2>{3, 0.5}(a, b, &by_hand))[0], 1e-13);
    EXPECT_LT((automatic.all - by_hand.all).norm(), 1e-13);
  }
}

TEST(AutoDiff, KnowsTheTangentOfRotations) {
  std::mt19937_64 rng(2);
  const AutoDiff<MyBetween> factor{};
  EXPECT_LT(jacobian_error(factor, Pose3{}, Pose3{}), 1e-9);
  for (int i = 0; i < 10; ++i) {
    EXPECT_LT(jacobian_error(factor, near_identity<Pose3>(rng), near_identity<Pose3>(rng)), 1e-9);
    const auto a = random_variable<Pose3>(rng);
    const Pose3 b = a.retract(testing::random_vector<6>(rng, 0.7));
    EXPECT_LT(jacobian_error(factor, a, b), 1e-8);
    const auto by_hand = Between<Pose3>::from_sigmas(Pose3{}, Vector<6>::Ones());
    Jacobians<AutoDiff<MyBetween>> J;
    Jacobians<Between<Pose3>> K;
    EXPECT_LT((factor(a, b, &J) - by_hand(a, b, &K)).norm(), 1e-12);
    EXPECT_LT((J.all - K.all).norm(), 1e-11);
  }
}

TEST(AutoDiff, MixesAnyVariables) {
  std::mt19937_64 rng(3);
  for (int i = 0; i < 10; ++i) {
    const Pose2 turned = Pose2{}.retract(testing::random_vector<3>(rng, 0.5));  // away from the jump of angle()
    EXPECT_LT(jacobian_error(AutoDiff<MyMixture>{}, random_variable<Motion2>(rng), Scalar(testing::uniform(rng, -1, 1)), turned), 1e-8);
  }
}

TEST(AutoDiff, NamesTheUsersStruct) {
  EXPECT_EQ(factor_name<AutoDiff<MyBetween>>(), "MyBetween");
  EXPECT_NE(factor_name<AutoDiff<MyRange>>().find("MyRange"), std::string::npos);
}

// A user's own struct in a graph, in every back-end.
TEST(AutoDiff, RunsInEveryBackend) {
  constexpr Agent A('A'), L('L');
  for (const std::string& backend : backend_names()) {
    Graph graph;
    Values values;
    values.insert(L(0), Point2(4.5, 5));
    const Pose2 poses[] = {Pose2(0, 0, 0), Pose2(8, 1, 1), Pose2(3, 9, 2)};
    for (int i = 0; i < 3; ++i) {
      values.insert(A(i), poses[i]);
      graph.fix(A(i));
      graph.add(AutoDiff<MyRange>{{(poses[i].p - Vector<2>(4, 3)).norm(), 0.1}}, {A(i), L(0)});
    }
    EXPECT_TRUE(testing::solve(backend, graph, values).usable()) << backend;
    EXPECT_LT((values.at<Point2>(L(0)).value - Vector<2>(4, 3)).norm(), 1e-6) << backend;
  }
}

}  // namespace
}  // namespace holdfast
