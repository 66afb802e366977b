#include "tests/draws/draws_of.hpp"

namespace holdfast::testing {
std::vector<Draw> linear_draws(std::mt19937_64& rng) { return draws_of<LinearFactors>(rng); }
}  // namespace holdfast::testing
