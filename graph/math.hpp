// Fixed-size linear algebra of holdfast.
//
// Every fixed-size type is Eigen::DontAlign: its size and alignment do not depend on -march, so a program compiled with
// AVX and a library compiled without it agree on the layout of every factor and every variable. Eigen still
// vectorises them (with unaligned loads, which cost nothing on current processors).
#pragma once

#include <Eigen/Core>
#include <cmath>

namespace holdfast {

template <class T, int N>
using VectorT = Eigen::Matrix<T, N, 1, Eigen::DontAlign>;
template <class T, int Rows, int Cols>
using MatrixT = Eigen::Matrix<T, Rows, Cols, (Rows == 1 && Cols != 1 ? Eigen::RowMajor : Eigen::ColMajor) | Eigen::DontAlign>;

template <int N>
using Vector = VectorT<double, N>;
template <int Rows, int Cols>
using Matrix = MatrixT<double, Rows, Cols>;

inline constexpr double kPi = 3.14159265358979323846;

/// Below this distance [m] range and bearing are at their singular point (conventions, "Zero distance").
inline constexpr double kZeroDistance = 1e-9;

/// The same angle in (−π, π] [rad].
inline double wrap_angle(double angle) {
  const double wrapped = std::remainder(angle, 2 * kPi);
  return wrapped <= -kPi ? kPi : wrapped;
}

}  // namespace holdfast
