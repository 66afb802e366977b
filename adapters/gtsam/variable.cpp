#include <holdfast/adapters/gtsam/variable.hpp>

namespace holdfast {
namespace detail {

template class GtsamSlotOf<Pose2>;
template class GtsamSlotOf<Pose3>;
template class GtsamSlotOf<Point2>;
template class GtsamSlotOf<Point3>;
template class GtsamSlotOf<Scalar>;
template class GtsamSlotOf<Motion2>;
template class GtsamSlotOf<Motion3>;
template class GtsamSlotOf<Accel2>;
template class GtsamSlotOf<Accel3>;
template class GtsamSlotOf<Turning2>;

const GtsamSlot* gtsam_slot(const PoolBase& pool) { return slot_of<GtsamSlot, GtsamSlotOf>(pool.type(), pool.type_name()); }
HostTerm<GtsamSlot> gtsam_term(const Term& term) { return host_term<GtsamSlot, GtsamSlotOf>(term); }

}  // namespace detail

gtsam::Values to_gtsam(const Values& values) {
  gtsam::Values theirs;
  for (const auto& pool : values.pools())
    for (int i = 0; i < pool->size(); ++i)
      detail::gtsam_slot(*pool)->insert(theirs, gtsam_key(pool->keys()[i]), std::as_const(*pool).data(i));
  return theirs;
}

void write_back(const gtsam::Values& theirs, Values& values) {
  for (const auto& pool : values.pools())
    for (int i = 0; i < pool->size(); ++i) detail::gtsam_slot(*pool)->read(theirs, gtsam_key(pool->keys()[i]), pool->data(i));
}

Values from_gtsam(const gtsam::Values& theirs) {
  using namespace detail;
  const GtsamSlot* const known[] = {the_slot<GtsamSlotOf<Pose2>>(),    the_slot<GtsamSlotOf<Pose3>>(),  the_slot<GtsamSlotOf<Point2>>(),
                                    the_slot<GtsamSlotOf<Point3>>(),   the_slot<GtsamSlotOf<Scalar>>(), the_slot<GtsamSlotOf<Motion2>>(),
                                    the_slot<GtsamSlotOf<Turning2>>(), the_slot<GtsamSlotOf<Accel3>>()};
  Values ours;
  for (const gtsam::Key key : theirs.keys()) {
    const gtsam::Value& value = theirs.at(key);
    const auto slot = std::find_if(std::begin(known), std::end(known), [&](const GtsamSlot* one) { return one->holds(value); });
    if (slot == std::end(known))
      fail<BadType>("key ", holdfast_key(key), " holds ", demangled(typeid(value)),
                    ", which is no one type of ours; insert it by hand, and use write_back");
    std::vector<double> x((*slot)->ambient);
    (*slot)->read(theirs, key, x.data());
    (*slot)->insert(ours, holdfast_key(key), x.data());
  }
  return ours;
}

}  // namespace holdfast
