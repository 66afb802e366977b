// The frame of `holdfast bench papers-a`, `papers-b`, …: the estimators of a paper's table, theirs and ours, over seeds.
//
// A new suite is one file: it makes its tables, gives them to run_tables, and has a line in the table of suites.cpp.
#pragma once

#include <holdfast/benchmarks/bench_runner.hpp>
#include <holdfast/common/terminal.hpp>
#include <holdfast/graph/math.hpp>

namespace holdfast::bench {

using namespace common;

/// How one estimator did on one scenario.
struct Score {
  double error;                ///< [m], RMSE unless the table says otherwise; NaN: failed
  double microseconds;         ///< a step; NaN where there are no steps
  Json more = Json::object();  ///< further numbers by name: "precision", "ANEES" (consistency()), …; printed below the table
  std::string failure = {};    ///< why it failed; empty: it did not

  /// ANEES: eᵀP⁻¹e over its dimension, averaged over independent errors; freedom: the number of all their components. Of a consistent
  /// estimator the mean over runs lies in 1 ± 1.96 √(2 / Σ freedom) in 95 % of all cases, which is printed beside it.
  void consistency(double anees, int freedom) { more["ANEES"] = {{"value", anees}, {"freedom", freedom}}; }
};

/// What an estimator with so many rows scores; where it throws, each row is a failure that says what and why.
std::vector<Score> attempted(std::size_t rows, const std::function<std::vector<Score>()>& estimate);

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
  unsigned most_runs = std::numeric_limits<unsigned>::max();  ///< seeds beyond these are not run
  /// Tracks of a run, by name: lists of [x, y]; a line of the journal for the first seed, which scripts/plot_papers draws.
  std::function<Json(unsigned seed)> tracks = {};
};

/// One estimator of a table: the rows it fills, and how.
template <class Scenario>
struct Contender {
  std::vector<PaperRow> rows;
  std::function<std::vector<Score>(const Scenario&)> run;
};

/// The table of contenders on the same scenarios. One that throws fails alone.
template <class Scenario>
PaperTable table_of(std::string name, std::string what, std::vector<std::string> columns,
                    std::function<Scenario(std::size_t column, unsigned seed)> scenario, std::vector<Contender<Scenario>> contenders) {
  PaperTable table{std::move(name), std::move(what), std::move(columns), {}, {}};
  for (const auto& contender : contenders) table.rows.insert(table.rows.end(), contender.rows.begin(), contender.rows.end());
  table.run = [scenario = std::move(scenario), contenders = std::move(contenders)](std::size_t column, unsigned seed) {
    const Scenario made = scenario(column, seed);
    std::vector<Score> scores;
    for (const auto& contender : contenders)
      for (Score& score : attempted(contender.rows.size(), [&] { return contender.run(made); })) scores.push_back(std::move(score));
    return scores;
  };
  return table;
}

/// Runs every table with the seeds options.seed … + options.runs − 1 on options.solver.threads threads, each cell beside the paper's
/// number as median (10 %–90 %) over the seeds. Every score is a line of the journal; scenarios whose lines are there (same commit and
/// machine) are not run again. An estimator that fails is counted in its cell, which has the median of the others, and its first reason
/// is printed below; False where there is one.
bool run_tables(const char* suite, const std::vector<PaperTable>& tables, const RunnerOptions& options, Journal& journal,
                Terminal& terminal);

/// A race of suites.hpp each.
bool bench_paper_a(const RunnerOptions& options, Journal& journal, Terminal& terminal);
bool bench_paper_b(const RunnerOptions& options, Journal& journal, Terminal& terminal);
bool bench_paper_c(const RunnerOptions& options, Journal& journal, Terminal& terminal);

/// Whether this build can compare its back-ends with Ceres.
bool has_ceres();

/// A track for PaperTable::tracks, rounded to centimetres; a point of so many.
Json track_of(const std::vector<Vector<2>>& positions, int every);

/// The q-quantile, between the two nearest numbers in proportion; NaN of nothing.
double quantile(std::vector<double> numbers, double q);

}  // namespace holdfast::bench
