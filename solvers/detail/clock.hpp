// Seconds since construction, and since the last lap.
#pragma once

#include <chrono>

namespace holdfast {

class Stopwatch {
 public:
  double seconds() const { return since(start_); }
  /// Adds the time since the last lap (or the start) to `total`.
  void lap(double& total) {
    const Clock::time_point now = Clock::now();
    total += std::chrono::duration<double>(now - lap_).count();
    lap_ = now;
  }

 private:
  using Clock = std::chrono::steady_clock;
  static double since(Clock::time_point t) { return std::chrono::duration<double>(Clock::now() - t).count(); }
  Clock::time_point start_ = Clock::now();
  Clock::time_point lap_ = start_;
};

}  // namespace holdfast
