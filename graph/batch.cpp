#include <cxxabi.h>

#include <algorithm>
#include <cstdlib>
#include <holdfast/graph/batch.hpp>

namespace holdfast {

std::string detail::demangled(const std::type_info& type) {
  int status = 0;
  const std::unique_ptr<char, decltype(&std::free)> text(abi::__cxa_demangle(type.name(), nullptr, nullptr, &status), &std::free);
  return status == 0 ? text.get() : type.name();
}

void FactorBatch::set_variables(std::vector<std::type_index> types, std::vector<const char*> names, std::vector<int> dims) {
  types_ = std::move(types);
  type_names_ = std::move(names);
  dims_ = std::move(dims);
  total_dim_ = 0;
  stride_ = 1;  // the cost
  for (std::size_t b = 0; b < dims_.size(); ++b) {
    total_dim_ += dims_[b];
    stride_ += dims_[b];
    for (std::size_t a = b; a < dims_.size(); ++a) stride_ += dims_[a] * dims_[b];
  }
}

std::string FactorBatch::describe(int i) const {
  std::string text = name_ + "(";
  for (int k = 0; k < arity(); ++k) text += (k ? ", " : "") + keys(i)[k].str();
  return text + ")";
}

double FactorBatch::cost_of(int i, const double* r, double* weights) const {
  const int m = residual_dim();
  double sum = 0;
  if (loss_.per_component || m == 1) {
    for (int c = 0; c < m; ++c) {
      const Rho rho = loss_.rho_of_component(r[c]);
      sum += rho.value;
      if (weights != nullptr) weights[c] = weights_[i] * rho.first;
    }
  } else {
    double s = 0;
    for (int c = 0; c < m; ++c) s += r[c] * r[c];
    const Rho rho = loss_.rho(s, m);
    sum = rho.value;
    if (weights != nullptr) std::fill(weights, weights + m, weights_[i] * rho.first);
  }
  return 0.5 * weights_[i] * sum;
}

double FactorBatch::cost(const Values& values, const int* index, int first, int last) const {
  constexpr int kBuffer = 512;
  const int m = residual_dim();
  double local[kBuffer];
  std::vector<double> large(m > kBuffer ? static_cast<std::size_t>(m) : 0);
  double* r = m > kBuffer ? large.data() : local;
  const int step = std::max(1, kBuffer / m);
  double sum = 0;
  for (int i = first; i < last; i += step) {
    const int end = std::min(last, i + step);
    evaluate(values, index, i, end, r, nullptr);
    for (int k = i; k < end; ++k) sum += cost_of(k, r + static_cast<std::ptrdiff_t>(k - i) * m, nullptr);
  }
  return sum;
}

}  // namespace holdfast
