#include <algorithm>
#include <holdfast/solvers/distributed/internal/exchange.hpp>

namespace holdfast::detail {
namespace {

constexpr int kTag = 72;

std::size_t numbers_of(const std::vector<Values::Slot>& slots, const Values& values) {
  std::size_t size = 0;
  for (const Values::Slot& slot : slots) size += values.pool(slot.pool).ambient();
  return size;
}

}  // namespace

void Exchange::send(const Communicator& communicator) {
  requests_.clear();
  for (std::size_t n = 0; n < neighbours_.size(); ++n)
    MPI_Irecv(in_[n].data(), static_cast<int>(in_[n].size()), MPI_DOUBLE, neighbours_[n].rank, kTag, communicator.mpi(),
              &requests_.emplace_back());
  for (std::size_t n = 0; n < neighbours_.size(); ++n) {
    MPI_Isend(out_[n].data(), static_cast<int>(out_[n].size()), MPI_DOUBLE, neighbours_[n].rank, kTag, communicator.mpi(),
              &requests_.emplace_back());
    communicator.traffic().bytes += out_[n].size() * sizeof(double);
    ++communicator.traffic().messages;
  }
}

void Exchange::wait() {
  MPI_Waitall(static_cast<int>(requests_.size()), requests_.data(), MPI_STATUSES_IGNORE);
  requests_.clear();
}

void Exchange::begin(const Communicator& communicator, const Values& values) {
  out_.resize(neighbours_.size());
  in_.resize(neighbours_.size());
  for (std::size_t n = 0; n < neighbours_.size(); ++n) {
    out_[n].clear();
    for (const Values::Slot& slot : neighbours_[n].own) {
      const double* x = values.pool(slot.pool).data(slot.index);
      out_[n].insert(out_[n].end(), x, x + values.pool(slot.pool).ambient());
    }
    in_[n].resize(numbers_of(neighbours_[n].ghosts, values));
  }
  send(communicator);
}

void Exchange::put(const std::vector<double>& numbers, const std::vector<Values::Slot>& ghosts, Values& values) {
  const double* x = numbers.data();
  for (const Values::Slot& slot : ghosts) {
    PoolBase& pool = values.pool(slot.pool);
    std::copy_n(x, pool.ambient(), pool.data(slot.index));
    x += pool.ambient();
  }
}

void Exchange::end(Values& values) {
  wait();
  for (std::size_t n = 0; n < neighbours_.size(); ++n) put(in_[n], neighbours_[n].ghosts, values);
}

void Exchange::update(const Communicator& communicator, Values& values) {
  begin(communicator, values);
  end(values);
}

void Exchange::spread(const Communicator& communicator, const Values& values, std::vector<std::vector<double>>& numbers) {
  numbers.resize(values.pools().size());
  for (std::size_t p = 0; p < numbers.size(); ++p) numbers[p].resize(values.pools()[p]->size());
  out_.resize(neighbours_.size());
  in_.resize(neighbours_.size());
  for (std::size_t n = 0; n < neighbours_.size(); ++n) {
    out_[n].clear();
    for (const Values::Slot& slot : neighbours_[n].own) out_[n].push_back(numbers[slot.pool][slot.index]);
    in_[n].resize(neighbours_[n].ghosts.size());
  }
  send(communicator);
  wait();
  for (std::size_t n = 0; n < neighbours_.size(); ++n)
    for (std::size_t k = 0; k < in_[n].size(); ++k) {
      const Values::Slot& slot = neighbours_[n].ghosts[k];
      numbers[slot.pool][slot.index] = in_[n][k];
    }
}

}  // namespace holdfast::detail
