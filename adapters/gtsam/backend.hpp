// GTSAM's optimizers as back-ends of ours: "gtsam-lm" (Levenberg–Marquardt) and "gtsam-gn" (Gauss–Newton), both with GTSAM's multifrontal
// Cholesky.
//
//   register_gtsam_backends();
//   make_backend("gtsam-lm")->solve(graph, values);
//
// Our factors in GTSAM's graph (gtsam.hpp), fixed variables as constants in them. cost_tolerance is GTSAM's relativeErrorTol; it has no
// gradient_tolerance. A run that ends above its start, which Gauss–Newton may, is a failure.
#pragma once

namespace holdfast {

void register_gtsam_backends();

}  // namespace holdfast
