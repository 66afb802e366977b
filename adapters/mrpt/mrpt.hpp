// MRPT's poses, points and Gaussians as ours. Link holdfast::mrpt.
//
//   values.insert(A(3), CPose3D{…});   values.at<CPose3D>(A(3));   values.at<TPose2D>(A(0))
//   graph.add(mrpt_between(pdf), {A(2), A(3)});                       // CPosePDFGaussian(Inf), CPose3DPDFGaussian(Inf)
//   graph.add(mrpt_prior(pdf), {A(0)});
//
// CPose2D, TPose2D: Pose2; CPose3D, TPose3D, CPose3DQuat: Pose3; CPoint2D, TPoint2D: Point2; CPoint3D, TPoint3D: Point3.
//
// A Gaussian of MRPT is one in the coordinates themselves, (x y φ) or (x y z yaw pitch roll): the translation moves in the parent's
// frame, the angles add up. Ours is one of measured⁻¹ · predicted (Between) or of measured.local(x) (Prior). So the matrix is carried over
// by the Jacobian of the coordinates; at pitch = ±90° yaw and roll have none, which is a BadNumber.
#pragma once

#include <mrpt/math/TPoint2D.h>
#include <mrpt/math/TPoint3D.h>
#include <mrpt/math/TPose2D.h>
#include <mrpt/math/TPose3D.h>
#include <mrpt/poses/CPoint2D.h>
#include <mrpt/poses/CPoint3D.h>
#include <mrpt/poses/CPointPDFGaussian.h>
#include <mrpt/poses/CPose2D.h>
#include <mrpt/poses/CPose3D.h>
#include <mrpt/poses/CPose3DPDFGaussian.h>
#include <mrpt/poses/CPose3DPDFGaussianInf.h>
#include <mrpt/poses/CPose3DQuat.h>
#include <mrpt/poses/CPosePDFGaussian.h>
#include <mrpt/poses/CPosePDFGaussianInf.h>

#include <holdfast/factors/between.hpp>
#include <holdfast/factors/prior.hpp>
#include <holdfast/graph/values.hpp>

