#include <cxxabi.h>

#include <cstdlib>
#include <holdfast/graph/detail/demangled.hpp>
#include <memory>

namespace holdfast {

std::string detail::demangled(const std::type_info& type) {
  int status = 0;
  const std::unique_ptr<char, decltype(&std::free)> text(abi::__cxa_demangle(type.name(), nullptr, nullptr, &status), &std::free);
  return status == 0 ? text.get() : type.name();
}

}  // namespace holdfast
