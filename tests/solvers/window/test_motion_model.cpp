// How an agent moves when nothing is measured: prediction, steps on a grid and motions over any time.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <holdfast/factors/between.hpp>
#include <holdfast/factors/white_acceleration.hpp>
#include <holdfast/solvers/window/detail/motion_model.hpp>

namespace holdfast {
namespace {

using ::testing::HasSubstr;

constexpr Agent A('A');
using Motion = WhiteAcceleration<Motion2>;

Motion step_of(double dt) { return Motion::exact(dt, 1, Matrix<4, 4>::Identity()); }

TEST(Predict, GoesOnAtTheSameVelocity) {
  const Motion2 next = predict(step_of(0.5), Motion2(1, 2, 10, -4));  // x, vx, y, vy
  EXPECT_LT((next.value - Vector<4>(2, 2, 8, -4)).norm(), 1e-12);
}

TEST(Predict, FollowsOdometryOnTheManifold) {
  const Pose2 from(1, 2, 0.7), measured(3, -1, 2.9);
  const Pose2 next = predict(Between<Pose2>::from_sigmas(measured, Vector<3>(0.1, 0.2, 0.3)), from);
  EXPECT_LT(next.local(from * measured).norm(), 1e-10);
}

class SteppedMotionTest : public ::testing::Test {
 protected:
  SteppedMotionTest() : model(step_of(0.1), 0.1, Huber{3}) {
    values.insert(A(0), Motion2(0, 1, 0, 2));
    values.insert(A(1), Motion2(0, 1, 0, 2));
  }
  const Motion& added(double seconds) { return graph.at<Motion>(model.add(graph, values, A(0), A(1), seconds, true)); }

  SteppedMotion<Motion> model;
  Graph graph;
  Values values;
};

TEST_F(SteppedMotionTest, IsTheFactorMergedOverItsSteps) {
  const Motion2 from(1, 2, 3, 4), to(5, 6, 7, 8);
  for (const int m : {1, 2, 7, 256, 300}) {
    const Motion expected = m == 1 ? step_of(0.1) : step_of(0.1).merged(m);
    EXPECT_LT((added(0.1 * m)(from, to) - expected(from, to)).norm(), 1e-12) << m;
  }
}

TEST_F(SteppedMotionTest, HasItsLoss) {
  model.add(graph, values, A(0), A(1), 0.1, true);
  EXPECT_EQ(graph.batches()[0]->loss(0), Loss(Huber{3}));
}

TEST_F(SteppedMotionTest, InsertsWhereItLeads) {
  model.insert_predicted(values, A(0), A(2), 0.3, true);
  EXPECT_LT((values.at<Motion2>(A(2)).value - Vector<4>(0.3, 1, 0.6, 2)).norm(), 1e-12);
}

TEST_F(SteppedMotionTest, RefusesTimesOffItsGrid) {
  for (const double seconds : {0.15, 0.0, -0.1, 1e6, static_cast<double>(NAN)}) {
    try {
      model.add(graph, values, A(0), A(1), seconds, true);
      ADD_FAILURE() << seconds;
    } catch (const BadTime& error) {
      EXPECT_THAT(error.what(), HasSubstr("dt = 0.1"));
    }
  }
  EXPECT_NO_THROW(model.add(graph, values, A(0), A(1), 0.30001, true));  // a clock's rounding
  EXPECT_THROW(SteppedMotion<Motion>(step_of(0.1), 0, {}), BadNumber);
}

TEST(TimedMotion, IsMadeForAnyTime) {
  TimedMotion model([](double seconds) { return Motion::continuous(seconds, 2); }, Loss(Squared{}));
  Graph graph;
  Values values;
  values.insert(A(0), Motion2(0, 1, 0, 2));
  model.insert_predicted(values, A(0), A(1), 0.37, true);
  EXPECT_LT((values.at<Motion2>(A(1)).value - Vector<4>(0.37, 1, 0.74, 2)).norm(), 1e-12);
  EXPECT_EQ(graph.at<Motion>(model.add(graph, values, A(0), A(1), 0.37, true)).dt, 0.37);
}

}  // namespace
}  // namespace holdfast
