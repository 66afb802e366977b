// A pose goes from MRPT to GTSAM the same way through our Values as through MRPT's own wrappers.
#include <gtest/gtest.h>
#include <gtsam/nonlinear/Values.h>
#include <mrpt/poses/gtsam_wrappers.h>

#include <holdfast/adapters/gtsam/variable.hpp>
#include <holdfast/adapters/mrpt/mrpt.hpp>
#include <holdfast/testing.hpp>

namespace holdfast::testing {
namespace {

TEST(GtsamMrpt, PosesAndPointsGoOverAsByMrptsWrappers) {
  std::mt19937_64 rng(1);
  const Key pose('x', 1), point('l', 1);
  for (int i = 0; i < 100; ++i) {
    Values values;
    values.insert(pose, random_variable<Pose3>(rng));
    values.insert(point, random_variable<Point3>(rng));
    const auto p = values.at<mrpt::poses::CPose3D>(pose);
    const auto q = values.at<mrpt::math::TPoint3D>(point);
    const gtsam::Values theirs = to_gtsam(values);
    EXPECT_TRUE(theirs.at<gtsam::Pose3>(gtsam_key(pose)).equals(mrpt::gtsam_wrappers::toPose3(p), 1e-12));
    EXPECT_EQ(theirs.at<gtsam::Point3>(gtsam_key(point)), mrpt::gtsam_wrappers::toPoint3(q));
    Values back;
    back.insert(pose, mrpt::gtsam_wrappers::toTPose3D(theirs.at<gtsam::Pose3>(gtsam_key(pose))));
    EXPECT_LT(values.at<Pose3>(pose).local(back.at<Pose3>(pose)).norm(), 1e-12);
  }
}

/// GTSAM's tangent moves the translation in the body; MRPT's covariance has it in the parent's frame, and its wrapper leaves it there.
TEST(GtsamMrpt, ACovarianceOfMrptsIsTurnedIntoTheBodyByUsAlone) {
  mrpt::poses::CPose3DPDFGaussian pdf;
  pdf.mean = mrpt::poses::CPose3D(1, 2, 3, kPi / 2, 0, 0);
  pdf.cov.setDiagonal(std::vector<double>{4, 1, 1, 0.01, 0.01, 0.01});  // 2 m along the parent's x, which is the body's −y
  gtsam::Pose3 mean;
  gtsam::Matrix6 theirs;
  mrpt::gtsam_wrappers::to_gtsam_se3_cov6(pdf, mean, theirs);
  const Prior<Pose3> prior = mrpt_prior(pdf);
  const Matrix<6, 6> D = GtsamVariable<Pose3>::tangent(prior.mean);
  const Matrix<6, 6> W = prior.sqrt_information * D;
  const Matrix<6, 6> ours = (W.transpose() * W).inverse();
  EXPECT_NEAR(theirs(3, 3), 4, 1e-9);
  EXPECT_NEAR(ours(4, 4), 4, 1e-9);
  EXPECT_NEAR(ours(3, 3), 1, 1e-9);
  gtsam::Values values;
  values.insert(1, mean.retract((gtsam::Vector6() << 0, 0, 0, 0, 2, 0).finished()));  // one sigma
  Graph graph;
  graph.add(prior, {holdfast_key(1)});
  EXPECT_NEAR(graph.cost(from_gtsam(values)), 0.5, 1e-9);
}

}  // namespace
}  // namespace holdfast::testing
