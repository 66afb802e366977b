// What the runs of a paper's table come to, cell by cell, and how it is printed. Internal to run_tables (paper.hpp).
#pragma once

#include <holdfast/benchmarks/papers/paper.hpp>
#include <iosfwd>
#include <map>

namespace holdfast::bench {

/// The scores of one row in one column, seed by seed.
struct Cell {
  std::vector<double> errors, microseconds;
  std::map<std::string, std::vector<double>> more;
  std::map<std::string, double> freedom;  ///< of a consistency: Σ over the runs
  std::vector<std::string> failures;      ///< "seed 7: BadProblem: …"

  void add(const Json& line);
};
using Cells = std::vector<std::vector<Cell>>;  ///< by row, then column

/// The table, one of each further number below it, and what failed.
void print_cells(std::ostream& out, const PaperTable& table, const Cells& cells);
bool any_failed(const Cells& cells);

}  // namespace holdfast::bench
