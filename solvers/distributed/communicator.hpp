// The processes that share a problem: a thin layer over MPI, which counts what is sent.
//
//   Communicator all;                        // every process that mpirun started
//   const double cost = all.sum(my_cost);    // a collective call: every process makes it, and all get the same number
//
// The first Communicator of a program starts MPI and PETSc where the program has not, and they end with the program. Errors: what one
// process finds wrong, all throw (agree()), so that none waits for ever for another.
// Threads. One thread of each process, the same that made the first Communicator.
#pragma once

#include <mpi.h>

#include <cstdint>
#include <functional>
#include <string>
#include <vector>

namespace holdfast {

/// What a process has sent since it was set to zero.
struct Traffic {
  std::uint64_t bytes = 0;       ///< to neighbours
  std::uint64_t messages = 0;    ///< to neighbours
  std::uint64_t reductions = 0;  ///< sums and maxima over all processes, of a few numbers each
};

class Communicator {
 public:
  Communicator();                        ///< all processes
  explicit Communicator(MPI_Comm comm);  ///< these; the caller keeps the MPI communicator
  static Communicator alone();           ///< this process

  int rank() const { return rank_; }
  int size() const { return size_; }
  MPI_Comm mpi() const { return comm_; }

  // ---- collective

  double sum(double x) const;
  double max(double x) const;  ///< NaN where any is
  void sum(double* x, int n) const;
  std::int64_t sum(std::int64_t x) const;
  std::int64_t sum_before(std::int64_t x) const;  ///< of the processes of lower rank
  bool any(bool x) const { return max(x ? 1.0 : 0.0) > 0; }
  /// Bytes to each process, by rank, for bytes from each.
  std::vector<std::string> exchange(const std::vector<std::string>& to) const;
  /// Runs what may throw an Error; where it does in any process, all throw: the error of the lowest of them, with its rank.
  void agree(const std::function<void()>& work) const;

  Traffic& traffic() const { return traffic_; }

 private:
  MPI_Comm comm_;
  int rank_ = 0, size_ = 1;
  mutable Traffic traffic_;
};

}  // namespace holdfast
