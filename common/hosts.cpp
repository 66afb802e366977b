#include <holdfast/common/hosts.hpp>
#ifdef HOLDFAST_WITH_GTSAM
#include <holdfast/adapters/gtsam/backend.hpp>
#endif
#ifdef HOLDFAST_WITH_G2O
#include <holdfast/adapters/g2o/backend.hpp>
#endif

namespace holdfast::common {

void register_hosts() {
#ifdef HOLDFAST_WITH_GTSAM
  register_gtsam_backends();
#endif
#ifdef HOLDFAST_WITH_G2O
  register_g2o_backends();
#endif
}

}  // namespace holdfast::common
