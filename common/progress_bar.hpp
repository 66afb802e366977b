// One line on a terminal that says how far a long piece of work is: drawn after a second, ten times a second at most, wiped out at the end.
#pragma once

#include <holdfast/common/terminal.hpp>
#include <holdfast/solvers/detail/clock.hpp>
#include <holdfast/solvers/options.hpp>
#include <string>

namespace holdfast::common {

class ProgressBar {
 public:
  /// total: solves to come.
  ProgressBar(Terminal& terminal, std::size_t total) : terminal_(terminal), total_(total) {}
  ~ProgressBar() { clear(); }
  ProgressBar(const ProgressBar&) = delete;
  ProgressBar& operator=(const ProgressBar&) = delete;

  void begin(const std::string& what);
  void done_with_one() { ++done_; }
  /// Before something else is written.
  void clear();

  /// For Options::progress; none where nobody looks.
  std::function<bool(const Iteration&)> callback();

 private:
  void draw(const std::string& text);

  Terminal& terminal_;
  std::size_t total_;
  std::size_t done_ = 0;
  std::string what_;
  Stopwatch watch_;
  double next_draw_ = 1;  ///< [s]
  bool shown_ = false;
};

}  // namespace holdfast::common
