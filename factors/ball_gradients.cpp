// RangeBall and MissingDistance between points: ∇½‖r‖² = outside/σ² (−x, x), ‖r‖² = (outside ‖x‖/σ)², with x = p_b − p_a and
// outside = max(0, 1 − distance/‖x‖). No branch, so that one in two factors inside its ball costs no misprediction.
#include <cmath>
#include <holdfast/factors/detail/ball_gradients.hpp>
#include <holdfast/factors/missing_distance.hpp>
#include <holdfast/graph/detail/gradient_kernel.hpp>

namespace holdfast {
namespace {

struct Ball {
  double radius, variance;
};
template <class V>
Ball ball_of(const RangeBall<V, V>& factor) {
  return {factor.distance, factor.sigma * factor.sigma};
}
template <class V>
Ball ball_of(const MissingDistance<V, V>& factor) {
  return {factor.d_prev, factor.sigma * factor.sigma + factor.rho * factor.rho};
}

template <template <class, class> class F, class V>
void ball_gradients(const FactorBatch& batch, const Values& values, const int* index, int first, int last, double* out) {
  constexpr int N = V::dim;
  const auto& factors = static_cast<const Batch<F<V, V>>&>(batch).factors();
  const V* const points = values.data<V>();
  for (int i = first; i < last; ++i, out += 2 * N + 1) {
    const Vector<N> x = points[index[2 * i + 1]].value - points[index[2 * i]].value;
    const Ball ball = ball_of(factors[i]);
    const double n2 = x.squaredNorm(), n = std::sqrt(n2);
    double outside = 1 - ball.radius / std::max(kZeroDistance, n);
    outside = outside < 0 || n < kZeroDistance ? 0 : outside;
    const double slope = outside / ball.variance;
    for (int c = 0; c < N; ++c) {
      out[c] = -slope * x[c];
      out[N + c] = slope * x[c];
    }
    out[2 * N] = slope * outside * n2;
  }
}

template <template <class, class> class F, class V>
bool enter() {
  return enter_gradient_kernel(typeid(F<V, V>), ball_gradients<F, V>);
}

}  // namespace

bool detail::enter_ball_gradients() {
  static const bool entered =
      enter<RangeBall, Point2>() && enter<RangeBall, Point3>() && enter<MissingDistance, Point2>() && enter<MissingDistance, Point3>();
  return entered;
}

}  // namespace holdfast
