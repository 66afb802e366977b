#include "tests/draws/draws_of.hpp"

namespace holdfast::testing {
std::vector<Draw> direction_draws(std::mt19937_64& rng) { return draws_of<DirectionFactors>(rng); }
}  // namespace holdfast::testing
