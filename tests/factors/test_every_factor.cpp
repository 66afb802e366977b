// What every factor of the library, on all its variable types, owes to every back-end; and every user's own (HOLDFAST_CONFORMS).
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <Eigen/Eigenvalues>
#include <holdfast/graph/resolved.hpp>
#include <set>

#include "tests/draws.hpp"

namespace holdfast::testing {
namespace {

/// The values around a factor in its own tangent: the variables in the order of its keys, side by side.
class Neighbourhood {
 public:
  Neighbourhood(const Draw& draw, Values at) : at_(std::move(at)) {
    Graph graph;
    draw.add(graph, Squared(), 1);
    resolved_.rebuild(graph, at_);
    for (const Key key : draw.keys)
      for (const Resolved::Variable& v : resolved_.variables())
        for (int c = 0; v.key == key && c < v.dim; ++c) columns_.push_back(v.offset + c);
  }
  int dim() const { return resolved_.tangent_dim(); }
  Values moved(const Eigen::VectorXd& delta) const {
    std::vector<double> step(columns_.size());
    for (std::size_t c = 0; c < columns_.size(); ++c) step[columns_[c]] = delta[static_cast<Eigen::Index>(c)];
    Values to = at_;
    resolved_.retract(at_, step.data(), to);
    return to;
  }

