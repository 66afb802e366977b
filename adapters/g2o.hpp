// Our factors in a user's g2o::SparseOptimizer. Header-only; link holdfast::g2o.
//
//   auto* edge = g2o_edge(Range<Pose2, Point2>{12.3, 0.5}, {pose_vertex, beacon_vertex}, Cauchy{2});
//   optimizer.addEdge(edge);
//
// Vertices: Pose2 is g2o::VertexSE2, Pose3 g2o::VertexSE3, Point2 g2o::VertexPointXY, Point3 g2o::VertexPointXYZ; motion states and Scalar are
// G2oVector<dim>, in our memory order. The Jacobian is with respect to g2o's own oplus (SE3: translation in the body, half angles).
//
// g2o's total is Σ ρ(χ²) without the ½: chi2 is twice our cost. A loss of the whole block becomes a robust kernel with our ρ; per-component and
// one-sided losses, which g2o has not, are folded into the error (solvers/fold.hpp), exactly.
#pragma once

#include <g2o/core/base_fixed_sized_edge.h>
#include <g2o/core/base_variable_sized_edge.h>
#include <g2o/core/base_vertex.h>
#include <g2o/core/robust_kernel.h>
#include <g2o/types/slam2d/vertex_point_xy.h>
#include <g2o/types/slam2d/vertex_se2.h>
#include <g2o/types/slam3d/vertex_pointxyz.h>
#include <g2o/types/slam3d/vertex_se3.h>

#include <holdfast/adapters/term.hpp>
#include <holdfast/solvers/fold.hpp>

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

/// How a variable of ours is kept in a vertex: its class, both ways, and d (our tangent) / d (its oplus). Primary: a vector space.
template <class V>
struct G2oVariable {
  using Vertex = G2oVector<V::dim>;
  static V ours(const Vertex& vertex) { return V(vertex.estimate()); }
  static Eigen::Matrix<double, V::dim, 1> theirs(const V& v) { return v.value; }
  static Matrix<V::dim, V::dim> tangent(const V&) { return Matrix<V::dim, V::dim>::Identity(); }
};
template <>
struct G2oVariable<Scalar> {
  using Vertex = G2oVector<1>;
  static Scalar ours(const Vertex& vertex) { return vertex.estimate()[0]; }
  static Eigen::Matrix<double, 1, 1> theirs(const Scalar& v) { return Eigen::Matrix<double, 1, 1>(v.value); }
  static Matrix<1, 1> tangent(const Scalar&) { return Matrix<1, 1>::Identity(); }
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
/// The same without types.
class G2oSlot {
 public:
  virtual ~G2oSlot() = default;
  int dim, ambient;
  virtual g2o::OptimizableGraph::Vertex* make(const double* x) const = 0;
  virtual void read(const g2o::HyperGraph::Vertex& vertex, double* x) const = 0;
  virtual void tangent(const double* x, double* D) const = 0;  ///< dim × dim, column-major

 protected:
  G2oSlot(int dim_, int ambient_) : dim(dim_), ambient(ambient_) {}
};
template <class V>
class G2oSlotOf final : public G2oSlot {
  using G = G2oVariable<V>;

 public:
  G2oSlotOf() : G2oSlot(V::dim, ambient_dim<V>) {}
  g2o::OptimizableGraph::Vertex* make(const double* x) const override {
    auto* vertex = new typename G::Vertex();
    vertex->setEstimate(G::theirs(from(x)));
    return vertex;
  }
  void read(const g2o::HyperGraph::Vertex& vertex, double* x) const override {
    const V v = G::ours(static_cast<const typename G::Vertex&>(vertex));
    std::memcpy(x, &v, sizeof v);
  }
  void tangent(const double* x, double* D) const override {
    const Matrix<V::dim, V::dim> all = G::tangent(from(x));
    std::copy_n(all.data(), all.size(), D);
  }

 private:
  static V from(const double* x) {
    V v;
    std::memcpy(static_cast<void*>(&v), x, sizeof v);
    return v;
  }
};
template <class V>
const G2oSlot* g2o_slot() {
  static const G2oSlotOf<V> slot;
  return &slot;
}
inline const G2oSlot* g2o_slot(std::type_index type) {
  static const std::pair<std::type_index, const G2oSlot*> all[] = {
      {typeid(Pose2), g2o_slot<Pose2>()},   {typeid(Pose3), g2o_slot<Pose3>()},     {typeid(Point2), g2o_slot<Point2>()},
      {typeid(Point3), g2o_slot<Point3>()}, {typeid(Motion2), g2o_slot<Motion2>()}, {typeid(Motion3), g2o_slot<Motion3>()},
      {typeid(Accel2), g2o_slot<Accel2>()}, {typeid(Accel3), g2o_slot<Accel3>()},   {typeid(Scalar), g2o_slot<Scalar>()}};
  for (const auto& [known, slot] : all)
    if (known == type) return slot;
  fail<BadType>("the variable type ", type.name(), " has no vertex known here; specialise G2oVariable and use g2o_edge");
}

/// w ρ(χ²) with our ρ.
class G2oLoss final : public g2o::RobustKernel {
 public:
  G2oLoss(const Loss& loss, double weight, int d) : loss_(loss), weight_(weight), d_(d) {}
  void robustify(double squared_error, g2o::Vector3& out) const override {
    const Rho rho = loss_.rho(squared_error, d_);
    out = weight_ * g2o::Vector3(rho.value, rho.first, rho.second);
  }

 private:
  Loss loss_;
  double weight_;
  int d_;
};

/// A term and how its variables are kept; the part of an edge that does not depend on sizes known at compile time.
struct G2oTerm {
  Term term;
  std::vector<const G2oSlot*> slots;

