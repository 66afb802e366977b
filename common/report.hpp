// Lines of results as tables for people.
#pragma once

#include <holdfast/common/run.hpp>
#include <ostream>

namespace holdfast::common {

/// The back-ends on one problem: a row a run.
void print_solve(std::ostream& out, const std::vector<Json>& runs);

/// A suite: a row a run, problem by problem, times also relative to ceres'.
void print_suite(std::ostream& out, const std::vector<Json>& runs);

/// Says of each problem whose runs end at different costs (differs()) which ones do, and what is known of why ("ends" of a run:
/// program/second_look.hpp); nothing where all agree.
void print_differences(std::ostream& out, const std::vector<Json>& runs);

/// Costs of two answers that count as the same minimum.
inline constexpr double kSameCost = 1e-6;
/// True where a cost is higher than the best by more than that, and by more than two exact fits differ by rounding.
bool differs(double cost, double best);

}  // namespace holdfast::common
