// Our factors in a user's gtsam::NonlinearFactorGraph, and values both ways. Header-only; link holdfast::gtsam. GTSAM 4.2 and later.
//
//   graph.push_back(gtsam_factor(Range<Pose2, Point2>{12.3, 0.5}, {X(3), L(0)}, Cauchy{2}));
//   values.insert(A(3), gtsam::Pose3{…});   values.at<gtsam::Pose2>(A(0));       // into and out of our Values
//
// error() is w ½ρ, our cost, whatever the loss, per-component and one-sided ones included; linearize() gives rows √(w ρ') (J, −r), so that
// its gradient at 0 is that of the error. (gtsam::noiseModel::Robust takes the norm for the cost even when it re-weights by rows.)
//
// In gtsam::Values: Pose2, Pose3, Point2, Point3 are GTSAM's own; Motion2 a Vector4, Motion3 and Accel2 a Vector6, Accel3 a Vector9 (in our
// memory order), Scalar a double. Tangents: GTSAM moves translations in the body frame, and Pose3's come rotation first; both its retractions
// (Expmap or not) agree with ours to first order, which is all that a Jacobian asks for.
// Keys: Key('x', 3) and gtsam::Symbol('x', 3) are the same 64 bits.
#pragma once

#include <gtsam/geometry/Point2.h>
#include <gtsam/geometry/Point3.h>
#include <gtsam/geometry/Pose2.h>
#include <gtsam/geometry/Pose3.h>
#include <gtsam/linear/JacobianFactor.h>
#include <gtsam/nonlinear/NonlinearFactor.h>
#include <gtsam/nonlinear/NonlinearFactorGraph.h>
#include <gtsam/nonlinear/PriorFactor.h>
#include <gtsam/nonlinear/Values.h>
#include <gtsam/slam/BetweenFactor.h>

#include <holdfast/adapters/dataset.hpp>
#include <holdfast/adapters/term.hpp>
#include <holdfast/factors/between.hpp>
#include <holdfast/factors/prior.hpp>
#include <holdfast/factors/range.hpp>
#include <holdfast/factors/relative_point.hpp>
#include <iostream>

namespace holdfast {

// ---- variables

template <>
struct StandsFor<gtsam::Pose2> {
  using type = Pose2;
  static Pose2 ours(const gtsam::Pose2& p) { return {Vector<2>(p.x(), p.y()), Vector<2>(p.r().c(), p.r().s())}; }
  static gtsam::Pose2 theirs(const Pose2& p) { return gtsam::Pose2(gtsam::Rot2::fromCosSin(p.heading[0], p.heading[1]), gtsam::Point2(p.p)); }
};
template <>
struct StandsFor<gtsam::Pose3> {
  using type = Pose3;
  static Pose3 ours(const gtsam::Pose3& p) { return {Vector<3>(p.translation()), so3::Quaternion<double>(p.rotation().toQuaternion().normalized())}; }
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
inline Key holdfast_key(gtsam::Key key) { return {static_cast<char>(key >> 56), key & ((std::uint64_t{1} << 56) - 1)}; }

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
/// The same without types.
class GtsamSlot {
 public:
  virtual ~GtsamSlot() = default;
  int dim, ambient;
  virtual void read(const gtsam::Values& values, gtsam::Key key, double* x) const = 0;
  virtual void insert(gtsam::Values& values, gtsam::Key key, const double* x) const = 0;
  virtual void tangent(const double* x, double* D) const = 0;  ///< dim × dim, column-major
  virtual bool holds(const gtsam::Value& value) const = 0;
  virtual void insert(Values& values, Key key, const double* x) const = 0;

 protected:
  GtsamSlot(int dim_, int ambient_) : dim(dim_), ambient(ambient_) {}
};

template <class V>
class GtsamSlotOf final : public GtsamSlot {
  using G = GtsamVariable<V>;

 public:
  GtsamSlotOf() : GtsamSlot(V::dim, ambient_dim<V>) {}
  void read(const gtsam::Values& values, gtsam::Key key, double* x) const override {
    const V v = G::ours(values.at<typename G::type>(key));
    std::memcpy(x, &v, sizeof v);
  }
  void insert(gtsam::Values& values, gtsam::Key key, const double* x) const override {
    values.insert_or_assign(key, typename G::type(G::theirs(from(x))));
  }
  void tangent(const double* x, double* D) const override {
    const Matrix<V::dim, V::dim> all = G::tangent(from(x));
    std::copy_n(all.data(), all.size(), D);
  }
  bool holds(const gtsam::Value& value) const override { return dynamic_cast<const gtsam::GenericValue<typename G::type>*>(&value) != nullptr; }
  void insert(Values& values, Key key, const double* x) const override { values.insert(key, from(x)); }

