// Seconds of this thread on a processor since construction: what an estimator costs, whatever else the machine does.
#pragma once

#include <ctime>

namespace holdfast::bench {

class CpuWatch {
 public:
  double seconds() const { return now() - start_; }

 private:
  static double now() {
    timespec t;
    ::clock_gettime(CLOCK_THREAD_CPUTIME_ID, &t);
    return static_cast<double>(t.tv_sec) + 1e-9 * static_cast<double>(t.tv_nsec);
  }
  double start_ = now();
};

}  // namespace holdfast::bench