namespace holdfast {

template <>
struct StandsFor<mrpt::poses::CPose2D> {
  using type = Pose2;
  static Pose2 ours(const mrpt::poses::CPose2D& p) { return {Vector<2>(p.x(), p.y()), Vector<2>(p.phi_cos(), p.phi_sin())}; }
  static mrpt::poses::CPose2D theirs(const Pose2& p) { return {p.p[0], p.p[1], p.angle()}; }
};
template <>
struct StandsFor<mrpt::math::TPose2D> {
  using type = Pose2;
  static Pose2 ours(const mrpt::math::TPose2D& p) { return {p.x, p.y, p.phi}; }
  static mrpt::math::TPose2D theirs(const Pose2& p) { return {p.p[0], p.p[1], p.angle()}; }
};
template <>
struct StandsFor<mrpt::poses::CPose3D> {
  using type = Pose3;
  static Pose3 ours(const mrpt::poses::CPose3D& p);
  static mrpt::poses::CPose3D theirs(const Pose3& p);
};
template <>
struct StandsFor<mrpt::math::TPose3D> {
  using type = Pose3;
  static Pose3 ours(const mrpt::math::TPose3D& p) { return StandsFor<mrpt::poses::CPose3D>::ours(mrpt::poses::CPose3D(p)); }
  static mrpt::math::TPose3D theirs(const Pose3& p) { return StandsFor<mrpt::poses::CPose3D>::theirs(p).asTPose(); }
};
template <>
struct StandsFor<mrpt::poses::CPose3DQuat> {
  using type = Pose3;
  static Pose3 ours(const mrpt::poses::CPose3DQuat& p) {
    return {Vector<3>(p.x(), p.y(), p.z()), so3::Quaternion<double>(p.quat().r(), p.quat().x(), p.quat().y(), p.quat().z())};
  }
  static mrpt::poses::CPose3DQuat theirs(const Pose3& p) {
    return {p.p[0], p.p[1], p.p[2], mrpt::math::CQuaternionDouble(p.q.w(), p.q.x(), p.q.y(), p.q.z())};
  }
};
template <>
struct StandsFor<mrpt::poses::CPoint2D> {
  using type = Point2;
  static Point2 ours(const mrpt::poses::CPoint2D& p) { return {p.x(), p.y()}; }
  static mrpt::poses::CPoint2D theirs(const Point2& p) { return {p.value[0], p.value[1]}; }
};
template <>
struct StandsFor<mrpt::math::TPoint2D> {
  using type = Point2;
  static Point2 ours(const mrpt::math::TPoint2D& p) { return {p.x, p.y}; }
  static mrpt::math::TPoint2D theirs(const Point2& p) { return {p.value[0], p.value[1]}; }
};
template <>
struct StandsFor<mrpt::poses::CPoint3D> {
  using type = Point3;
  static Point3 ours(const mrpt::poses::CPoint3D& p) { return {p.x(), p.y(), p.z()}; }
  static mrpt::poses::CPoint3D theirs(const Point3& p) { return {p.value[0], p.value[1], p.value[2]}; }
};
template <>
struct StandsFor<mrpt::math::TPoint3D> {
  using type = Point3;
  static Point3 ours(const mrpt::math::TPoint3D& p) { return {p.x, p.y, p.z}; }
  static mrpt::math::TPoint3D theirs(const Point3& p) { return {p.value[0], p.value[1], p.value[2]}; }
};

/// d (MRPT's coordinates) / d (measured⁻¹ · predicted), at the measured pose.
Matrix<3, 3> mrpt_coordinates(const Pose2& measured);
Matrix<6, 6> mrpt_coordinates(const Pose3& measured);

/// What MRPT may put on an edge of a pose network: a pose of its own (identity information) or a Gaussian.
template <class C>
struct MrptConstraint;

namespace detail {
/// I in MRPT's coordinates → I of measured⁻¹ · predicted, and back.
template <class V, int N = V::dim>
Matrix<N, N> information_of_deviation(const V& measured, const Matrix<N, N>& information) {
  const Matrix<N, N> J = mrpt_coordinates(measured);
  const Matrix<N, N> I = J.transpose() * information * J;
  return 0.5 * (I + I.transpose());
}
template <class V, int N = V::dim>
Matrix<N, N> information_of_coordinates(const V& measured, const Matrix<N, N>& information) {
  const Matrix<N, N> K = mrpt_coordinates(measured).inverse();
  const Matrix<N, N> I = K.transpose() * information * K;
  return 0.5 * (I + I.transpose());
}
/// S⁻¹ of a symmetric matrix; BadNumber where it is not positive definite.
Matrix<3, 3> inverse_of(const Matrix<3, 3>& S, const char* what);
Matrix<6, 6> inverse_of(const Matrix<6, 6>& S, const char* what);

template <class C, class V, bool Covariance>
struct GaussianConstraint {
  using Pose = V;
  static constexpr int N = V::dim;
  using Theirs = mrpt::math::CMatrixFixed<double, N, N>;
  static V measured(const C& c) { return StandsFor<std::decay_t<decltype(c.mean)>>::ours(c.mean); }
  /// In MRPT's coordinates.
  static Matrix<N, N> their_information(const C& c) {
    if constexpr (Covariance)
      return inverse_of(Matrix<N, N>(c.cov.asEigen()), "covariance of an MRPT Gaussian");
    else
      return c.cov_inv.asEigen();
  }
  static Matrix<N, N> information(const C& c) { return information_of_deviation(measured(c), their_information(c)); }
  static C make(const V& measured, const Matrix<N, N>& information) {
    const Matrix<N, N> I = information_of_coordinates(measured, information);
    C c;
    c.mean = StandsFor<std::decay_t<decltype(c.mean)>>::theirs(measured);
    if constexpr (Covariance)
      c.cov = Theirs(inverse_of(I, "information"));
    else
      c.cov_inv = Theirs(I);
    return c;
  }
};
}  // namespace detail

template <>
struct MrptConstraint<mrpt::poses::CPosePDFGaussianInf> : detail::GaussianConstraint<mrpt::poses::CPosePDFGaussianInf, Pose2, false> {};
template <>
struct MrptConstraint<mrpt::poses::CPosePDFGaussian> : detail::GaussianConstraint<mrpt::poses::CPosePDFGaussian, Pose2, true> {};
template <>
struct MrptConstraint<mrpt::poses::CPose3DPDFGaussianInf> : detail::GaussianConstraint<mrpt::poses::CPose3DPDFGaussianInf, Pose3, false> {};
template <>
struct MrptConstraint<mrpt::poses::CPose3DPDFGaussian> : detail::GaussianConstraint<mrpt::poses::CPose3DPDFGaussian, Pose3, true> {};

/// The Gaussian as a relative measurement: b as seen from a.
template <class Pdf, class V = typename MrptConstraint<Pdf>::Pose>
Between<V> mrpt_between(const Pdf& pdf) {
  return Between<V>::from_information(MrptConstraint<Pdf>::measured(pdf), MrptConstraint<Pdf>::information(pdf));
}
/// The Gaussian as what is known of a pose in the world.
template <class Pdf, class V = typename MrptConstraint<Pdf>::Pose>
Prior<V> mrpt_prior(const Pdf& pdf) {
  const V mean = MrptConstraint<Pdf>::measured(pdf);
  Matrix<V::dim, V::dim> J = mrpt_coordinates(mean);  // our tangent moves the position in the world, as MRPT's coordinates do
  J.template topLeftCorner<V::space_dim, V::space_dim>().setIdentity();
  const Matrix<V::dim, V::dim> I = J.transpose() * MrptConstraint<Pdf>::their_information(pdf) * J;
  return Prior<V>::from_information(mean, 0.5 * (I + I.transpose()));
}
inline Prior<Point3> mrpt_prior(const mrpt::poses::CPointPDFGaussian& pdf) {
  return Prior<Point3>::from_covariance(StandsFor<mrpt::poses::CPoint3D>::ours(pdf.mean), pdf.cov.asEigen());
}

}  // namespace holdfast