  /// r, and J with respect to our tangents where it is not null, folded where need be; x: the variables, one after the other.
  void evaluate(const g2o::HyperGraph::VertexContainer& vertices, std::vector<double>& x, double* r, double* J) const {
    std::size_t size = 0;
    for (const G2oSlot* slot : slots) size += slot->ambient;
    x.resize(size);
    std::vector<const double*> at;
    at.reserve(slots.size());
    double* next = x.data();
    for (std::size_t k = 0; k < slots.size(); ++k) {
      slots[k]->read(*vertices[k], next);
      at.push_back(next);
      next += slots[k]->ambient;
    }
    term.evaluate(at.data(), r, J);
    if (must_fold(term.loss(), term.residual_dim())) fold(term.loss(), term.weight(), term.residual_dim(), term.total_dim(), r, J);
  }
  /// fill(k, J_k): each variable's Jacobian with respect to its oplus.
  template <class Fill>
  void linearize(const g2o::HyperGraph::VertexContainer& vertices, const Fill& fill) const {
    Eigen::VectorXd r(term.residual_dim());
    Eigen::MatrixXd J(term.residual_dim(), term.total_dim());
    std::vector<double> x;
    evaluate(vertices, x, r.data(), J.data());
    const double* at = x.data();
    int column = 0;
    for (std::size_t k = 0; k < slots.size(); ++k) {
      Eigen::MatrixXd D(slots[k]->dim, slots[k]->dim);
      slots[k]->tangent(at, D.data());
      fill(k, J.middleCols(column, slots[k]->dim) * D);
      column += slots[k]->dim;
      at += slots[k]->ambient;
    }
  }
  template <class Edge>
  void prepare(Edge& edge) const {
    edge.information().setIdentity();
    const bool plain = must_fold(term.loss(), term.residual_dim()) || (term.loss().kind == Loss::Kind::Squared && term.weight() == 1);
    if (!plain) edge.setRobustKernel(new G2oLoss(term.loss(), term.weight(), term.residual_dim()));
  }
};
}  // namespace detail

/// A term of our cost as an edge whose sizes g2o knows at compile time, which is what it is fast on. M: residual_dim.
template <int M, class... Vertex>
class G2oEdge final : public g2o::BaseFixedSizedEdge<M, int, Vertex...> {
 public:
  explicit G2oEdge(detail::G2oTerm term) : term_(std::move(term)) { term_.prepare(*this); }
  void computeError() override {
    std::vector<double> x;
    term_.evaluate(this->_vertices, x, this->_error.data(), nullptr);
  }
  void linearizeOplus() override { fill(std::index_sequence_for<Vertex...>{}); }
  bool read(std::istream&) override { return false; }
  bool write(std::ostream&) const override { return false; }

 private:
  template <std::size_t... I>
  void fill(std::index_sequence<I...>) {
    term_.linearize(this->_vertices, [&](std::size_t k, const Eigen::MatrixXd& J) { ((k == I && (std::get<I>(this->_jacobianOplus) = J, true)) || ...); });
  }
  detail::G2oTerm term_;
};

/// The same for any sizes.
class G2oAnyEdge final : public g2o::BaseVariableSizedEdge<-1, int> {
 public:
  explicit G2oAnyEdge(detail::G2oTerm term) : term_(std::move(term)) {
    setDimension(term_.term.residual_dim());
    resize(term_.slots.size());
    term_.prepare(*this);
  }
  void computeError() override {
    std::vector<double> x;
    term_.evaluate(_vertices, x, _error.data(), nullptr);
  }
  void linearizeOplus() override {
    term_.linearize(_vertices, [&](std::size_t k, const Eigen::MatrixXd& J) { _jacobianOplus[k] = J; });
  }
  using g2o::BaseVariableSizedEdge<-1, int>::linearizeOplus;
  bool read(std::istream&) override { return false; }
  bool write(std::ostream&) const override { return false; }

 private:
  detail::G2oTerm term_;
};

namespace detail {
template <class F, std::size_t... I>
g2o::OptimizableGraph::Edge* g2o_edge(const Term& term, const std::vector<g2o::OptimizableGraph::Vertex*>& vertices, std::index_sequence<I...>) {
  using Vars = typename F::Variables;
  const bool fits = vertices.size() == sizeof...(I) &&
                    ((dynamic_cast<typename G2oVariable<typename Vars::template type<I>>::Vertex*>(vertices[I]) != nullptr) && ...);
  if (!fits)
    fail<BadType>(factor_name<F>(), " ties", ((std::string(" ") + Vars::template type<I>::name()) + ...),
                  ", and the vertices given are others (null, too few, or of another class); see the table in adapters/g2o.hpp");
  auto* edge = new G2oEdge<F::residual_dim, typename G2oVariable<typename Vars::template type<I>>::Vertex...>(
      {term, {g2o_slot<typename Vars::template type<I>>()...}});
  (edge->setVertex(I, vertices[I]), ...);
  return edge;
}
}  // namespace detail

/// With the factor's own default loss and weight, or with those given. The optimizer it is added to owns the edge.
template <class F>
g2o::OptimizableGraph::Edge* g2o_edge(const F& factor, const std::vector<g2o::OptimizableGraph::Vertex*>& vertices) {
  return detail::g2o_edge<F>(Term(factor), vertices, std::make_index_sequence<F::Variables::size>{});
}
template <class F>
g2o::OptimizableGraph::Edge* g2o_edge(const F& factor, const std::vector<g2o::OptimizableGraph::Vertex*>& vertices, const Loss& loss,
                                      double weight = 1) {
  return detail::g2o_edge<F>(Term(factor, loss, weight), vertices, std::make_index_sequence<F::Variables::size>{});
}

}  // namespace holdfast
