#include <cmath>
#include <holdfast/graph/error.hpp>
#include <holdfast/solvers/chi_square.hpp>

namespace holdfast {

double chi_square_tail(double s, int d) {
  if (d < 1) fail<BadOption>("χ² of ", d, " degrees of freedom; give at least 1");
  if (std::isnan(s)) return s;
  if (s <= 0) return 1;
  const double h = s / 2;
  const bool odd = d % 2 == 1;
  double sum = odd ? std::erfc(std::sqrt(h)) : 0;
  double k = odd ? 0.5 : 0;
  double term = std::exp(-h) * (odd ? std::sqrt(h) / std::tgamma(1.5) : 1);  // e^−h h^k / Γ(k + 1)
  for (; k < 0.5 * d - 0.75; ++k) {
    sum += term;
    term *= h / (k + 1);
  }
  return sum;
}

double chi_square_quantile(double probability, int d) {
  if (!(probability > 0 && probability < 1)) fail<BadOption>("the quantile of χ² at ", probability, "; give a probability in (0, 1)");
  const double tail = 1 - probability;
  double low = 0, high = d;
  while (chi_square_tail(high, d) > tail) high *= 2;
  for (int i = 0; i < 200 && high - low > 1e-15 * high; ++i) {
    const double middle = 0.5 * (low + high);
    (chi_square_tail(middle, d) > tail ? low : high) = middle;
  }
  return 0.5 * (low + high);
}

}  // namespace holdfast
