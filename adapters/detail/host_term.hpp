// A term of our cost in a foreign graph: what the adapters of libraries with variable types of their own (GTSAM, g2o) have in common.
// Such a library is called the host here.
#pragma once

#include <holdfast/adapters/detail/term.hpp>
#include <holdfast/graph/variables.hpp>

namespace holdfast::detail {

/// How a host keeps variables of one type, without the type.
class HostSlot {
 public:
  virtual ~HostSlot() = default;
  int dim, ambient;
  virtual void tangent(const double* x, double* D) const = 0;  ///< d (our tangent) / d (the host's), dim × dim, column-major

 protected:
  HostSlot(int dim_, int ambient_) : dim(dim_), ambient(ambient_) {}
};

template <class V>
V from_ambient(const double* x) {
  V v;
  std::memcpy(static_cast<void*>(&v), x, sizeof v);
  return v;
}
template <class V>
void to_ambient(const V& v, double* x) {
  std::memcpy(x, &v, sizeof v);
}

/// Host: GtsamVariable<V> or G2oVariable<V>, which say how that host keeps a V.
template <class Slot, class Host, class V>
class HostSlotOf : public Slot {
 public:
  void tangent(const double* x, double* D) const override {
    const Matrix<V::dim, V::dim> all = Host::tangent(from_ambient<V>(x));
    std::copy_n(all.data(), all.size(), D);
  }

 protected:
  HostSlotOf() : Slot(V::dim, ambient_dim<V>) {}
};

template <class Slot>
const Slot* the_slot() {
  static const Slot slot;
  return &slot;
}

/// The slot of a type of variables.hpp; BadType names any other.
template <class Slot, template <class> class SlotOf>
const Slot* slot_of(std::type_index type, const char* name) {
  static const std::pair<std::type_index, const Slot*> all[] = {
      {typeid(Pose2), the_slot<SlotOf<Pose2>>()},     {typeid(Pose3), the_slot<SlotOf<Pose3>>()},
      {typeid(Point2), the_slot<SlotOf<Point2>>()},   {typeid(Point3), the_slot<SlotOf<Point3>>()},
      {typeid(Motion2), the_slot<SlotOf<Motion2>>()}, {typeid(Motion3), the_slot<SlotOf<Motion3>>()},
      {typeid(Accel2), the_slot<SlotOf<Accel2>>()},   {typeid(Accel3), the_slot<SlotOf<Accel3>>()},
      {typeid(Scalar), the_slot<SlotOf<Scalar>>()},   {typeid(Turning2), the_slot<SlotOf<Turning2>>()}};
  for (const auto& [known, slot] : all)
    if (known == type) return slot;
  fail<BadType>("variables of type ", name, " have no known place in ", Slot::cure());
}

/// A term and how its host keeps its variables.
template <class Slot>
struct HostTerm {
  Term term;
  std::vector<const Slot*> slots;

  std::size_t ambient() const {
    std::size_t sum = 0;
    for (const Slot* slot : slots) sum += slot->ambient;
    return sum;
  }
  /// read(k, x): the memory of variable k, which goes to x, one variable after the other. r, and unless it is null J with respect to our
  /// tangents.
  template <class Read>
  void evaluate(const Read& read, std::vector<double>& x, double* r, double* J) const {
    x.resize(ambient());
    std::vector<const double*> at(slots.size());
    double* next = x.data();
    for (std::size_t k = 0; k < slots.size(); ++k) {
      read(k, next);
      at[k] = next;
      next += slots[k]->ambient;
    }
    term.evaluate(at.data(), r, J);
  }
  /// use(k, J_k): the columns of variable k, with respect to the host's tangent.
  template <class Use>
  void each_block(const std::vector<double>& x, const Eigen::MatrixXd& J, const Use& use) const {
    const double* at = x.data();
    int column = 0;
    for (std::size_t k = 0; k < slots.size(); ++k) {
      const int n = slots[k]->dim;
      Eigen::MatrixXd D(n, n);
      slots[k]->tangent(at, D.data());
      use(k, J.middleCols(column, n) * D);
      column += n;
      at += slots[k]->ambient;
    }
  }
};

template <class Slot, template <class> class SlotOf, class F, std::size_t... I>
HostTerm<Slot> host_term(const Term& term, std::index_sequence<I...>) {
  return {term, {the_slot<SlotOf<typename F::Variables::template type<I>>>()...}};
}
template <class Slot, template <class> class SlotOf>
HostTerm<Slot> host_term(const Term& term) {
  HostTerm<Slot> in_host{term, {}};
  for (int k = 0; k < term.arity(); ++k)
    in_host.slots.push_back(slot_of<Slot, SlotOf>(term.batch().types()[k], term.batch().type_names()[k]));
  return in_host;
}

}  // namespace holdfast::detail
