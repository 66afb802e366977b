// How a variable lies in a user's memory: our own (Own), the usual ones, or a struct of the user's own with the same five members.
//
//   Own<V>                            the variable itself: Pose3 [x y z qx qy qz qw], Pose2 [x y cos sin], Motion2 [px vx py vy], …
//   PositionYaw                       Pose2 as [x y | θ]; a plain vector space: it needs no manifold
//   PositionQuaternion<order>         Pose3 as [x y z | quaternion], order xyzw (Eigen's memory) or wxyz (Ceres', MRPT's)
//   QuaternionPosition<order>         Pose3 as [quaternion | x y z]
//   ByDerivative<V>                   Motion2 as [px py | vx vy], Accel3 as [p | v | a], …
//   Separate<Layout>                  the same numbers in a block for each part between the bars above ([x y], [θ] for PositionYaw)
//   EachNumber<Layout>                the same numbers in a block for each of them: x, y and θ as three blocks of one
//
// A quaternion that is not of length 1 counts as the rotation of its direction; so a Jacobian with respect to these numbers is exact
// whatever manifold the user puts on the block. The rotation is that of R_world_body.
#pragma once

#include <algorithm>
#include <array>
#include <cstring>
#include <holdfast/graph/variables.hpp>
#include <tuple>
#include <utility>
#include <vector>

namespace holdfast {

/// Number of doubles of a layout.
template <class L>
inline constexpr int layout_size = [] {
  int sum = 0;
  for (int n : L::parts) sum += n;
  return sum;
}();

template <class V>
struct Own {
  static_assert(ambient_dim<V> == V::dim, "this variable is no vector space: write a layout struct for it (see Own<Pose2>)");
  using Variable = V;
  static constexpr std::array<int, 1> parts{V::dim};
  static V read(const double* x) { return V(Eigen::Map<const Vector<V::dim>>(x)); }
  static void write(const V& v, double* x) { Eigen::Map<Vector<V::dim>>(x, V::dim) = v.value; }
  /// d tangent / d memory, and d memory / d tangent.
  static Matrix<V::dim, V::dim> minus_jacobian(const double*) { return Matrix<V::dim, V::dim>::Identity(); }
  static Matrix<V::dim, V::dim> plus_jacobian(const double*) { return Matrix<V::dim, V::dim>::Identity(); }
};

template <>
struct Own<Scalar> {
  using Variable = Scalar;
  static constexpr std::array<int, 1> parts{1};
  static Scalar read(const double* x) { return *x; }
  static void write(const Scalar& v, double* x) { *x = v.value; }
  static Matrix<1, 1> minus_jacobian(const double*) { return Matrix<1, 1>::Identity(); }
  static Matrix<1, 1> plus_jacobian(const double*) { return Matrix<1, 1>::Identity(); }
};

template <>
struct Own<Pose2> {
  using Variable = Pose2;
  static constexpr std::array<int, 2> parts{2, 2};
  static Pose2 read(const double* x) { return {Vector<2>(x[0], x[1]), Vector<2>(x[2], x[3]).normalized()}; }
  static void write(const Pose2& v, double* x) {
    Eigen::Map<Vector<2>>(x, 2) = v.p;
    Eigen::Map<Vector<2>>(x + 2, 2) = v.heading;
  }
  static Matrix<3, 4> minus_jacobian(const double* x) {
    Matrix<3, 4> M = Matrix<3, 4>::Identity();
    const double length2 = x[2] * x[2] + x[3] * x[3];
    M(2, 2) = -x[3] / length2;
    M(2, 3) = x[2] / length2;
    return M;
  }
  static Matrix<4, 3> plus_jacobian(const double* x) {
    Matrix<4, 3> P = Matrix<4, 3>::Identity();
    P(2, 2) = -x[3];
    P(3, 2) = x[2];
    return P;
  }
};

struct PositionYaw {
  using Variable = Pose2;
  static constexpr std::array<int, 2> parts{2, 1};
  static Pose2 read(const double* x) { return {x[0], x[1], x[2]}; }
  static void write(const Pose2& v, double* x) {
    Eigen::Map<Vector<2>>(x, 2) = v.p;
    x[2] = v.angle();
  }
  static Matrix<3, 3> minus_jacobian(const double*) { return Matrix<3, 3>::Identity(); }
  static Matrix<3, 3> plus_jacobian(const double*) { return Matrix<3, 3>::Identity(); }
};

enum class QuaternionOrder { xyzw, wxyz };

namespace detail {
/// Where position and quaternion begin, and where in the quaternion w and the vector part are.
template <QuaternionOrder Order, int Position, int Quaternion>
struct PoseLayout {
  using Variable = Pose3;
  static constexpr int w = Quaternion + (Order == QuaternionOrder::xyzw ? 3 : 0);
  static constexpr int v = Quaternion + (Order == QuaternionOrder::xyzw ? 0 : 1);

