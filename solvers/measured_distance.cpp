#include <array>
#include <cmath>
#include <cstring>
#include <holdfast/graph/variables.hpp>
#include <holdfast/solvers/internal/measured_distance.hpp>

namespace holdfast::detail {
namespace {

using Ambient = std::array<double, 16>;

template <class V>
Ambient ambient_of(const V& x) {
  static_assert(sizeof(V) <= sizeof(Ambient));
  Ambient ambient{};
  std::memcpy(ambient.data(), static_cast<const void*>(&x), sizeof(V));
  return ambient;
}

/// A state of this type at p, turned by `turn`.
template <int n>
std::optional<Ambient> state_at(std::type_index type, const Vector<n>& p, double turn) {
  using Point = std::conditional_t<n == 2, Point2, Point3>;
  using Pose = std::conditional_t<n == 2, Pose2, Pose3>;
  if (type == typeid(Point)) return ambient_of(Point(p));
  if (type != typeid(Pose)) return std::nullopt;
  Vector<Pose::dim> delta = Vector<Pose::dim>::Constant(turn);
  delta.template head<n>() = p;
  return ambient_of(Pose{}.retract(delta));
}

/// The residual with the positions so far apart.
template <int n>
std::optional<double> residual(const FactorBatch& batch, int i, double distance, int trial) {
  const Vector<n> from = Vector<n>::LinSpaced(0.3, 1.7) * trial;
  const Vector<n> way = Vector<n>::LinSpaced(1.0 + trial, -0.4).normalized();
  const auto a = state_at<n>(batch.types()[0], from, 0.4 * trial), b = state_at<n>(batch.types()[1], from + distance * way, -0.7 * trial);
  if (!a || !b) return std::nullopt;
  const double* const ambient[] = {a->data(), b->data()};
  double r = 0;
  batch.evaluate_at(i, ambient, &r, nullptr);
  return r;
}

template <int n>
std::optional<MeasuredDistance> measured(const FactorBatch& batch, int i) {
  constexpr double kFar = 1024;  // [m]
  const auto near = residual<n>(batch, i, 0, 1), far = residual<n>(batch, i, kFar, 2);
  if (!near || !far || !(*far > *near)) return std::nullopt;
  const double sigma = kFar / (*far - *near), distance = -*near * sigma;
  if (!(distance >= 0)) return std::nullopt;
  int trial = 3;
  for (const double length : {0.01, 0.5 * distance, distance, 2 * distance, 100.0}) {
    const auto r = residual<n>(batch, i, length, trial++);
    if (!r || !(std::abs(*r * sigma - (length - distance)) <= 1e-9 * (kFar + distance))) return std::nullopt;
  }
  return MeasuredDistance{distance, sigma};
}

}  // namespace

std::optional<MeasuredDistance> measured_distance(const FactorBatch& batch, int i) {
  if (batch.arity() != 2 || batch.residual_dim() != 1) return std::nullopt;
  const auto planar = measured<2>(batch, i);
  return planar ? planar : measured<3>(batch, i);
}

}  // namespace holdfast::detail
