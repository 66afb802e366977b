#include "held.hpp"

#include <map>
#include <thread>

namespace holdfast::python {
namespace {

struct Use {
  int readers = 0;
  std::thread::id writer;  ///< of nobody: none
};

std::map<const void*, Use>& uses() {
  static std::map<const void*, Use> all;
  return all;
}

[[noreturn]] void refuse(const char* name) {
  fail<BadProblem>("another thread is solving with this ", name, ", or a function of its own; give each thread its own");
}

void let_go(const void* what) {
  const auto it = uses().find(what);
  if (it->second.readers == 0 && it->second.writer == std::thread::id()) uses().erase(it);
}

}  // namespace

void require_readable(const void* what, const char* name) {
  const auto it = uses().find(what);
  if (it == uses().end() || it->second.writer == std::thread::id()) return;
  if (it->second.writer != std::this_thread::get_id()) refuse(name);
}

void require_unused(const void* what, const char* name) {
  if (uses().count(what) != 0) refuse(name);
}

Reading::Reading(const void* what, const char* name) : what_(what) {
  require_readable(what, name);
  ++uses()[what].readers;
}

Reading::~Reading() {
  --uses()[what_].readers;
  let_go(what_);
}

Writing::Writing(const void* what, const char* name) : what_(what) {
  require_unused(what, name);
  uses()[what].writer = std::this_thread::get_id();
}

Writing::~Writing() {
  uses()[what_].writer = std::thread::id();
  let_go(what_);
}

}  // namespace holdfast::python
