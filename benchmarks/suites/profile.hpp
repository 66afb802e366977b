// Performance profiles (Dolan & Moré, "Benchmarking optimization software with performance profiles", Math. Programming 2002): of each
// method, the share of all problems that it solves within a factor of what the best method takes on that problem.
#pragma once

#include <vector>

namespace holdfast::bench {

/// measures[p][m]: what method m takes on problem p (> 0), infinite where it fails. Returned: profile[m][k], the share of problems with
/// measures[p][m] <= factors[k] min over m of measures[p][m]. A problem that nobody solves counts, and for nobody. Each problem must have
/// the same methods; no problems give shares of 0.
std::vector<std::vector<double>> performance_profile(const std::vector<std::vector<double>>& measures, const std::vector<double>& factors);

}  // namespace holdfast::bench
