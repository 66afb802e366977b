// Our variables as vertices of g2o.
//
// Pose2 is g2o::VertexSE2, Pose3 g2o::VertexSE3, Point2 g2o::VertexPointXY, Point3 g2o::VertexPointXYZ; motion states and Scalar are
// G2oVector<dim>, in our memory order. g2o's own oplus moves an SE3's translation in the body, and counts half angles.
#pragma once

#include <g2o/core/base_vertex.h>
#include <g2o/types/slam2d/vertex_point_xy.h>
#include <g2o/types/slam2d/vertex_se2.h>
#include <g2o/types/slam3d/vertex_pointxyz.h>
#include <g2o/types/slam3d/vertex_se3.h>

#include <holdfast/adapters/detail/host_term.hpp>

namespace holdfast {

/// A vector space as a vertex.
template <int N>
class G2oVector final : public g2o::BaseVertex<N, Eigen::Matrix<double, N, 1>> {
 public:
  bool read(std::istream&) override { return false; }
  bool write(std::ostream&) const override { return false; }

 protected:
  void setToOriginImpl() override { this->_estimate.setZero(); }
  void oplusImpl(const double* update) override { this->_estimate += Eigen::Map<const Eigen::Matrix<double, N, 1>>(update); }
};

namespace detail {
template <class V, class VertexClass>
struct G2oPoint {
  using Vertex = VertexClass;
  static V ours(const Vertex& vertex) { return V(vertex.estimate()); }
  static Eigen::Matrix<double, V::dim, 1> theirs(const V& v) { return v.value; }
  static Matrix<V::dim, V::dim> tangent(const V&) { return Matrix<V::dim, V::dim>::Identity(); }
};
}  // namespace detail

/// How a variable of ours is kept in a vertex: its class, both ways, and d (our tangent) / d (its oplus). Primary: a vector space.
template <class V>
struct G2oVariable : detail::G2oPoint<V, G2oVector<V::dim>> {};
template <>
struct G2oVariable<Scalar> {
  using Vertex = G2oVector<1>;
  static Scalar ours(const Vertex& vertex) { return vertex.estimate()[0]; }
  static Eigen::Matrix<double, 1, 1> theirs(const Scalar& v) { return Eigen::Matrix<double, 1, 1>(v.value); }
  static Matrix<1, 1> tangent(const Scalar&) { return Matrix<1, 1>::Identity(); }
};
template <>
struct G2oVariable<Point2> : detail::G2oPoint<Point2, g2o::VertexPointXY> {};
template <>
struct G2oVariable<Point3> : detail::G2oPoint<Point3, g2o::VertexPointXYZ> {};
template <>
struct G2oVariable<Pose2> {
  using Vertex = g2o::VertexSE2;
  static Pose2 ours(const Vertex& vertex) {
    const g2o::SE2& pose = vertex.estimate();
    return {pose.translation()[0], pose.translation()[1], pose.rotation().angle()};
  }
  static g2o::SE2 theirs(const Pose2& v) { return {v.p[0], v.p[1], v.angle()}; }
  static Matrix<3, 3> tangent(const Pose2&) { return Matrix<3, 3>::Identity(); }
};
template <>
struct G2oVariable<Pose3> {
  using Vertex = g2o::VertexSE3;
  static Pose3 ours(const Vertex& vertex) {
    const g2o::Isometry3& pose = vertex.estimate();
    return {Vector<3>(pose.translation()), so3::Quaternion<double>(Eigen::Quaterniond(pose.rotation()).normalized())};
  }
  static g2o::Isometry3 theirs(const Pose3& v) {
    g2o::Isometry3 pose = g2o::Isometry3::Identity();
    pose.linear() = v.rotation();
    pose.translation() = v.p;
    return pose;
  }
  static Matrix<6, 6> tangent(const Pose3& v) {
    Matrix<6, 6> D = Matrix<6, 6>::Zero();
    D.topLeftCorner<3, 3>() = v.rotation();
    D.bottomRightCorner<3, 3>() = 2 * Matrix<3, 3>::Identity();
    return D;
  }
};

namespace detail {
class G2oSlot : public HostSlot {
 public:
  static const char* cure() { return "g2o's vertices; specialise G2oVariable and use g2o_edge"; }
  virtual g2o::OptimizableGraph::Vertex* make(const double* x) const = 0;
  virtual void read(const g2o::HyperGraph::Vertex& vertex, double* x) const = 0;

 protected:
  using HostSlot::HostSlot;
};

template <class V>
class G2oSlotOf final : public HostSlotOf<G2oSlot, G2oVariable<V>, V> {
  using G = G2oVariable<V>;

 public:
  g2o::OptimizableGraph::Vertex* make(const double* x) const override {
    auto* vertex = new typename G::Vertex();
    vertex->setEstimate(G::theirs(from_ambient<V>(x)));
    return vertex;
  }
  void read(const g2o::HyperGraph::Vertex& vertex, double* x) const override {
    to_ambient(V(G::ours(static_cast<const typename G::Vertex&>(vertex))), x);
  }
};

inline const G2oSlot* g2o_slot(const PoolBase& pool) { return slot_of<G2oSlot, G2oSlotOf>(pool.type(), pool.type_name()); }
}  // namespace detail

}  // namespace holdfast
