#include <holdfast/graph/detail/gradient_kernel.hpp>
#include <unordered_map>

namespace holdfast {
namespace {

std::unordered_map<std::type_index, GradientKernel>& kernels() {
  static std::unordered_map<std::type_index, GradientKernel> table;
  return table;
}

}  // namespace

GradientKernel gradient_kernel(std::type_index factor_type) {
  const auto found = kernels().find(factor_type);
  return found == kernels().end() ? nullptr : found->second;
}

bool enter_gradient_kernel(std::type_index factor_type, GradientKernel kernel) { return kernels().emplace(factor_type, kernel).second; }

}  // namespace holdfast
