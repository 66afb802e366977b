#include <cmath>
#include <holdfast/solvers/detail/fold.hpp>

namespace holdfast {

void fold(const Loss& loss, double weight, int m, int n, double* r, double* J) {
  for (int c = 0; c < m; ++c) {
    const Rho rho = loss.rho_of_component(r[c]);
    const double folded = std::copysign(std::sqrt(weight * rho.value), r[c]);
    const double slope = folded != 0 ? weight * rho.first * r[c] / folded : std::sqrt(weight * rho.first);
    r[c] = folded;
    for (int k = 0; J != nullptr && k < n; ++k) J[k * m + c] *= slope;
  }
}

}  // namespace holdfast
