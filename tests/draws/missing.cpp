#include "tests/draws/draws_of.hpp"

namespace holdfast::testing {
std::vector<Draw> missing_draws(std::mt19937_64& rng) { return draws_of<MissingFactors>(rng); }
}  // namespace holdfast::testing
