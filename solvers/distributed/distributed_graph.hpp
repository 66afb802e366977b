// A graph that no process holds as a whole. Each process has variables of its own, and adds factors on them and on variables of others
// that it names by their keys.
//
//   Communicator all;
//   Graph mine;     mine.add(RangeBall<Point2, Point2>{2.0, 0.1}, {A(0), B(7)});    // A(0) is mine, B(7) somebody's
//   Values own;     own.insert(A(0), Point2(…));                                    // each variable in one process, with its start
//   DistributedGraph graph(all, std::move(mine), std::move(own));                   // a collective call
//   Petsc().solve(graph);                                                           // so is this
//   graph.values().at<Point2>(A(0));
//
// Each factor is added in exactly one process: cost = Σ over the processes of what they added. A factor may name variables of others only.
// The construction finds who owns each key (a directory spread over the processes by the keys' hash), and copies to the owner of each
// variable the factors of others on it, so that each process computes the whole gradient of what it owns from its neighbours' values
// alone. It then holds its own variables, ghosts (copies of its neighbours' variables that its factors touch), its own factors and
// the copies. The copies travel as graph/files/binary.hpp writes them: a factor without fields() or a loss without a name throws
// BadFile where it lies between processes, and only there.
//
// A variable is fixed by its owner (Graph::fix in the owner's graph).
// Memory of a process: its part and its boundary. Messages: to neighbours alone. Nothing is as long as the number of variables of all.
#pragma once

#include <holdfast/graph/graph.hpp>
#include <holdfast/solvers/distributed/communicator.hpp>
#include <memory>

namespace holdfast {

namespace detail {
class Exchange;
class DistributedProblem;
}  // namespace detail

class DistributedGraph {
 public:
  /// Throws, in every process: BadKey (a key that no process has, or that two have), BadType (a key whose variable has another type than a
  /// factor of another process wants), BadFile (see above), BadProblem (no factor anywhere).
  DistributedGraph(Communicator communicator, Graph factors, Values own);
  ~DistributedGraph();
  DistributedGraph(DistributedGraph&&) noexcept;
  DistributedGraph& operator=(DistributedGraph&&) noexcept;

  const Communicator& communicator() const;
  /// Own variables, and ghosts: as current as the end of the last solve. Own ones may be changed between solves.
  Values& values();
  const Values& values() const;
  /// Own factors, and copies of the others' on own variables.
  const Graph& graph() const;
  bool is_own(Key key) const;
  std::size_t own_factors() const;
  std::size_t own_variables() const;
  std::size_t ghosts() const;           ///< variables of others that are held as copies, fixed ones among them
  std::vector<int> neighbours() const;  ///< ranks, ascending
  /// Numbers (doubles) that are sent to neighbours when every boundary state is sent once.
  std::size_t boundary_numbers() const;

  /// Which of the jobs that went on from each other's saved states this is (solvers/distributed/state.hpp).
  std::uint32_t job() const;
  void set_job(std::uint32_t number);

  // ---- collective
  double cost();  ///< Σ w ½ρ of all processes' factors at the values of their owners
  std::int64_t total_factors() const;
  std::int64_t total_variables() const;

 private:
  friend class detail::DistributedProblem;
  struct Parts;
  std::unique_ptr<Parts> parts_;
};

}  // namespace holdfast
