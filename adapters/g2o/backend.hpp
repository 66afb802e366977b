// g2o's optimizers as back-ends of ours: "g2o" (Gauss–Newton) and "g2o-lm" (Levenberg–Marquardt), with CHOLMOD where g2o has it
// (HOLDFAST_G2O_CHOLMOD), else Eigen's sparse Cholesky.
//
//   register_g2o_backends();
//   make_backend("g2o")->solve(graph, values);
//
// Blocks of fixed size where all free variables are of 3 or of 6 dimensions; edges of fixed size between poses and for ranges. The stopping
// rule is cost_tolerance; g2o's Gauss–Newton has no safeguard: a run that ends above its start is a failure.
#pragma once

namespace holdfast {

void register_g2o_backends();

}  // namespace holdfast