 private:
  static V from(const double* x) {
    V v;
    std::memcpy(static_cast<void*>(&v), x, sizeof v);
    return v;
  }
};
template <class V>
const GtsamSlot* gtsam_slot() {
  static const GtsamSlotOf<V> slot;
  return &slot;
}
inline const GtsamSlot* gtsam_slot(std::type_index type) {
  static const std::pair<std::type_index, const GtsamSlot*> all[] = {
      {typeid(Pose2), gtsam_slot<Pose2>()},     {typeid(Pose3), gtsam_slot<Pose3>()},   {typeid(Point2), gtsam_slot<Point2>()},
      {typeid(Point3), gtsam_slot<Point3>()},   {typeid(Motion2), gtsam_slot<Motion2>()}, {typeid(Motion3), gtsam_slot<Motion3>()},
      {typeid(Accel2), gtsam_slot<Accel2>()},   {typeid(Accel3), gtsam_slot<Accel3>()}, {typeid(Scalar), gtsam_slot<Scalar>()}};
  for (const auto& [known, slot] : all)
    if (known == type) return slot;
  fail<BadType>("the variable type ", type.name(), " has no place in gtsam::Values known here; specialise GtsamVariable and use gtsam_factor");
}
}  // namespace detail

// ---- factors

/// A term of our cost as a factor of GTSAM.
class GtsamFactor : public gtsam::NonlinearFactor {
 public:
  /// A variable of the term: in gtsam::Values under the next key of the factor, or a constant of these coordinates.
  struct Variable {
    const detail::GtsamSlot* slot;
    std::vector<double> constant;  ///< empty: free
    Key constant_key;              ///< whose it is, for the way back
  };

  GtsamFactor(const Term& term, std::vector<Variable> variables, const gtsam::KeyVector& free_keys)
      : gtsam::NonlinearFactor(free_keys), term_(term), variables_(std::move(variables)) {}

  const Term& term() const { return term_; }
  const std::vector<Variable>& variables() const { return variables_; }

  using gtsam::NonlinearFactor::error;
  double error(const gtsam::Values& values) const override {
    std::vector<double> memory(ambient());
    Eigen::VectorXd r(term_.residual_dim());
    evaluate(values, memory, r.data(), nullptr);
    return term_.cost(r.data(), nullptr);
  }
  size_t dim() const override { return static_cast<size_t>(term_.residual_dim()); }

  gtsam::GaussianFactor::shared_ptr linearize(const gtsam::Values& values) const override {
    const int m = term_.residual_dim();
    std::vector<double> memory(ambient());
    Eigen::VectorXd r(m), weights(m);
    Eigen::MatrixXd J(m, term_.total_dim());
    evaluate(values, memory, r.data(), J.data());
    term_.cost(r.data(), weights.data());
    weights = weights.cwiseSqrt();
    std::vector<std::pair<gtsam::Key, gtsam::Matrix>> blocks;
    const double* x = memory.data();
    auto key = begin();
    int column = 0;
    for (const Variable& variable : variables_) {
      const int n = variable.slot->dim;
      if (variable.constant.empty()) {
        Eigen::MatrixXd D(n, n);
        variable.slot->tangent(x, D.data());
        blocks.emplace_back(*key++, weights.asDiagonal() * (J.middleCols(column, n) * D));
      }
      column += n;
      x += variable.slot->ambient;
    }
    return gtsam::GaussianFactor::shared_ptr(new gtsam::JacobianFactor(blocks, gtsam::Vector(-weights.cwiseProduct(r))));
  }

  gtsam::NonlinearFactor::shared_ptr clone() const override { return gtsam::NonlinearFactor::shared_ptr(new GtsamFactor(*this)); }
  void print(const std::string& text = "", const gtsam::KeyFormatter& formatter = gtsam::DefaultKeyFormatter) const override {
    std::cout << text << term_.batch().name() << " under " << term_.loss().str();
    for (const gtsam::Key key : keys()) std::cout << ' ' << formatter(key);
    std::cout << '\n';
  }

 private:
  std::size_t ambient() const {
    std::size_t sum = 0;
    for (const Variable& variable : variables_) sum += variable.slot->ambient;
    return sum;
  }
  void evaluate(const gtsam::Values& values, std::vector<double>& memory, double* r, double* J) const {
    std::vector<const double*> at;
    at.reserve(variables_.size());
    double* x = memory.data();
    auto key = begin();
    for (const Variable& variable : variables_) {
      if (variable.constant.empty())
        variable.slot->read(values, *key++, x);
      else
        std::copy(variable.constant.begin(), variable.constant.end(), x);
      at.push_back(x);
      x += variable.slot->ambient;
    }
    term_.evaluate(at.data(), r, J);
  }

