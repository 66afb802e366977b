// What every factor of the library, on all its variable types, owes to every back-end.
#include <gtest/gtest.h>

#include <holdfast/graph/resolved.hpp>

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

}  // namespace
}  // namespace holdfast::testing
