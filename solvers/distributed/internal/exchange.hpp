// Who sends which boundary variables to whom, and the sending. Internal.
#pragma once

#include <holdfast/graph/values.hpp>
#include <holdfast/solvers/distributed/communicator.hpp>

namespace holdfast::detail {

class Exchange {
 public:
  /// The same variables in the same order on both sides.
  struct Neighbour {
    int rank = -1;
    std::vector<Values::Slot> own;     ///< that it wants of us
    std::vector<Values::Slot> ghosts;  ///< of it
  };

  explicit Exchange(std::vector<Neighbour> neighbours = {}) : neighbours_(std::move(neighbours)) {}
  const std::vector<Neighbour>& neighbours() const { return neighbours_; }

  /// Ghosts get their owners' ambient coordinates: one message to each neighbour.
  void update(const Communicator& communicator, Values& values);
  /// The same in two halves, so that there is something to do while the messages travel.
  void begin(const Communicator& communicator, const Values& values);
  void end(Values& values);
  /// One number a variable: numbers[pool][index], owners' to ghosts.
  void spread(const Communicator& communicator, const Values& values, std::vector<std::vector<double>>& numbers);

  /// Of the last begin(): what came from neighbour n, in the order of its ghosts.
  const std::vector<double>& received(int n) const { return in_[n]; }
  void wait();  ///< for all that is under way; end() does it, too
  static void put(const std::vector<double>& numbers, const std::vector<Values::Slot>& ghosts, Values& values);

 private:
  void send(const Communicator& communicator);

  std::vector<Neighbour> neighbours_;
  std::vector<std::vector<double>> out_, in_;
  std::vector<MPI_Request> requests_;
};

}  // namespace holdfast::detail
