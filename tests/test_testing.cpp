// The tools of testing.hpp, each with something that is broken on purpose.
#include <gmock/gmock.h>

#include <holdfast/solvers/gnc.hpp>
#include <holdfast/solvers/irls/irls.hpp>
#include <holdfast/testing/backend.hpp>
#include <holdfast/testing/factor.hpp>
#include <holdfast/testing/variable.hpp>

namespace holdfast::testing {
namespace {

using ::testing::HasSubstr;

/// sin x, with a Jacobian that can be spoilt.
struct Sine {
  double slope_error;
  bool forgets;
  using Variables = variables<Scalar>;
  static constexpr int residual_dim = 1;
  Vector<1> operator()(const Scalar& x, Jacobians<Sine>* J = nullptr) const {
    if (J != nullptr && !forgets) J->all(0, 0) = std::cos(x.value) + slope_error;
    return Vector<1>(std::sin(x.value));
  }
};

TEST(JacobianError, FindsWrongAndMissingEntries) {
  EXPECT_LT(jacobian_error(Sine{0, false}, Scalar(0.7)), 1e-11);
  EXPECT_NEAR(jacobian_error(Sine{1e-5, false}, Scalar(0.7)), 1e-5 / (1 + std::cos(0.7)), 1e-9);
  EXPECT_EQ(jacobian_error(Sine{0, true}, Scalar(0.7)), std::numeric_limits<double>::infinity());
}

// ---- check_factor

/// (x² + y²) / 2 in one row; what is wrong about it can be chosen.
struct Bowl {
  enum class Fault { none, jacobian, unwritten, other_residual, nan, hessian, refuses } fault = Fault::none;
  using Variables = variables<Scalar, Scalar>;
  static constexpr int residual_dim = 1;
  static const char* name() { return "Bowl"; }
  Vector<1> operator()(const Scalar& x, const Scalar& y, Jacobians<Bowl>* J = nullptr) const {
    double r = (x.value * x.value + y.value * y.value) / 2;
    if (J != nullptr) {
      J->all(0, 0) = x.value;
      if (fault != Fault::unwritten) J->all(0, 1) = fault == Fault::jacobian ? 1.001 * y.value : y.value;
      if (fault == Fault::other_residual) r += 1e-9;
    }
    return Vector<1>(fault == Fault::nan ? NAN : r);
  }
  /// Of ½ r²: r I + ∇r ∇rᵀ.
  Matrix<2, 2> hessian(const Scalar& x, const Scalar& y) const {
    const Vector<2> g(x.value, y.value);
    const double r = g.squaredNorm() / 2;
    return (fault == Fault::hessian ? 0.5 * r : r) * Matrix<2, 2>::Identity() + g * g.transpose();
  }
  void validate() const {
    if (fault == Fault::refuses) throw BadNumber("Bowl.fault must be another one");
  }
};

TEST(CheckFactor, PassesAGoodOneAndSaysWhatIsWrongWithOthers) {
  EXPECT_EQ(check_factor(Bowl{}), "");
  EXPECT_EQ(check_factor(Range<Pose2, Point2>{12.3, 0.5}), "");
  EXPECT_EQ(check_factor_at(Range<Pose2, Point2>{12.3, 0.5}, Pose2(1, 2, 3), Point2(4, 5)), "");
  EXPECT_THAT(check_factor(Bowl{Bowl::Fault::jacobian}), HasSubstr("Bowl: d r[0] / d variable 1, component 0 is "));
  EXPECT_THAT(check_factor(Bowl{Bowl::Fault::unwritten}), HasSubstr("d r[0] / d variable 1, component 0 is not written"));
  EXPECT_THAT(check_factor(Bowl{Bowl::Fault::other_residual}), HasSubstr("with a Jacobian and"));
  EXPECT_THAT(check_factor(Bowl{Bowl::Fault::nan}), HasSubstr("the residual is not finite"));
  EXPECT_THAT(check_factor(Bowl{Bowl::Fault::hessian}), HasSubstr("second differences of ½‖r‖² say"));
  EXPECT_THAT(check_factor(Bowl{Bowl::Fault::refuses}), HasSubstr("validate() refuses it: Bowl.fault must be another one"));
}

/// cos x, which says of itself what it is not.
template <bool Linear, bool Convex>
struct Boaster {
  static constexpr bool is_linear = Linear, is_convex = Convex;
  using Variables = variables<Scalar>;
  static constexpr int residual_dim = 1;
  Vector<1> operator()(const Scalar& x, Jacobians<Boaster>* J = nullptr) const {
    if (J != nullptr) J->all(0, 0) = -std::sin(x.value);
    return Vector<1>(std::cos(x.value));
  }
};

TEST(CheckFactor, SeesThroughFalseClaims) {
  EXPECT_EQ(check_factor(Boaster<false, false>{}), "");
  EXPECT_THAT(check_factor(Boaster<true, false>{}), HasSubstr("is_linear, but moved by"));
  EXPECT_THAT(check_factor(Boaster<false, true>{}), HasSubstr("is_convex, but moved by"));
}

// ---- check_variable

/// A point on a line that steps the wrong way back, or too far, or does not add.
template <int Fault>
struct Line {
  static constexpr int dim = 1, space_dim = 1;
  static constexpr bool is_vector_space = true;
  double x = 0;
  static const char* name() { return "Line"; }
  Line retract(const Vector<1>& delta) const {
    if (Fault == 1) return Line{x + 1.01 * delta[0]};
    if (Fault == 2) return Line{x + delta[0] + 1e-3};
    return Line{x + delta[0]};
  }
  Vector<1> local(const Line& other) const { return Vector<1>(other.x - x); }
  bool is_finite() const { return Fault == 3 || std::isfinite(x); }
  Vector<1> position() const { return Vector<1>(x); }
  static Matrix<1, 1> position_jacobian() { return Matrix<1, 1>::Constant(Fault == 4 ? 2 : 1); }
  Matrix<1, 1> local_jacobian(const Line&) const { return Matrix<1, 1>::Constant(Fault == 5 ? -1 : 1); }
};

TEST(CheckVariable, PassesAGoodOneAndSaysWhatIsWrongWithOthers) {
  EXPECT_EQ(check_variable<Pose2>(), "");
  EXPECT_EQ(check_variable<Pose3>(), "");
  EXPECT_EQ(check_variable<Motion3>(), "");
  EXPECT_EQ(check_variable<Scalar>(), "");
  EXPECT_EQ(check_variable<Line<0>>(), "");
  EXPECT_THAT(check_variable<Line<1>>(), HasSubstr("x.local(x.retract(delta)) is not delta"));
  EXPECT_THAT(check_variable<Line<2>>(), HasSubstr("x.retract(0) is not x"));
  EXPECT_THAT(check_variable<Line<3>>(), HasSubstr("is_finite() does not see a NaN"));
  EXPECT_THAT(check_variable<Line<4>>(), HasSubstr("does not move by position_jacobian()"));
  EXPECT_THAT(check_variable<Line<5>>(), HasSubstr("local_jacobian() is not the derivative"));
}

// ---- check_backend

/// irls, spoilt after its work.
class Spoilt final : public Backend {
 public:
  enum class Fault { summary, answer, silence, forgetful, deaf };
  explicit Spoilt(Fault fault) : fault_(fault) {}
  std::string name() const override { return "spoilt"; }

