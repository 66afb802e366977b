#include "tests/draws/draws_of.hpp"

namespace holdfast::testing {
std::vector<Draw> range_draws(std::mt19937_64& rng) { return draws_of<RangeFactors>(rng); }
}  // namespace holdfast::testing
