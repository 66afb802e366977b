// Every back-end that this build can solve with: those of the library, those of other libraries that are on, and GNC round one of them.
#pragma once

#include <holdfast/solvers/table.hpp>
#ifdef HOLDFAST_WITH_GTSAM
#include <holdfast/adapters/gtsam/backend.hpp>
#endif
#ifdef HOLDFAST_WITH_G2O
#include <holdfast/adapters/g2o/backend.hpp>
#endif
#ifdef HOLDFAST_WITH_MPI
#include <holdfast/solvers/distributed/backends.hpp>
#endif

namespace holdfast::testing {

/// GNC round irls: its max_iterations holds for each of its inner solves.
inline const std::string kGnc = "gnc-irls";

inline const std::vector<std::string>& every_backend() {
  static const std::vector<std::string> names = [] {
#ifdef HOLDFAST_WITH_GTSAM
    register_gtsam_backends();
#endif
#ifdef HOLDFAST_WITH_G2O
    register_g2o_backends();
#endif
#ifdef HOLDFAST_WITH_MPI
    register_mpi_backends();
#endif
    std::vector<std::string> all = backend_names();
    all.push_back(kGnc);
    return all;
  }();
  return names;
}

}  // namespace holdfast::testing
