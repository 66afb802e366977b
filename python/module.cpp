#include "bind.hpp"

NB_MODULE(_core, m) {
  m.doc() = "Robust factors for multi-agent state estimation, and back-ends that any of them runs on.";
  holdfast::python::bind_variables(m);
  holdfast::python::bind_graph(m);
  holdfast::python::bind_pose_factors(m);
  holdfast::python::bind_range_factors(m);
  holdfast::python::bind_radio_factors(m);
  holdfast::python::bind_bearing_factors(m);
  holdfast::python::bind_motion_factors(m);
  holdfast::python::bind_solvers(m);
  holdfast::python::bind_incremental(m);
}