 protected:
  Summary minimize(const Graph& graph, Values& values) override {
    Irls inner;
    inner.options = options;
    if (fault_ == Fault::deaf) inner.options.progress = nullptr;
    Summary summary = inner.solve(graph, values);
    if (fault_ == Fault::summary) summary.cost *= 0.99;
    if (fault_ == Fault::silence) summary.rule = "";
    if (fault_ == Fault::forgetful) summary.culprit.clear();
    if (fault_ == Fault::answer && summary.usable()) {
      const Key key('X', 0);
      values.at<Point2>(key) = Point2(values.at<Point2>(key).value + Vector<2>(0.01 * ++calls_, 0));
    }
    return summary;
  }

 private:
  Fault fault_;
  int calls_ = 0;
};

TEST(CheckBackend, PassesGoodOnesAndSaysWhatIsWrongWithOthers) {
  EXPECT_EQ(check_backend(Irls()), "");
  EXPECT_EQ(check_backend(*gnc(std::make_unique<Irls>())), "");
  EXPECT_THAT(check_backend(Spoilt(Spoilt::Fault::summary)), HasSubstr("a Huber loss with an outlier: the cost is 9.1575, not 9.25"));
  EXPECT_THAT(check_backend(Spoilt(Spoilt::Fault::silence)), HasSubstr("does not say why it stopped"));
  EXPECT_THAT(check_backend(Spoilt(Spoilt::Fault::answer)), HasSubstr("solved again from the same start, the answer has other bits"));
  EXPECT_THAT(check_backend(Spoilt(Spoilt::Fault::forgetful)), HasSubstr("no failure that names the factor"));
  EXPECT_THAT(check_backend(Spoilt(Spoilt::Fault::deaf)), HasSubstr("the progress callback says stop"));
}

}  // namespace
}  // namespace holdfast::testing
