#include <algorithm>
#include <cmath>
#include <holdfast/graph/detail/factor_type.hpp>
#include <map>

namespace holdfast {
namespace {

struct FactorTypes {
  std::map<std::type_index, FactorType> by_type;
  std::map<std::string, const FactorType*, std::less<>> by_name;
};
FactorTypes& types() {
  static FactorTypes all;
  return all;
}

}  // namespace

const FactorType* find_factor_type(std::type_index type) {
  const auto it = types().by_type.find(type);
  return it == types().by_type.end() ? nullptr : &it->second;
}

const FactorType* find_factor_type(std::string_view name) {
  const auto it = types().by_name.find(name);
  return it == types().by_name.end() ? nullptr : it->second;
}

bool enter_factor_type(std::type_index type, FactorType description) {
  const auto [it, is_new] = types().by_type.emplace(type, std::move(description));
  types().by_name[it->second.name] = &it->second;
  return is_new;
}

// Gauss with row pivoting. A column without a pivot moves nothing.
void detail::solve_square(int n, const double* W, const double* r, double* x) {
  constexpr int kStack = 16;
  double local[kStack * kStack];
  std::vector<double> large(n > kStack ? static_cast<std::size_t>(n) * n : 0);
  double* const A = n > kStack ? large.data() : local;
  std::copy_n(W, n * n, A);
  std::copy_n(r, n, x);
  for (int c = 0; c < n; ++c) {
    int pivot = c;
    for (int row = c + 1; row < n; ++row)
      if (std::abs(A[c * n + row]) > std::abs(A[c * n + pivot])) pivot = row;
    if (A[c * n + pivot] == 0) continue;
    if (pivot != c) {
      for (int k = c; k < n; ++k) std::swap(A[k * n + c], A[k * n + pivot]);
      std::swap(x[c], x[pivot]);
    }
    for (int row = c + 1; row < n; ++row) {
      const double f = A[c * n + row] / A[c * n + c];
      for (int k = c + 1; k < n; ++k) A[k * n + row] -= f * A[k * n + c];
      x[row] -= f * x[c];
    }
  }
  for (int c = n - 1; c >= 0; --c) {
    x[c] = A[c * n + c] == 0 ? 0 : x[c] / A[c * n + c];
    for (int row = 0; row < c; ++row) x[row] -= A[c * n + row] * x[c];
  }
}

}  // namespace holdfast