  Term term_;
  std::vector<Variable> variables_;
};

namespace detail {
template <class F, std::size_t... I>
gtsam::NonlinearFactor::shared_ptr gtsam_factor(const Term& term, const gtsam::KeyVector& keys, std::index_sequence<I...>) {
  if (keys.size() != sizeof...(I)) fail<BadKey>(factor_name<F>(), " ties ", sizeof...(I), " variables, not ", keys.size(), "; give one key for each");
  return gtsam::NonlinearFactor::shared_ptr(
      new GtsamFactor(term, {GtsamFactor::Variable{gtsam_slot<typename F::Variables::template type<I>>(), {}, {}}...}, keys));
}
}  // namespace detail

/// With the factor's own default loss and weight, or with those given.
template <class F>
gtsam::NonlinearFactor::shared_ptr gtsam_factor(const F& factor, const gtsam::KeyVector& keys) {
  return detail::gtsam_factor<F>(Term(factor), keys, std::make_index_sequence<F::Variables::size>{});
}
template <class F>
gtsam::NonlinearFactor::shared_ptr gtsam_factor(const F& factor, const gtsam::KeyVector& keys, const Loss& loss, double weight = 1) {
  return detail::gtsam_factor<F>(Term(factor, loss, weight), keys, std::make_index_sequence<F::Variables::size>{});
}

// ---- values and whole graphs

inline gtsam::Values to_gtsam(const Values& values) {
  gtsam::Values theirs;
  Values x = values;
  for (const auto& pool : x.pools())
    for (int i = 0; i < pool->size(); ++i) detail::gtsam_slot(pool->type())->insert(theirs, gtsam_key(pool->keys()[i]), pool->data(i));
  return theirs;
}
/// GTSAM's values of the keys that `values` holds, into them.
inline void write_back(const gtsam::Values& theirs, Values& values) {
  for (const auto& pool : values.pools())
    for (int i = 0; i < pool->size(); ++i) detail::gtsam_slot(pool->type())->read(theirs, gtsam_key(pool->keys()[i]), pool->data(i));
}
/// Poses, points and numbers, and Vector4 as Motion2, Vector9 as Accel3. BadType names anything else: a Vector6 could be two things of ours.
inline Values from_gtsam(const gtsam::Values& theirs) {
  const detail::GtsamSlot* const known[] = {detail::gtsam_slot<Pose2>(),  detail::gtsam_slot<Pose3>(),  detail::gtsam_slot<Point2>(),
                                            detail::gtsam_slot<Point3>(), detail::gtsam_slot<Scalar>(), detail::gtsam_slot<Motion2>(),
                                            detail::gtsam_slot<Accel3>()};
  Values ours;
  for (const gtsam::Key key : theirs.keys()) {
    const gtsam::Value& value = theirs.at(key);
    const detail::GtsamSlot* slot = nullptr;
    for (const detail::GtsamSlot* one : known)
      if (one->holds(value)) slot = one;
    if (slot == nullptr) fail<BadType>("key ", holdfast_key(key), " holds ", typeid(value).name(), ", which is no one type of ours; insert it by hand, and use write_back");
    std::vector<double> x(slot->ambient);
    slot->read(theirs, key, x.data());
    slot->insert(ours, holdfast_key(key), x.data());
  }
  return ours;
}

namespace detail {
/// What files hold goes with its type, so that it can come back; anything else by its batch.
using FileFactors = std::tuple<Between<Pose2>, Between<Pose3>, Prior<Pose2>, Prior<Pose3>, Prior<Point2>, Prior<Point3>, RelativePoint<Pose2, Point2>,
                               RelativePoint<Pose3, Point3>, Range<Pose2, Pose2>, Range<Pose2, Point2>, Range<Point2, Pose2>, Range<Point2, Point2>,
                               Range<Pose3, Pose3>, Range<Pose3, Point3>, Range<Point3, Pose3>, Range<Point3, Point3>>;
template <class... F>
Term term_of(const FactorBatch& batch, int i, std::tuple<F...>*) {
  Term term(batch, i);
  (void)((batch.factor_type() == typeid(F) && (term = Term(static_cast<const Batch<F>&>(batch).factors()[i], batch.loss(), batch.weight(i)), true)) ||
         ...);
  return term;
}

inline gtsam::NonlinearFactorGraph to_gtsam(const Graph& graph, const Values& values, bool leave_out_constants) {
  gtsam::NonlinearFactorGraph theirs;
  Values x = values;
  for (const auto& batch : graph.batches())
    for (int i = 0; i < batch->size(); ++i) {
      std::vector<GtsamFactor::Variable> variables;
      gtsam::KeyVector keys;
      for (int k = 0; k < batch->arity(); ++k) {
        const Key key = batch->keys(i)[k];
        variables.push_back({gtsam_slot(batch->types()[k]), {}, key});
        if (graph.is_fixed(key)) {
          PoolBase& pool = x.pool(x.slot(key).pool);
          const double* at = pool.data(x.slot(key).index);
          variables.back().constant.assign(at, at + pool.ambient());
        } else {
          keys.push_back(gtsam_key(key));
        }
      }
      if (keys.empty() && leave_out_constants) continue;
      if (keys.empty()) fail<BadOption>("GTSAM cannot hold ", batch->describe(i), ": all its variables are fixed, and a factor needs a key; remove it");
      theirs.push_back(gtsam::NonlinearFactor::shared_ptr(
          new GtsamFactor(term_of(*batch, i, static_cast<FileFactors*>(nullptr)), std::move(variables), keys)));
    }
  return theirs;
}
}  // namespace detail

/// Every factor of the graph; fixed variables are constants in them, at `values`, and a factor of fixed variables alone is a BadOption. Factors
/// of types that no file has refer to `graph`.
inline gtsam::NonlinearFactorGraph to_gtsam(const Graph& graph, const Values& values) { return detail::to_gtsam(graph, values, false); }

namespace detail {
/// GTSAM's own BetweenFactor or PriorFactor of a pose; the information reordered to ours. False where it is neither.
template <class V>
bool add_native(const gtsam::NonlinearFactor& factor, Graph& graph) {
  using Theirs = typename GtsamVariable<V>::type;
  const auto* with_noise = dynamic_cast<const gtsam::NoiseModelFactor*>(&factor);
  if (with_noise == nullptr) return false;
  const auto* between = dynamic_cast<const gtsam::BetweenFactor<Theirs>*>(&factor);
  const auto* prior = dynamic_cast<const gtsam::PriorFactor<Theirs>*>(&factor);
  if (between == nullptr && prior == nullptr) return false;
  const auto* gaussian = dynamic_cast<const gtsam::noiseModel::Gaussian*>(with_noise->noiseModel().get());
  if (gaussian == nullptr)
    fail<BadOption>("a factor on ", holdfast_key(factor.keys()[0]), " has a noise model that is not Gaussian; give it a Gaussian one, and our loss to ours");
  const Matrix<V::dim, V::dim> D = GtsamVariable<V>::tangent(V()).inverse();  // theirs by ours, both in the frame of the measured pose
  const Matrix<V::dim, V::dim> I = D.transpose() * gaussian->information() * D;
  if (between != nullptr) {
    const V measured = GtsamVariable<V>::ours(between->measured());
    graph.add(Between<V>::from_information(measured, I), {holdfast_key(factor.keys()[0]), holdfast_key(factor.keys()[1])});
  } else {
    const V mean = GtsamVariable<V>::ours(prior->prior());
    const Matrix<V::dim, V::dim> K = GtsamVariable<V>::tangent(mean).inverse();  // our translation moves in the world
    graph.add(Prior<V>::from_information(mean, K.transpose() * gaussian->information() * K), {holdfast_key(factor.keys()[0])});
  }
  return true;
}
}  // namespace detail

/// Our factors come back as they went. GTSAM's own BetweenFactor and PriorFactor of poses under Gaussian noise become ours: of the same
/// error for Pose2, and for Pose3 of the same up to second order in it (GTSAM takes the logarithm of SE(3), we that of SO(3)). BadOption
/// names any other factor.
inline Graph from_gtsam(const gtsam::NonlinearFactorGraph& theirs) {
  Graph graph;
  for (const auto& factor : theirs) {
    if (!factor) continue;
    if (const auto* ours = dynamic_cast<const GtsamFactor*>(factor.get())) {
      std::vector<Key> keys;
      auto next = ours->begin();
      for (const GtsamFactor::Variable& variable : ours->variables()) {
        keys.push_back(variable.constant.empty() ? holdfast_key(*next++) : variable.constant_key);
        if (!variable.constant.empty()) graph.fix(keys.back());
      }
      ours->term().add_to(graph, keys);
    } else if (!detail::add_native<Pose2>(*factor, graph) && !detail::add_native<Pose3>(*factor, graph)) {
      fail<BadOption>("GTSAM's factor ", typeid(*factor).name(), " on ", holdfast_key(factor->keys()[0]), " has no counterpart here; write it as a struct of yours");
    }
  }
  return graph;
}

}  // namespace holdfast
