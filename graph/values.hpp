// Values: the variables of a graph by key. Each type lives in its own contiguous pool.
//
// References. What at() returns, data() and a Slot are valid until a variable of the same type is inserted or erased, or the values are
// assigned to or moved from; a solver writes to the variables where they are. update() and at() = … invalidate nothing.
// Threads. Any number may call const members at once; a non-const member needs the values for itself. No state is shared between Values.
#pragma once

#include <cstring>
#include <holdfast/graph/detail/local_jacobian.hpp>
#include <holdfast/graph/error.hpp>
#include <holdfast/graph/key.hpp>
#include <holdfast/graph/variables.hpp>
#include <memory>
#include <typeindex>
#include <unordered_map>
#include <utility>
#include <vector>

namespace holdfast {

/// One pool of variables of one type; what solvers and writers need of it without knowing the type.
class PoolBase {
 public:
  virtual ~PoolBase() = default;
  virtual std::type_index type() const = 0;
  virtual const char* type_name() const = 0;
  virtual int dim() const = 0;
  virtual int ambient() const = 0;  ///< doubles per variable
  virtual int space() const = 0;    ///< 2 or 3; 0 without a position
  virtual bool is_vector_space() const = 0;
  virtual const PoolBase& kind() const = 0;  ///< Pool<V>::prototype()
  virtual std::unique_ptr<PoolBase> clone() const = 0;
  virtual void assign(const PoolBase& other) = 0;  ///< copies the variables, not the keys; of as many, allocates nothing
  virtual void retract(int i, const PoolBase& from, const double* delta) = 0;  ///< this[i] = from[i] ⊕ δ
  virtual void local(int i, const PoolBase& other, double* delta) const = 0;   ///< δ = other[i] ⊖ this[i]
  /// The same on ambient coordinates that live elsewhere (foreign solvers own their memory).
  virtual void retract_ambient(const double* x, const double* delta, double* out) const = 0;
  virtual void local_ambient(const double* from, const double* to, double* delta) const = 0;
  virtual void local_jacobian_ambient(const double* from, const double* to, double* J) const = 0;  ///< d local(to ⊕ δ) / dδ, column-major
  virtual bool is_finite(int i) const = 0;
  virtual void print(int i, std::ostream& out) const = 0;
  virtual double* data(int i) = 0;  ///< the ambient coordinates
  const double* data(int i) const { return const_cast<PoolBase*>(this)->data(i); }
  virtual void position(int i, double* p) const = 0;
  virtual void rigid_motion(int i, const double* v, const double* w, double* motion) const = 0;
  virtual void remove(int i) = 0;                          ///< the last one takes its place
  virtual void remove(const std::vector<char>& gone) = 0;  ///< every i where gone[i]; the others keep their order
  virtual void push_ambient(Key key, const double* x) = 0;

  const std::vector<Key>& keys() const { return keys_; }
  int size() const { return static_cast<int>(keys_.size()); }

 protected:
  friend class Values;
  std::vector<Key> keys_;
};

template <class V>
class Pool final : public PoolBase {
  static_assert(std::is_standard_layout_v<V> && sizeof(V) % sizeof(double) == 0, "a variable is a plain struct of doubles");

