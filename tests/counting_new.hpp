// Counts what is allocated while `counting` is set. It replaces the program's operator new: include it in one file of a test.
#pragma once

#include <atomic>
#include <cstdlib>
#include <holdfast/graph/batch.hpp>
#include <new>

namespace holdfast::testing {

inline std::atomic<bool> counting{false};
inline std::atomic<long> allocations{0};

inline void* counted(std::size_t size, std::size_t alignment) {
  if (counting) ++allocations;
  void* memory = alignment == 0 ? std::malloc(size) : std::aligned_alloc(alignment, (size + alignment - 1) / alignment * alignment);
  if (memory == nullptr) throw std::bad_alloc();
  return memory;
}

}  // namespace holdfast::testing

// Of this whole program; the array and the nothrow forms end here, too. Not inlined: GCC would see free() meet a `new`, and warn.
HOLDFAST_NOINLINE void* operator new(std::size_t size) { return holdfast::testing::counted(size, 0); }
HOLDFAST_NOINLINE void* operator new(std::size_t size, std::align_val_t alignment) {
  return holdfast::testing::counted(size, static_cast<std::size_t>(alignment));
}
HOLDFAST_NOINLINE void operator delete(void* memory) noexcept { std::free(memory); }
HOLDFAST_NOINLINE void operator delete(void* memory, std::size_t) noexcept { std::free(memory); }
HOLDFAST_NOINLINE void operator delete(void* memory, std::align_val_t) noexcept { std::free(memory); }
HOLDFAST_NOINLINE void operator delete(void* memory, std::size_t, std::align_val_t) noexcept { std::free(memory); }
