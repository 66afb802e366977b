// What the properties (test_properties_*.cpp) draw their cases from. A case that fails is shrunk and printed with the seed that gives it
// again: RC_PARAMS='seed=…'; ctest runs them with a fixed one.
#pragma once

#include <gtest/gtest.h>
#include <rapidcheck.h>
#include <rapidcheck/gtest.h>

#include <cmath>
#include <cstring>
#include <random>

namespace holdfast::properties {

/// Source of whatever need not be shrunk.
inline std::mt19937_64 any_rng() { return std::mt19937_64(*rc::gen::arbitrary<std::uint64_t>().as("rng seed")); }

/// 10^low … 10^high, the exponent uniform.
inline double decades(int low, int high) { return std::pow(10.0, *rc::gen::inRange(100 * low, 100 * high + 1).as("100 log10") / 100.0); }

/// Any finite double, each exponent as likely as any other.
inline double any_finite(std::mt19937_64& rng) {
  for (;;) {
    const std::uint64_t bits = rng();
    double value;
    std::memcpy(&value, &bits, sizeof value);
    if (std::isfinite(value)) return value;
  }
}

}  // namespace holdfast::properties
