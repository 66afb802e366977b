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

bool smaller(double a, double b) { return std::abs(a) < std::abs(b); }

// Gauss with row pivoting, A x = b: row_of[c] is the row that gives x_c, −1 where none is left and x_c is 0.
void solve_in_place(int n, double* A, double* b, int* row_of, double* x) {
  constexpr double kZero = 1e-13;  // of the column's largest entry: a pivot that is rounding
  const auto column = [&](int c) { return A + static_cast<std::ptrdiff_t>(c) * n; };
  for (int c = 0; c < n; ++c) x[c] = kZero * std::abs(*std::max_element(column(c), column(c) + n, smaller));
  int rank = 0;
  for (int c = 0; c < n; ++c) {
    const int pivot = static_cast<int>(std::max_element(column(c) + rank, column(c) + n, smaller) - column(c));
    row_of[c] = pivot < n && std::abs(column(c)[pivot]) > x[c] ? rank++ : -1;
    if (row_of[c] < 0) continue;
    const int top = row_of[c];
    for (int k = c; k < n && pivot != top; ++k) std::swap(column(k)[top], column(k)[pivot]);
    std::swap(b[top], b[pivot]);
    for (int row = top + 1; row < n; ++row) {
      const double f = column(c)[row] / column(c)[top];
      for (int k = c + 1; k < n; ++k) column(k)[row] -= f * column(k)[top];
      b[row] -= f * b[top];
    }
  }
  for (int c = n - 1; c >= 0; --c) {
    x[c] = row_of[c] < 0 ? 0 : b[row_of[c]] / column(c)[row_of[c]];
    for (int row = 0; row < row_of[c]; ++row) b[row] -= column(c)[row] * x[c];
  }
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

void detail::solve_square(int n, const double* W, const double* r, double* x) {
  constexpr int kStack = 16;
  if (n <= kStack) {
    double A[kStack * kStack], b[kStack];
    int row_of[kStack];
    std::copy_n(W, n * n, A);
    std::copy_n(r, n, b);
    solve_in_place(n, A, b, row_of, x);
  } else {
    std::vector<double> A(W, W + static_cast<std::ptrdiff_t>(n) * n), b(r, r + n);
    std::vector<int> row_of(n);
    solve_in_place(n, A.data(), b.data(), row_of.data(), x);
  }
}

}  // namespace holdfast