 private:
  Values at_;
  Resolved resolved_;
  std::vector<int> columns_;
};

/// By central differences over two steps, extrapolated: the error is of fourth order in the step.
Eigen::MatrixXd numeric_jacobian(const Draw& draw, const Neighbourhood& around) {
  const auto slope = [&](int column, double h) -> Eigen::VectorXd {
    const Eigen::VectorXd delta = h * Eigen::VectorXd::Unit(around.dim(), column);
    return (draw.residual(around.moved(delta), nullptr) - draw.residual(around.moved(-delta), nullptr)) / (2 * h);
  };
  constexpr double step = 1e-3;
  Eigen::MatrixXd J(draw.residual_dim, around.dim());
  for (int column = 0; column < around.dim(); ++column) J.col(column) = (4 * slope(column, step / 2) - slope(column, step)) / 3;
  return J;
}

void expect_good_citizen(const Draw& draw, const Values& at, std::mt19937_64& rng) {
  const Neighbourhood around(draw, at);
  Eigen::MatrixXd J;
  const Eigen::VectorXd r = draw.residual(at, &J);
  EXPECT_EQ(r, draw.residual(at, nullptr)) << "asked for its Jacobian, it has another residual";
  ASSERT_TRUE(J.allFinite()) << "an entry is not written\n" << J;
  EXPECT_LT((J - numeric_jacobian(draw, around)).cwiseAbs().maxCoeff(), 1e-8 * (1 + J.cwiseAbs().maxCoeff()));

  std::normal_distribution<double> normal(0, 2);
  const Eigen::VectorXd delta = Eigen::VectorXd::NullaryExpr(around.dim(), [&] { return normal(rng); });
  const Eigen::VectorXd there = draw.residual(around.moved(delta), nullptr);
  if (draw.linear) {
    EXPECT_LT((there - r - J * delta).norm(), 1e-10 * (1 + r.norm()));
  }
  if (draw.convex) {  // above every tangent plane
    EXPECT_GE(0.5 * there.squaredNorm(), 0.5 * r.squaredNorm() + r.dot(J * delta) - 1e-9 * (1 + r.squaredNorm()));
  }
}

TEST(EveryFactor, HasTheJacobianOfItsResidualAndIsWhatItSaysOfItself) {
  std::mt19937_64 rng(7);
  for (int instance = 0; instance < 12; ++instance)
    for (const Draw& draw : every_draw(rng)) {
      SCOPED_TRACE(draw.label);
      expect_good_citizen(draw, draw.values(rng), rng);
    }
}

// ---- hessian()

/// By second differences of ½‖r‖² over two steps, extrapolated.
double numeric_hessian(const Draw& draw, const Neighbourhood& around, int i, int j) {
  const auto difference = [&](double h) {
    const Eigen::VectorXd a = h * Eigen::VectorXd::Unit(around.dim(), i), b = h * Eigen::VectorXd::Unit(around.dim(), j);
    const auto f = [&](const Eigen::VectorXd& delta) { return 0.5 * draw.residual(around.moved(delta), nullptr).squaredNorm(); };
    return (f(a + b) - f(a - b) - f(b - a) + f(-a - b)) / (4 * h * h);
  };
  constexpr double step = 4e-3;
  return (4 * difference(step / 2) - difference(step)) / 3;
}

void expect_second_derivative(const Draw& draw, const Values& at) {
  const Neighbourhood around(draw, at);
  const Eigen::MatrixXd H = draw.hessian(at);
  const double scale = 1 + H.cwiseAbs().maxCoeff() + 0.5 * draw.residual(at, nullptr).squaredNorm();
  for (int i = 0; i < around.dim(); ++i)
    for (int j = 0; j <= i; ++j) EXPECT_NEAR(H(i, j), numeric_hessian(draw, around, i, j), 1e-8 * scale) << i << " " << j;
  EXPECT_LT((H - H.transpose()).cwiseAbs().maxCoeff(), 1e-14 * scale);
  if (draw.convex) {
    EXPECT_GE(Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd>(H).eigenvalues()[0], -1e-12 * scale);
  }
}

TEST(EveryFactor, HasTheHessianOfHalfItsSquaredResidual) {
  std::mt19937_64 rng(41);
  int checked = 0;
  for (int instance = 0; instance < 4; ++instance)
    for (const Draw& draw : every_draw(rng)) {
      if (!draw.hessian) continue;
      SCOPED_TRACE(draw.label);
      expect_second_derivative(draw, draw.values(rng));
      ++checked;
    }
  EXPECT_GE(checked, 4 * 22);  // Range and RangeBall on 8 pairs of variables, the others on two
}

// ---- numbers that are none

TEST(EveryFactor, ShowsANonFiniteVariableInItsResidual) {
  std::mt19937_64 rng(3);
  for (const Draw& draw : every_draw(rng)) {
    SCOPED_TRACE(draw.label);
    const Neighbourhood around(draw, draw.values(rng));
    const Eigen::VectorXd nowhere = NAN * Eigen::VectorXd::Ones(around.dim());
    EXPECT_FALSE(std::isfinite(draw.residual(around.moved(nowhere), nullptr).squaredNorm()));
  }
}

/// The factor with one of its numbers not finite: Graph::add throws, naming factor and keys, and the graph stays as it was.
void expect_refused(const Draw& draw, int number, double bad) {
  SCOPED_TRACE(draw.label + ", number " + std::to_string(number) + " = " + std::to_string(bad));
  const std::string name = draw.label.substr(0, draw.label.find(" on"));
  Graph graph;
  try {
    draw.add_spoilt(graph, number, bad);
    ADD_FAILURE() << "it was taken";
  } catch (const BadNumber& error) {
    EXPECT_THAT(error.what(), ::testing::HasSubstr(name + "(" + draw.keys[0].str()));
  }
  EXPECT_EQ(graph.size(), 0u);
}

TEST(EveryFactor, IsRefusedWithANonFiniteNumber) {
  std::mt19937_64 rng(31);
  int refused = 0;
  for (const Draw& draw : every_draw(rng))
    for (int number = 0; draw.validates && number < draw.numbers; ++number)
      for (const double bad : {static_cast<double>(NAN), static_cast<double>(INFINITY), -static_cast<double>(INFINITY)}) {
        expect_refused(draw, number, bad);
        ++refused;
      }
  EXPECT_GT(refused, 1000);
}

// ---- the instances themselves

TEST(EveryFactor, ThatIsOneSidedIsDrawnOnBothSides) {
  std::mt19937_64 rng(1);
  std::map<std::string, std::set<bool>> active;
  for (int i = 0; i < 20; ++i)
    for (const Draw& draw : every_draw(rng))
      if (draw.label.rfind("RangeBall ", 0) == 0) active[draw.label].insert(draw.residual(draw.values(rng), nullptr).norm() > 0);
  EXPECT_EQ(active.size(), 8u);
  for (const auto& [label, sides] : active) EXPECT_EQ(sides.size(), 2u) << label;
}

}  // namespace
}  // namespace holdfast::testing