 public:
  std::type_index type() const override { return typeid(V); }
  const char* type_name() const override { return V::name(); }
  int dim() const override { return V::dim; }
  int ambient() const override { return ambient_dim<V>; }
  int space() const override { return space_dim<V>; }
  bool is_vector_space() const override { return holdfast::is_vector_space<V>; }
  const PoolBase& kind() const override { return prototype(); }
  std::unique_ptr<PoolBase> clone() const override { return std::make_unique<Pool>(*this); }
  void assign(const PoolBase& other) override { values_ = static_cast<const Pool&>(other).values_; }
  void retract(int i, const PoolBase& from, const double* delta) override {
    values_[i] = static_cast<const Pool&>(from).values_[i].retract(Eigen::Map<const Vector<V::dim>>(delta));
  }
  void local(int i, const PoolBase& other, double* delta) const override {
    Eigen::Map<Vector<V::dim>>(delta, V::dim) = values_[i].local(static_cast<const Pool&>(other).values_[i]);
  }
  void retract_ambient(const double* x, const double* delta, double* out) const override {
    const V moved = from_ambient(x).retract(Eigen::Map<const Vector<V::dim>>(delta));
    std::memcpy(out, &moved, sizeof(V));
  }
  void local_ambient(const double* from, const double* to, double* delta) const override {
    Eigen::Map<Vector<V::dim>>(delta, V::dim) = from_ambient(from).local(from_ambient(to));
  }
  void local_jacobian_ambient(const double* from, const double* to, double* J) const override {
    Eigen::Map<Matrix<V::dim, V::dim>>(J, V::dim, V::dim) = local_jacobian(from_ambient(from), from_ambient(to));
  }
  bool is_finite(int i) const override { return values_[i].is_finite(); }
  void print(int i, std::ostream& out) const override { detail::print_variable(out, values_[i]); }
  double* data(int i) override { return reinterpret_cast<double*>(&values_[i]); }
  void position(int i, double* p) const override {
    if constexpr (space_dim < V >> 0) Eigen::Map<Vector<space_dim<V>>>(p, space_dim<V>) = values_[i].position();
  }
  void rigid_motion(int i, const double* v, const double* w, double* motion) const override {
    Eigen::Map<Vector<V::dim>> out(motion, V::dim);
    if constexpr (space_dim < V >> 0)
      out = values_[i].rigid_motion(Eigen::Map<const Vector<space_dim<V>>>(v), Eigen::Map<const Vector<rotation_dim<space_dim<V>>>>(w));
    else
      out.setZero();
  }
  void remove(int i) override {
    values_[i] = values_.back();
    values_.pop_back();
    keys_[i] = keys_.back();
    keys_.pop_back();
  }
  void remove(const std::vector<char>& gone) override {
    std::size_t kept = 0;
    for (std::size_t i = 0; i < keys_.size(); ++i) {
      if (gone[i]) continue;
      values_[kept] = values_[i];
      keys_[kept++] = keys_[i];
    }
    values_.resize(kept);
    keys_.resize(kept);
  }
  void push_ambient(Key key, const double* x) override {
    values_.push_back(from_ambient(x));
    keys_.push_back(key);
  }

  /// An empty pool: what is known of the type V, for those who meet its variables without knowing it.
  static const PoolBase& prototype();

  std::vector<V>& values() { return values_; }
  const std::vector<V>& values() const { return values_; }

 private:
  friend class Values;
  static V from_ambient(const double* x) {
    V v;
    std::memcpy(static_cast<void*>(&v), x, sizeof(V));
    return v;
  }
  static const bool entered_;

  std::vector<V> values_;
};

/// The prototype of the variable type of this name ("Pose2"); null where this program has no code that inserts one.
const PoolBase* find_variable_type(std::string_view name);
/// Enters a type; a program's own types are entered before main().
bool enter_variable_type(const PoolBase& prototype);

template <class V>
const PoolBase& Pool<V>::prototype() {
  (void)entered_;
  static const Pool pool;
  return pool;
}
template <class V>
const bool Pool<V>::entered_ = enter_variable_type(Pool<V>::prototype());

// Compiled into the library (graph/pools.cpp), not anew by whoever inserts such variables.
extern template class Pool<Point2>;
extern template class Pool<Point3>;
extern template class Pool<Pose2>;
extern template class Pool<Pose3>;
extern template class Pool<Motion2>;
extern template class Pool<Motion3>;
extern template class Pool<Accel2>;
extern template class Pool<Accel3>;
extern template class Pool<Turning2>;
extern template class Pool<Scalar>;

/// A type of another library that Values takes and gives in place of one of ours. An adapter specialises it with
///   using type = Pose2;  static Pose2 ours(const T&);  static T theirs(const Pose2&);
template <class T>
struct StandsFor;

namespace detail {
template <class T, class = void>
struct IsForeign : std::false_type {};
template <class T>
struct IsForeign<T, std::void_t<typename StandsFor<T>::type>> : std::true_type {};
template <class T, class Result>
using IfOurs = std::enable_if_t<!IsForeign<T>::value, Result>;
template <class T>
using IfForeign = std::enable_if_t<IsForeign<T>::value, T>;
}  // namespace detail

class Values {
 public:
  Values();
  Values(const Values& other);
  Values(Values&& other) noexcept;
  Values& operator=(const Values& other);
  Values& operator=(Values&& other) noexcept;

