// Random numbers that are the same with every standard library: the engine is specified, std::normal_distribution is not.
#pragma once

#include <cmath>
#include <holdfast/graph/math.hpp>
#include <random>

namespace holdfast::detail {

/// In [0, 1), 53 bits.
inline double uniform(std::mt19937_64& engine) { return static_cast<double>(engine() >> 11) * 0x1p-53; }

/// N(0, 1), by Box and Muller. One of the pair is thrown away: the state is the engine's alone.
inline double normal(std::mt19937_64& engine) {
  const double radius = std::sqrt(-2 * std::log(1 - uniform(engine)));  // 1 − u > 0
  return radius * std::cos(2 * kPi * uniform(engine));
}

}  // namespace holdfast::detail
