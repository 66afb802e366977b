#include <algorithm>
#include <holdfast/benchmarks/papers/paper_cells.hpp>
#include <holdfast/common/machine.hpp>
#include <holdfast/graph/detail/parallel.hpp>
#include <holdfast/graph/factor.hpp>
#include <holdfast/solvers/table.hpp>
#include <map>

namespace holdfast::bench {
namespace {

std::string identity(const std::string& table, const std::string& column, const std::string& row, unsigned seed, const std::string& commit,
                     const Json& machine) {
  return table + '|' + column + '|' + row + '|' + std::to_string(seed) + '|' + commit + '|' + machine.dump();
}

Json number(double value) { return std::isfinite(value) ? Json(value) : Json(nullptr); }

/// The lines of earlier calls, by what was run.
class Known {
 public:
  Known(const Journal& journal, bool fresh) {
    if (fresh) return;
    for (const Json& line : journal.lines())
      if (line.contains("table"))
        lines_[identity(line["table"], line["column"], line["row"], line["seed"], line["commit"], line["machine"])] = line;
  }
  /// A line a row; empty where one is missing.
  std::vector<Json> find(const PaperTable& table, std::size_t column, unsigned seed) const {
    std::vector<Json> found;
    for (const PaperRow& row : table.rows) {
      const auto line = lines_.find(identity(table.name, table.columns[column], row.name, seed, commit_, machine_));
      if (line == lines_.end()) return {};
      found.push_back(line->second);
    }
    return found;
  }
  Json line_of(const char* suite, const PaperTable& table, std::size_t column, std::size_t row, unsigned seed, const Score& score) const {
    Json line;
    line["suite"] = suite;
    line["table"] = table.name;
    line["column"] = table.columns[column];
    line["row"] = table.rows[row].name;
    line["seed"] = seed;
    line["error"] = number(score.error);
    line["us_per_step"] = number(score.microseconds);
    line["more"] = score.more;
    if (!score.failure.empty()) line["failure"] = score.failure;
    line["commit"] = commit_;
    line["machine"] = machine_;
    return line;
  }

 private:
  const std::string commit_ = commit();
  const Json machine_ = machine();
  std::map<std::string, Json> lines_;
};

unsigned runs_of(const PaperTable& table, const RunnerOptions& options) { return std::min(options.runs, table.most_runs); }

Cells run_table(const char* suite, const PaperTable& table, const RunnerOptions& options, ThreadPool& pool, Journal& journal,
                const Known& known, ProgressBar& bar) {
  Cells cells(table.rows.size(), std::vector<Cell>(table.columns.size()));
  for (unsigned run = 0; run < runs_of(table, options); ++run) {
    const unsigned seed = options.seed + run;
    bar.begin(table.name + ", seed " + std::to_string(seed));
    std::vector<std::vector<Json>> lines;
    std::vector<int> missing;
    for (std::size_t c = 0; c < table.columns.size(); ++c) {
      lines.push_back(known.find(table, c, seed));
      if (lines.back().empty()) missing.push_back(static_cast<int>(c));
    }
    parallel_for(&pool, static_cast<int>(missing.size()), [&](int i) {
      const std::size_t c = missing[i];
      const std::vector<Score> scores = attempted(table.rows.size(), [&] { return table.run(c, seed); });
      for (std::size_t r = 0; r < table.rows.size(); ++r) lines[c].push_back(known.line_of(suite, table, c, r, seed, scores.at(r)));
    });
    std::vector<Json> fresh;
    for (const int c : missing) fresh.insert(fresh.end(), lines[c].begin(), lines[c].end());
    journal.append(fresh);
    for (std::size_t c = 0; c < lines.size(); ++c)
      for (std::size_t r = 0; r < lines[c].size(); ++r) cells[r][c].add(lines[c][r]);
    bar.done_with_one();
  }
  return cells;
}

Json tracks_of(const char* suite, const PaperTable& table, unsigned seed) {
  Json line;
  line["suite"] = suite;
  line["tracks of"] = table.name;
  line["seed"] = seed;
  line["commit"] = commit();
  line["machine"] = machine();
  line["tracks"] = table.tracks(seed);
  return line;
}

}  // namespace

std::vector<Score> attempted(std::size_t rows, const std::function<std::vector<Score>()>& estimate) {
  constexpr double kNone = std::numeric_limits<double>::quiet_NaN();
  try {
    return estimate();
  } catch (const std::exception& error) {
    return std::vector<Score>(rows, {kNone, kNone, Json::object(), detail::demangled(typeid(error)) + ": " + error.what()});
  }
}

bool has_ceres() {
  const std::vector<std::string> names = backend_names();
  return std::find(names.begin(), names.end(), "ceres") != names.end();
}

Json track_of(const std::vector<Vector<2>>& positions, int every) {
  Json track = Json::array();
  for (std::size_t k = 0; k < positions.size(); k += every)
    track.push_back({0.01 * std::round(100 * positions[k][0]), 0.01 * std::round(100 * positions[k][1])});
  return track;
}

bool run_tables(const char* suite, const std::vector<PaperTable>& tables, const RunnerOptions& options, Journal& journal,
                Terminal& terminal) {
  ThreadPool pool(options.solver.threads);
  std::size_t work = 0;
  for (const PaperTable& table : tables) work += runs_of(table, options);
  ProgressBar bar(terminal, work);
  const Known known(journal, options.fresh);
  bool all_is_well = true;
  for (const PaperTable& table : tables) {
    const Cells cells = run_table(suite, table, options, pool, journal, known, bar);
    bar.clear();
    if (table.tracks) journal.append(tracks_of(suite, table, options.seed));
    const unsigned runs = runs_of(table, options);
    terminal.out << "== " << suite << ", " << table.name << "\n"
                 << table.what << "\nMedian (10 %-90 %) of " << runs << " runs, seeds " << options.seed << "-" << options.seed + runs - 1
                 << ". Commit " << commit() << ", " << machine()["cpu"].get<std::string>() << ", " << options.solver.threads
                 << " threads.\n";
    print_cells(terminal.out, table, cells);
    terminal.out << std::endl;
    if (any_failed(cells)) all_is_well = false;
  }
  terminal.out << "results: " << journal.path() << "\n" << std::endl;
  return all_is_well;
}

}  // namespace holdfast::bench
