#include <algorithm>
#include <cmath>
#include <holdfast/benchmarks/suites/profile.hpp>

namespace holdfast::bench {

std::vector<std::vector<double>> performance_profile(const std::vector<std::vector<double>>& measures, const std::vector<double>& factors) {
  const std::size_t methods = measures.empty() ? 0 : measures.front().size();
  std::vector<std::vector<double>> profile(methods, std::vector<double>(factors.size(), 0));
  for (const std::vector<double>& problem : measures) {
    const double best = *std::min_element(problem.begin(), problem.end());
    for (std::size_t m = 0; m < methods; ++m)
      for (std::size_t k = 0; k < factors.size(); ++k)
        if (std::isfinite(problem[m]) && problem[m] <= factors[k] * best) profile[m][k] += 1.0 / static_cast<double>(measures.size());
  }
  return profile;
}

}  // namespace holdfast::bench
