// Robust solves of the program: thresholds from a probability of a false alarm, and the measurements that an answer rejects, by name.
#pragma once

#include <holdfast/common/run.hpp>
#include <holdfast/graph/graph.hpp>

namespace holdfast::program {

/// What a loss rejects depends on a threshold in sigmas. Not so of convex ones, of student_t, and of users' own (but dcs).
bool has_threshold(const Loss& loss);

/// Every loss that has a threshold gets √ of the (1 − alpha) quantile of χ² with as many degrees of freedom as its
/// factor has components: one true measurement in 1/alpha is rejected, whatever it measures.
void set_thresholds(Graph& graph, double alpha);

/// "rejected by irls: Between(x3, x90) χ² = 812 (3 components, p = 1e-175), …": the worst first, 20 of them and how many more; into `run`
/// all of them. "" where no loss rejects anything.
std::string rejected_list(const Graph& graph, const Values& answer, common::Json& run);

}  // namespace holdfast::program
