// A small thread pool: run(n, fn) calls fn(0) … fn(n−1) once each, in any order, and returns when all are done. What a task
// computes must not depend on which thread runs it; then neither does the result.
#pragma once

#include <atomic>
#include <condition_variable>
#include <exception>
#include <functional>
#include <mutex>
#include <thread>
#include <utility>
#include <vector>

namespace holdfast {

class ThreadPool {
 public:
  explicit ThreadPool(int threads);
  ~ThreadPool();
  ThreadPool(const ThreadPool&) = delete;
  ThreadPool& operator=(const ThreadPool&) = delete;

  int threads() const { return static_cast<int>(workers_.size()) + 1; }
  /// The caller works, too. The first exception of a task is rethrown here.
  void run(int tasks, const std::function<void(int)>& task);

 private:
  void work();
  void take_tasks();

  std::vector<std::thread> workers_;
  std::mutex mutex_;
  std::condition_variable start_, done_;
  const std::function<void(int)>* task_ = nullptr;
  int tasks_ = 0;
  std::atomic<int> next_{0};
  int busy_ = 0;
  std::uint64_t round_ = 0;
  bool stop_ = false;
  std::exception_ptr error_;
};

/// pool->run, or a plain loop where there is no pool.
template <class Fn>
void parallel_for(ThreadPool* pool, int tasks, const Fn& fn) {
  if (pool == nullptr || pool->threads() == 1 || tasks < 2) {
    for (int i = 0; i < tasks; ++i) fn(i);
  } else {
    pool->run(tasks, fn);
  }
}

}  // namespace holdfast
