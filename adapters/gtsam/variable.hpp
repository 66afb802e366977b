// Our variables as GTSAM keeps them, and values both ways.
//
//   values.insert(A(3), gtsam::Pose3{…});   values.at<gtsam::Pose2>(A(0));       // into and out of our Values
//   gtsam::Values theirs = to_gtsam(values);   Values ours = from_gtsam(theirs);
//
// In gtsam::Values: Pose2, Pose3, Point2, Point3 are GTSAM's own; Motion2 a Vector4, Turning2 a Vector5, Motion3 and Accel2 a Vector6,
// Accel3 a Vector9 (in our memory order), Scalar a double. Tangents: GTSAM moves translations in the body frame, and Pose3's come rotation
// first; both its retractions (Expmap or not) agree with ours to first order, which is all that a Jacobian asks for. Keys are the same 64
// bits, whatever wrote them: gtsam::Symbol('x', 3) is Key('x', 3), a LabeledSymbol comes back as it went.
#pragma once

#include <gtsam/geometry/Point2.h>
#include <gtsam/geometry/Point3.h>
#include <gtsam/geometry/Pose2.h>
#include <gtsam/geometry/Pose3.h>
#include <gtsam/nonlinear/Values.h>

#include <holdfast/adapters/detail/host_term.hpp>

namespace holdfast {

template <>
struct StandsFor<gtsam::Pose2> {
  using type = Pose2;
  static Pose2 ours(const gtsam::Pose2& p) { return {Vector<2>(p.x(), p.y()), Vector<2>(p.r().c(), p.r().s())}; }
  static gtsam::Pose2 theirs(const Pose2& p) {
    return gtsam::Pose2(gtsam::Rot2::fromCosSin(p.heading[0], p.heading[1]), gtsam::Point2(p.p));
  }
};
template <>
struct StandsFor<gtsam::Pose3> {
  using type = Pose3;
  static Pose3 ours(const gtsam::Pose3& p) {
    return {Vector<3>(p.translation()), so3::Quaternion<double>(p.rotation().toQuaternion().normalized())};
  }
  static gtsam::Pose3 theirs(const Pose3& p) {
    return gtsam::Pose3(gtsam::Rot3(Eigen::Quaterniond(p.q.w(), p.q.x(), p.q.y(), p.q.z())), gtsam::Point3(p.p));
  }
};
template <>
struct StandsFor<gtsam::Point2> {
  using type = Point2;
  static Point2 ours(const gtsam::Point2& p) { return {p[0], p[1]}; }
  static gtsam::Point2 theirs(const Point2& p) { return gtsam::Point2(p.value); }
};
template <>
struct StandsFor<gtsam::Point3> {
  using type = Point3;
  static Point3 ours(const gtsam::Point3& p) { return {p[0], p[1], p[2]}; }
  static gtsam::Point3 theirs(const Point3& p) { return gtsam::Point3(p.value); }
};

inline gtsam::Key gtsam_key(Key key) { return key.bits(); }
inline Key holdfast_key(gtsam::Key key) { return Key::from_bits(key); }

/// How a variable of ours is kept in gtsam::Values: its type there, both ways, and d (our tangent) / d (GTSAM's). Primary: a vector space.
template <class V>
struct GtsamVariable {
  using type = Eigen::Matrix<double, V::dim, 1>;
  static V ours(const type& x) { return V(x); }
  static type theirs(const V& v) { return v.value; }
  static Matrix<V::dim, V::dim> tangent(const V&) { return Matrix<V::dim, V::dim>::Identity(); }
};
template <>
struct GtsamVariable<Scalar> {
  using type = double;
  static Scalar ours(double x) { return x; }
  static double theirs(const Scalar& v) { return v.value; }
  static Matrix<1, 1> tangent(const Scalar&) { return Matrix<1, 1>::Identity(); }
};
template <>
struct GtsamVariable<Pose2> : StandsFor<gtsam::Pose2> {
  using type = gtsam::Pose2;
  static Matrix<3, 3> tangent(const Pose2& p) {
    Matrix<3, 3> D = Matrix<3, 3>::Identity();
    D.topLeftCorner<2, 2>() = p.rotation();
    return D;
  }
};
template <>
struct GtsamVariable<Pose3> : StandsFor<gtsam::Pose3> {
  using type = gtsam::Pose3;
  static Matrix<6, 6> tangent(const Pose3& p) {
    Matrix<6, 6> D = Matrix<6, 6>::Zero();
    D.topRightCorner<3, 3>() = p.rotation();
    D.bottomLeftCorner<3, 3>().setIdentity();
    return D;
  }
};

namespace detail {
class GtsamSlot : public HostSlot {
 public:
  static const char* cure() { return "gtsam::Values; specialise GtsamVariable and use gtsam_factor"; }
  virtual void read(const gtsam::Values& values, gtsam::Key key, double* x) const = 0;
  virtual void insert(gtsam::Values& values, gtsam::Key key, const double* x) const = 0;
  virtual bool holds(const gtsam::Value& value) const = 0;
  virtual void insert(Values& values, Key key, const double* x) const = 0;

 protected:
  using HostSlot::HostSlot;
};

template <class V>
class GtsamSlotOf final : public HostSlotOf<GtsamSlot, GtsamVariable<V>, V> {
  using G = GtsamVariable<V>;

 public:
  void read(const gtsam::Values& values, gtsam::Key key, double* x) const override {
    to_ambient(V(G::ours(values.at<typename G::type>(key))), x);
  }
  void insert(gtsam::Values& values, gtsam::Key key, const double* x) const override {
    values.insert_or_assign(key, typename G::type(G::theirs(from_ambient<V>(x))));
  }
  bool holds(const gtsam::Value& value) const override {
    return dynamic_cast<const gtsam::GenericValue<typename G::type>*>(&value) != nullptr;
  }
  void insert(Values& values, Key key, const double* x) const override { values.insert(key, from_ambient<V>(x)); }
};

/// The slot of a type of variables.hpp; BadType names any other.
const GtsamSlot* gtsam_slot(const PoolBase& pool);
HostTerm<GtsamSlot> gtsam_term(const Term& term);

// Compiled into the library (adapters/gtsam/variable.cpp).
extern template class GtsamSlotOf<Pose2>;
extern template class GtsamSlotOf<Pose3>;
extern template class GtsamSlotOf<Point2>;
extern template class GtsamSlotOf<Point3>;
extern template class GtsamSlotOf<Scalar>;
extern template class GtsamSlotOf<Motion2>;
extern template class GtsamSlotOf<Motion3>;
extern template class GtsamSlotOf<Accel2>;
extern template class GtsamSlotOf<Accel3>;
extern template class GtsamSlotOf<Turning2>;
}  // namespace detail

gtsam::Values to_gtsam(const Values& values);
/// GTSAM's values of the keys that `values` holds, into them.
void write_back(const gtsam::Values& theirs, Values& values);
/// Poses, points and numbers, and Vector4 as Motion2, Vector5 as Turning2, Vector9 as Accel3. BadType names anything else: a Vector6 could
/// be two things of ours.
Values from_gtsam(const gtsam::Values& theirs);

}  // namespace holdfast