  /// Throws BadKey where the key is there already.
  template <class V>
  void insert(Key key, const V& value) {
    if constexpr (detail::IsForeign<V>::value)
      insert(key, StandsFor<V>::ours(value));
    else
      insert_ambient(key, Pool<V>::prototype(), reinterpret_cast<const double*>(&value));
  }
  /// Throws BadKey where the key is missing, BadType where it holds another type.
  template <class V>
  void update(Key key, const V& value) {
    if constexpr (detail::IsForeign<V>::value)
      update(key, StandsFor<V>::ours(value));
    else
      at<V>(key) = value;
  }
  template <class V>
  detail::IfOurs<V, V&> at(Key key) {
    return static_cast<Pool<V>&>(*pools_[checked(key, typeid(V), V::name()).pool]).values_[slot(key).index];
  }
  template <class V>
  detail::IfOurs<V, const V&> at(Key key) const {
    return static_cast<const Pool<V>&>(*pools_[checked(key, typeid(V), V::name()).pool]).values_[slot(key).index];
  }
  template <class V>
  detail::IfForeign<V> at(Key key) const {
    return StandsFor<V>::theirs(at<typename StandsFor<V>::type>(key));
  }
  void erase(Key key);  ///< the last one of its type takes its place
  /// Several at once; the others keep their order. Throws BadKey, and then nothing is erased.
  void erase(const std::vector<Key>& keys);
  /// A variable from its ambient coordinates, of the type of a pool (Pool<V>::prototype()) that the caller may not know.
  void insert_ambient(Key key, const PoolBase& type, const double* x);
  /// The number of the pool of this type, made where there is none: whoever fills a Values from a file keeps the order of its pools.
  int pool_of(const PoolBase& type);

  bool contains(Key key) const { return slots_.count(key) != 0; }
  template <class V>
  bool contains(Key key) const {
    const auto it = slots_.find(key);
    return it != slots_.end() && pools_[it->second.pool]->type() == typeid(V);
  }
  /// fn(Key, const V&) for every variable of type V, in the order they are kept in.
  template <class V, class Fn>
  void for_each(Fn&& fn) const {
    for (const auto& pool : pools_)
      if (pool->type() == typeid(V))
        for (int i = 0; i < pool->size(); ++i) fn(pool->keys()[i], static_cast<const Pool<V>&>(*pool).values_[i]);
  }
  std::size_t size() const { return slots_.size(); }
  std::vector<Key> keys() const;  ///< sorted

  /// Where a variable lives.
  struct Slot {
    int pool;
    int index;
  };
  const Slot& slot(Key key) const;  ///< throws BadKey
  const std::vector<std::unique_ptr<PoolBase>>& pools() const { return pools_; }
  const PoolBase& pool(int i) const { return *pools_[i]; }
  PoolBase& pool(int i) { return *pools_[i]; }
  /// The variables of type V side by side; null where there are none.
  template <class V>
  const V* data() const {
    for (const auto& pool : pools_)
      if (pool->type() == typeid(V)) return static_cast<const Pool<V>&>(*pool).values_.data();
    return nullptr;
  }

  /// Changes whenever a key comes or goes; two Values with the same stamp have the same keys in the same slots.
  std::uint64_t structure() const { return structure_; }
  /// Copies the variables of a Values of the same structure; allocates nothing. (Nor does `=`, of no more variables of the same types than
  /// before.)
  void assign(const Values& other);

 private:
  void require_new(Key key) const;
  void claim(Key key, int pool);
  void place(Key key, const Slot& slot);
  void forget(Key key);
  void take_structure(const Values& other);
  const Slot& checked(Key key, std::type_index type, const char* type_name) const;

  std::vector<std::unique_ptr<PoolBase>> pools_;
  using Slots = std::unordered_map<Key, Slot>;
  Slots slots_;
  std::vector<Slots::node_type> spare_;  ///< of erased keys: a window that moves on allocates nothing
  std::vector<char> gone_;
  std::uint64_t structure_;
};

/// A number no other structure of this process has.
std::uint64_t new_structure_stamp();

}  // namespace holdfast
