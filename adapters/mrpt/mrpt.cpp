#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <holdfast/adapters/mrpt/mrpt.hpp>

namespace holdfast {
namespace {

/// Body rates of the angles: ω_body = T (yaw, pitch, roll)˙, with R = R_z(yaw) R_y(pitch) R_x(roll).
Matrix<3, 3> body_rates(double pitch, double roll) {
  const double cp = std::cos(pitch), sp = std::sin(pitch), cr = std::cos(roll), sr = std::sin(roll);
  Matrix<3, 3> T;
  T << -sp, 0, 1, cp * sr, cr, 0, cp * cr, -sr, 0;
  return T;
}

template <int N>
Matrix<N, N> inverse(const Matrix<N, N>& S, const char* what) {
  const Eigen::LLT<Eigen::MatrixXd> cholesky(S);
  if (!S.array().isFinite().all() || cholesky.info() != Eigen::Success) fail<BadNumber>(what, " is not positive definite:\n", S);
  const Matrix<N, N> result = cholesky.solve(Eigen::MatrixXd::Identity(N, N));
  return 0.5 * (result + result.transpose());
}

}  // namespace

using mrpt::poses::CPose3D;

Pose3 StandsFor<CPose3D>::ours(const CPose3D& p) {
  return {Vector<3>(p.x(), p.y(), p.z()), so3::Quaternion<double>(Eigen::Quaterniond(p.getRotationMatrix().asEigen()).normalized())};
}

CPose3D StandsFor<CPose3D>::theirs(const Pose3& p) {
  mrpt::math::CVectorFixedDouble<3> position;
  for (int i = 0; i < 3; ++i) position[i] = p.p[i];
  return CPose3D(mrpt::math::CMatrixDouble33(p.rotation()), position);
}

Matrix<3, 3> mrpt_coordinates(const Pose2& measured) {
  Matrix<3, 3> J = Matrix<3, 3>::Identity();
  J.topLeftCorner<2, 2>() = measured.rotation();
  return J;
}

Matrix<6, 6> mrpt_coordinates(const Pose3& measured) {
  const CPose3D pose = StandsFor<CPose3D>::theirs(measured);
  if (std::abs(std::cos(pose.pitch())) < 1e-6)
    fail<BadNumber>("a pose of pitch ", pose.pitch(),
                    " rad has no yaw and roll of its own, so its Gaussian in yaw, pitch and roll means nothing; "
                    "turn the sensor's frame, or give the measurement as a Between");
  Matrix<6, 6> J = Matrix<6, 6>::Zero();
  J.topLeftCorner<3, 3>() = measured.rotation();
  J.bottomRightCorner<3, 3>() = body_rates(pose.pitch(), pose.roll()).inverse();
  return J;
}

Matrix<3, 3> detail::inverse_of(const Matrix<3, 3>& S, const char* what) { return inverse<3>(S, what); }
Matrix<6, 6> detail::inverse_of(const Matrix<6, 6>& S, const char* what) { return inverse<6>(S, what); }

}  // namespace holdfast