  static Pose3 read(const double* x) {
    return {Vector<3>(Eigen::Map<const Vector<3>>(x + Position)), so3::Quaternion<double>(x[w], x[v], x[v + 1], x[v + 2]).normalized()};
  }
  static void write(const Pose3& pose, double* x) {
    Eigen::Map<Vector<3>>(x + Position, 3) = pose.p;
    Eigen::Map<Vector<3>>(x + v, 3) = pose.q.vec();
    x[w] = pose.q.w();
  }
  /// q ⊗ [φ/2, 1] = q + ½ Q φ for small φ, and back: φ = 2 Qᵀ dq / ‖q‖².
  static Matrix<7, 6> plus_jacobian(const double* x) { return half_columns(x, 0.5); }
  static Matrix<6, 7> minus_jacobian(const double* x) {
    const double length2 = Eigen::Map<const Vector<4>>(x + Quaternion).squaredNorm();
    return half_columns(x, 2 / length2).transpose();
  }

 private:
  static Matrix<7, 6> half_columns(const double* x, double factor) {
    Matrix<7, 6> P = Matrix<7, 6>::Zero();
    P.template block<3, 3>(Position, 0).setIdentity();
    const Vector<3> u(x[v], x[v + 1], x[v + 2]);
    P.template block<3, 3>(v, 3) = factor * (x[w] * Matrix<3, 3>::Identity() + so3::hat(u));
    P.template block<1, 3>(w, 3) = -factor * u.transpose();
    return P;
  }
};
}  // namespace detail

template <QuaternionOrder Order = QuaternionOrder::xyzw>
struct PositionQuaternion : detail::PoseLayout<Order, 0, 3> {
  static constexpr std::array<int, 2> parts{3, 4};
};
template <QuaternionOrder Order = QuaternionOrder::xyzw>
struct QuaternionPosition : detail::PoseLayout<Order, 4, 0> {
  static constexpr std::array<int, 2> parts{4, 3};
};
template <>
struct Own<Pose3> : PositionQuaternion<QuaternionOrder::xyzw> {};

template <class V>
struct ByDerivative {
  using Variable = V;
  static constexpr std::array<int, V::order> parts = [] {
    std::array<int, V::order> all{};
    for (int& n : all) n = V::axes;
    return all;
  }();
  static V read(const double* x) { return V((minus_jacobian(x) * Eigen::Map<const Vector<V::dim>>(x)).eval()); }
  static void write(const V& v, double* x) { Eigen::Map<Vector<V::dim>>(x, V::dim) = plus_jacobian(x) * v.value; }
  static Matrix<V::dim, V::dim> minus_jacobian(const double*) {
    Matrix<V::dim, V::dim> M = Matrix<V::dim, V::dim>::Zero();
    for (int axis = 0; axis < V::axes; ++axis)
      for (int k = 0; k < V::order; ++k) M(axis * V::order + k, k * V::axes + axis) = 1;
    return M;
  }
  static Matrix<V::dim, V::dim> plus_jacobian(const double* x) { return minus_jacobian(x).transpose(); }
};

template <class L>
struct Separate : L {};
template <class L>
struct EachNumber : L {};

// ---- the same without types, for compiled code

class BlockLayout {
 public:
  virtual ~BlockLayout() = default;
  std::vector<int> blocks;                                         ///< doubles of each block of the user's memory
  int size;                                                        ///< of all of them
  int dim;                                                         ///< of the tangent
  int ambient;                                                     ///< doubles of the variable itself
  virtual void read(const double* x, double* variable) const = 0;  ///< x: the blocks one after the other
  virtual void write(const double* variable, double* x) const = 0;
  virtual void minus_jacobian(const double* x, double* M) const = 0;  ///< dim × size, column-major
  virtual void plus_jacobian(const double* x, double* P) const = 0;   ///< size × dim, column-major
  virtual void plus(const double* x, const double* delta, double* out) const = 0;
  virtual void minus(const double* to, const double* from, double* delta) const = 0;

