// What scenarios draw: the same with every standard library (graph/detail/random.hpp).
#pragma once

#include <cmath>
#include <cstdint>
#include <holdfast/graph/detail/random.hpp>

namespace holdfast::bench {

class Random {
 public:
  explicit Random(std::uint64_t seed) : engine_(seed) {}

  /// In [0, 1).
  double uniform() { return detail::uniform(engine_); }
  double uniform(double low, double high) { return low + (high - low) * uniform(); }
  int index(int size) { return static_cast<int>(uniform() * size); }
  bool chance(double probability) { return uniform() < probability; }

  /// N(0, 1).
  double normal() { return detail::normal(engine_); }
  /// Γ(shape, 1), by Marsaglia and Tsang (2000); shape > 0.
  double gamma(double shape) {
    if (shape < 1) {
      const double larger = gamma(shape + 1);
      return larger * std::pow(1 - uniform(), 1 / shape);
    }
    const double d = shape - 1.0 / 3, c = 1 / std::sqrt(9 * d);
    while (true) {
      const double x = normal(), v = std::pow(1 + c * x, 3);
      if (v > 0 && std::log1p(-uniform()) < 0.5 * x * x + d - d * v + d * std::log(v)) return d * v;
    }
  }
  /// √(ν/χ²_ν): what a normal vector is scaled by to be Student's t with ν degrees of freedom.
  double student_scale(double nu) { return std::sqrt(0.5 * nu / gamma(0.5 * nu)); }
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
