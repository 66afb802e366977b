// The frame of `holdfast bench papers-a`, `papers-b`, …: the estimators of a paper's table, theirs and ours, over seeds.
//
// A new suite is one file: it makes its tables, gives them to run_tables, and has a line in the table of suites.cpp.
#pragma once

#include <holdfast/benchmarks/bench_runner.hpp>
#include <holdfast/benchmarks/terminal.hpp>

namespace holdfast::bench {

/// How one estimator did on one scenario.
struct Score {
  double error;                ///< [m], RMSE unless the table says otherwise; NaN: failed
  double microseconds;         ///< a step; NaN where there are no steps
  Json more = Json::object();  ///< further numbers by name: "anees", "precision", …; their means and ranges are printed below the table
};

struct PaperRow {
  std::string name;
  std::vector<double> paper = {};  ///< the paper's own numbers, one a column (NaN: it has none); empty: no such row there
};

struct PaperTable {
  std::string name;  ///< "Table I"
  std::string what;  ///< the scenario and all its parameters, the score, and from when on it counts
  std::vector<std::string> columns;
  std::vector<PaperRow> rows;
  /// Makes the scenario of a column from a seed and runs every estimator on it: a score a row. Called from several threads at once.
  std::function<std::vector<Score>(std::size_t column, unsigned seed)> run;
};

/// Runs every table with the seeds options.seed … + options.runs − 1 on options.solver.threads threads, each cell beside the paper's
/// number as median (10 %–90 %) over the seeds. Every score is a line of the journal; scenarios whose lines are there (same commit and
/// machine) are not run again. False where an estimator failed.
bool run_tables(const char* suite, const std::vector<PaperTable>& tables, const RunnerOptions& options, Journal& journal,
                Terminal& terminal);

/// A race of suites.hpp each.
bool bench_paper_a(const RunnerOptions& options, Journal& journal, Terminal& terminal);
bool bench_paper_b(const RunnerOptions& options, Journal& journal, Terminal& terminal);
bool bench_paper_c(const RunnerOptions& options, Journal& journal, Terminal& terminal);

/// The q-quantile, between the two nearest numbers in proportion; NaN of nothing.
double quantile(std::vector<double> numbers, double q);

}  // namespace holdfast::bench