 protected:
  BlockLayout(std::vector<int> blocks_, int size_, int dim_, int ambient_)
      : blocks(std::move(blocks_)), size(size_), dim(dim_), ambient(ambient_) {}
};

namespace detail {
template <class L>
struct BlocksOf {
  static std::vector<int> get() { return {layout_size<L>}; }
};
template <class L>
struct BlocksOf<Separate<L>> {
  static std::vector<int> get() { return {L::parts.begin(), L::parts.end()}; }
};
template <class L>
struct BlocksOf<EachNumber<L>> {
  static std::vector<int> get() { return std::vector<int>(layout_size<L>, 1); }
};

template <class L>
class LayoutOf final : public BlockLayout {
  using V = typename L::Variable;

 public:
  LayoutOf() : BlockLayout(BlocksOf<L>::get(), layout_size<L>, V::dim, ambient_dim<V>) {}
  void read(const double* x, double* variable) const override {
    const V v = L::read(x);
    std::memcpy(variable, &v, sizeof v);
  }
  void write(const double* variable, double* x) const override {
    V v;
    std::memcpy(static_cast<void*>(&v), variable, sizeof v);
    L::write(v, x);
  }
  void minus_jacobian(const double* x, double* M) const override {
    const Matrix<V::dim, layout_size<L>> all = L::minus_jacobian(x);
    std::copy_n(all.data(), all.size(), M);
  }
  void plus_jacobian(const double* x, double* P) const override {
    const Matrix<layout_size<L>, V::dim> all = L::plus_jacobian(x);
    std::copy_n(all.data(), all.size(), P);
  }
  void plus(const double* x, const double* delta, double* out) const override {
    L::write(L::read(x).retract(Eigen::Map<const Vector<V::dim>>(delta)), out);
  }
  void minus(const double* to, const double* from, double* delta) const override {
    Eigen::Map<Vector<V::dim>>(delta, V::dim) = L::read(from).local(L::read(to));
  }
};
}  // namespace detail

template <class L>
const BlockLayout& block_layout() {
  static const detail::LayoutOf<L> layout;
  return layout;
}

namespace detail {
using Layouts = std::vector<const BlockLayout*>;

template <class F, std::size_t... I>
Layouts own_layouts(std::index_sequence<I...>) {
  return {&block_layout<Own<typename F::Variables::template type<I>>>()...};
}
/// The layouts named, one a variable of F; none named: our own of each.
template <class F, class... L>
Layouts layouts_of() {
  if constexpr (sizeof...(L) == 0) {
    return own_layouts<F>(std::make_index_sequence<F::Variables::size>{});
  } else {
    static_assert(std::is_same_v<typename F::Variables::Tuple, std::tuple<typename L::Variable...>>,
                  "one layout for each variable of the factor, in its order and of its type");
    return {&block_layout<L>()...};
  }
}

template <class V, class = void>
struct LayoutOrOwn {
  using type = Own<V>;
};
template <class L>
struct LayoutOrOwn<L, std::void_t<typename L::Variable>> {
  using type = L;
};
}  // namespace detail

}  // namespace holdfast
