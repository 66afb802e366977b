// Random numbers that are the same with every standard library: the engine is specified, std::normal_distribution is not.
#pragma once

#include <cmath>
#include <cstdint>
#include <holdfast/graph/math.hpp>
#include <random>

namespace holdfast::bench {

class Random {
 public:
  explicit Random(std::uint64_t seed) : engine_(seed) {}

  /// In [0, 1).
  double uniform() { return static_cast<double>(engine_() >> 11) * 0x1p-53; }
  double uniform(double low, double high) { return low + (high - low) * uniform(); }
  int index(int size) { return static_cast<int>(uniform() * size); }
  bool chance(double probability) { return uniform() < probability; }

  /// N(0, 1), by Box and Muller. One of the pair is thrown away: the state is the engine's alone.
  double normal() {
    const double radius = std::sqrt(-2 * std::log1p(-uniform()));
    return radius * std::cos(2 * kPi * uniform());
  }
  // Vectors are drawn in order here, since the order in which a compiler evaluates two arguments is its own.
  template <int N>
  Vector<N> uniforms(double low, double high) {
    Vector<N> v;
    for (int i = 0; i < N; ++i) v[i] = uniform(low, high);
    return v;
  }
  template <int N>
  Vector<N> normals(double sigma) {
    Vector<N> v;
    for (int i = 0; i < N; ++i) v[i] = sigma * normal();
    return v;
  }

 private:
  std::mt19937_64 engine_;
};

}  // namespace holdfast::bench
