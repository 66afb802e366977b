// Memory of this thread, kept from call to call: solving allocates nothing. Internal.
#pragma once

#include <cstddef>
#include <vector>

namespace holdfast {

/// At least `size` doubles, valid until the next call with the same Owner: an empty struct that stands for one use.
template <class Owner>
double* scratch(std::size_t size) {
  static thread_local std::vector<double> memory;
  if (memory.size() < size) memory.resize(size);
  return memory.data();
}

}  // namespace holdfast
