// The optimizers of other libraries as back-ends, as far as this build has them.
#pragma once

namespace holdfast::common {

/// Enters "gtsam-lm", "gtsam-gn", "g2o" and "g2o-lm".
void register_hosts();

}  // namespace holdfast::common
