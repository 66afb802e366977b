// What a thread without the GIL reads or writes, and what others may do with it meanwhile. Asked for and changed under the GIL alone.
#pragma once

#include <holdfast/solvers/backend.hpp>

namespace holdfast::python {

/// For as long as it lives others may read `what`, and nobody may change it. BadProblem where another thread is changing it.
class Reading {
 public:
  Reading(const void* what, const char* name);
  ~Reading();
  Reading(const Reading&) = delete;
  Reading& operator=(const Reading&) = delete;

 private:
  const void* what_;
};

/// For as long as it lives nobody else may read or change `what`. BadProblem where another thread, or a function that this one has called
/// back, has it.
class Writing {
 public:
  Writing(const void* what, const char* name);
  ~Writing();
  Writing(const Writing&) = delete;
  Writing& operator=(const Writing&) = delete;

 private:
  const void* what_;
};

/// A change at once, under the GIL: BadProblem where somebody has `what`.
void require_unused(const void* what, const char* name);
/// A look at once, under the GIL: BadProblem where another thread is changing `what`.
void require_readable(const void* what, const char* name);

}  // namespace holdfast::python
