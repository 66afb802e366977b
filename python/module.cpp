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
  holdfast::python::bind_backends(m);
  holdfast::python::bind_answers(m);
  holdfast::python::bind_robust(m);
  holdfast::python::bind_starts(m);
  holdfast::python::bind_window(m);
  holdfast::python::bind_schedule(m);
  holdfast::python::bind_trust(m);
  holdfast::python::bind_incremental(m);
}
