#include "tests/draws/draws_of.hpp"

namespace holdfast::testing {
std::vector<Draw> state_draws(std::mt19937_64& rng) { return draws_of<StateFactors>(rng); }
}  // namespace holdfast::testing
