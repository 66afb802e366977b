#include <petscsys.h>

#include <cmath>
#include <cstdlib>
#include <holdfast/graph/error.hpp>
#include <holdfast/solvers/backend.hpp>
#include <holdfast/solvers/distributed/communicator.hpp>
#include <limits>

namespace holdfast {
namespace {

bool flag_of(int (*ask)(int*)) {
  int flag = 0;
  ask(&flag);
  return flag != 0;
}

void end_all() {
  if (!flag_of(MPI_Finalized)) {
    PetscFinalize();
    MPI_Finalize();
  }
}

/// MPI and PETSc, once a program.
void start_all() {
  static const bool started = [] {
    if (!flag_of(MPI_Initialized)) {
      int provided = 0;
      MPI_Init_thread(nullptr, nullptr, MPI_THREAD_FUNNELED, &provided);
      std::atexit(end_all);
    }
    PetscBool petsc = PETSC_FALSE;
    PetscInitialized(&petsc);
    if (petsc == PETSC_FALSE) {
      PetscOptionsSetValue(nullptr, "-no_signal_handler", "true");
      PetscInitializeNoArguments();
    }
    PetscPushErrorHandler(PetscReturnErrorHandler, nullptr);  // an error is thrown, not printed
    return true;
  }();
  (void)started;
}

MPI_Comm world() {
  start_all();
  return MPI_COMM_WORLD;
}

enum class What : char { nothing, key, type, number, option, file, problem, other };

What what_of(const Error& error) {
  if (dynamic_cast<const BadKey*>(&error) != nullptr) return What::key;
  if (dynamic_cast<const BadType*>(&error) != nullptr) return What::type;
  if (dynamic_cast<const BadNumber*>(&error) != nullptr) return What::number;
  if (dynamic_cast<const BadOption*>(&error) != nullptr) return What::option;
  if (dynamic_cast<const BadFile*>(&error) != nullptr) return What::file;
  if (dynamic_cast<const BadProblem*>(&error) != nullptr) return What::problem;
  return What::other;
}

[[noreturn]] void raise(What what, const std::string& text) {
  switch (what) {
    case What::key:
      throw BadKey(text);
    case What::type:
      throw BadType(text);
    case What::number:
      throw BadNumber(text);
    case What::option:
      throw BadOption(text);
    case What::file:
      throw BadFile(text);
    case What::problem:
      throw BadProblem(text);
    default:
      throw Error(text);
  }
}

}  // namespace

Communicator::Communicator() : Communicator(world()) {}

Communicator::Communicator(MPI_Comm comm) : comm_(comm) {
  start_all();
  MPI_Comm_rank(comm_, &rank_);
  MPI_Comm_size(comm_, &size_);
}

Communicator Communicator::alone() {
  start_all();
  return Communicator(MPI_COMM_SELF);
}

void Communicator::sum(double* x, int n) const {
  if (size_ == 1) return;
  ++traffic_.reductions;
  MPI_Allreduce(MPI_IN_PLACE, x, n, MPI_DOUBLE, MPI_SUM, comm_);
}

double Communicator::sum(double x) const {
  sum(&x, 1);
  return x;
}

double Communicator::max(double x) const {
  if (size_ == 1) return x;
  ++traffic_.reductions;
  // What MPI_MAX makes of a NaN depends on the order.
  double pair[2] = {std::isnan(x) ? std::numeric_limits<double>::max() : x, std::isnan(x) ? 1.0 : 0.0};
  MPI_Allreduce(MPI_IN_PLACE, pair, 2, MPI_DOUBLE, MPI_MAX, comm_);
  return pair[1] > 0 ? std::numeric_limits<double>::quiet_NaN() : pair[0];
}

std::int64_t Communicator::sum(std::int64_t x) const {
  ++traffic_.reductions;
  MPI_Allreduce(MPI_IN_PLACE, &x, 1, MPI_INT64_T, MPI_SUM, comm_);
  return x;
}

std::int64_t Communicator::sum_before(std::int64_t x) const {
  std::int64_t before = 0;
  MPI_Exscan(&x, &before, 1, MPI_INT64_T, MPI_SUM, comm_);
  return rank_ == 0 ? 0 : before;
}

std::vector<std::string> Communicator::exchange(const std::vector<std::string>& to) const {
  constexpr int kTag = 71;
  std::vector<std::int64_t> sizes_to(size_), sizes_from(size_);
  for (int r = 0; r < size_; ++r) sizes_to[r] = static_cast<std::int64_t>(to[r].size());
  MPI_Alltoall(sizes_to.data(), 1, MPI_INT64_T, sizes_from.data(), 1, MPI_INT64_T, comm_);
  constexpr std::int64_t kPiece = 1 << 30;  // MPI counts in int
  std::vector<std::string> from(size_);
  std::vector<MPI_Request> requests;
  for (int r = 0; r < size_; ++r) {
    from[r].resize(sizes_from[r]);
    for (std::int64_t at = 0; at < sizes_from[r]; at += kPiece)
      MPI_Irecv(&from[r][at], static_cast<int>(std::min(kPiece, sizes_from[r] - at)), MPI_CHAR, r, kTag, comm_, &requests.emplace_back());
  }
  for (int r = 0; r < size_; ++r)
    for (std::int64_t at = 0; at < sizes_to[r]; at += kPiece)
      MPI_Isend(&to[r][at], static_cast<int>(std::min(kPiece, sizes_to[r] - at)), MPI_CHAR, r, kTag, comm_, &requests.emplace_back());
  MPI_Waitall(static_cast<int>(requests.size()), requests.data(), MPI_STATUSES_IGNORE);
  return from;
}

void Communicator::agree(const std::function<void()>& work) const {
  What what = What::nothing;
  std::string text;
  try {
    work();
  } catch (const Error& error) {
    what = what_of(error);
    text = error.what();
  }
  if (size_ == 1) {
    if (what != What::nothing) raise(what, text);
    return;
  }
  int first = what == What::nothing ? size_ : rank_;
  MPI_Allreduce(MPI_IN_PLACE, &first, 1, MPI_INT, MPI_MIN, comm_);
  if (first == size_) return;
  int length = static_cast<int>(text.size());
  MPI_Bcast(&length, 1, MPI_INT, first, comm_);
  text.resize(length);
  MPI_Bcast(text.data(), length, MPI_CHAR, first, comm_);
  MPI_Bcast(&what, 1, MPI_CHAR, first, comm_);
  raise(what, "process " + std::to_string(first) + ": " + text);
}

}  // namespace holdfast
