#include <algorithm>
#include <cstdio>
#include <holdfast/benchmarks/machine.hpp>
#include <holdfast/benchmarks/papers/paper.hpp>
#include <holdfast/benchmarks/table.hpp>
#include <holdfast/graph/parallel.hpp>
#include <map>
#include <set>

namespace holdfast::bench {
namespace {

/// The scores of one row in one column, seed by seed.
struct Cell {
  std::vector<double> errors, microseconds;
  std::map<std::string, std::vector<double>> more;

  void add(const Json& line) {
    const auto number = [](const Json& json) { return json.is_number() ? json.get<double>() : std::numeric_limits<double>::quiet_NaN(); };
    errors.push_back(number(line["error"]));
    microseconds.push_back(number(line["us_per_step"]));
    for (const auto& [name, value] : line["more"].items())
      if (value.is_number()) more[name].push_back(value.get<double>());
  }
};
using Cells = std::vector<std::vector<Cell>>;  // by row, then column

std::string identity(const std::string& table, const std::string& column, const std::string& row, unsigned seed, const std::string& commit,
                     const Json& machine) {
  return table + '|' + column + '|' + row + '|' + std::to_string(seed) + '|' + commit + '|' + machine.dump();
}

Json number(double value) { return std::isfinite(value) ? Json(value) : Json(nullptr); }

std::string text(double value) {
  if (!std::isfinite(value)) return "-";
  char buffer[40];
  std::snprintf(buffer, sizeof buffer, "%.4g", value);
  return buffer;
}

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
    line["commit"] = commit_;
    line["machine"] = machine_;
    return line;
  }

 private:
  const std::string commit_ = commit();
  const Json machine_ = machine();
  std::map<std::string, Json> lines_;
};

Cells run_table(const char* suite, const PaperTable& table, const RunnerOptions& options, ThreadPool& pool, Journal& journal,
                const Known& known, ProgressBar& bar) {
  Cells cells(table.rows.size(), std::vector<Cell>(table.columns.size()));
  for (unsigned run = 0; run < options.runs; ++run) {
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
      const std::vector<Score> scores = table.run(c, seed);
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

std::string mean_and_range(const std::vector<double>& numbers) {
  double sum = 0;
  for (const double x : numbers) sum += x;
  const auto [least, largest] = std::minmax_element(numbers.begin(), numbers.end());
  return text(sum / static_cast<double>(numbers.size())) + " (" + text(*least) + "-" + text(*largest) + ")";
}

std::vector<Table::Column> titles(const PaperTable& table, const std::string& first) {
  std::vector<Table::Column> columns{{first, Table::Align::left}};
  for (const std::string& column : table.columns) columns.push_back({column, Table::Align::right});
  return columns;
}

void print_errors(std::ostream& out, const PaperTable& table, const Cells& cells) {
  std::vector<Table::Column> columns = titles(table, "");
  columns.push_back({"µs/step", Table::Align::right});
  Table printed(columns);
  for (std::size_t r = 0; r < cells.size(); ++r) {
    const PaperRow& row = table.rows[r];
    if (!row.paper.empty()) {
      std::vector<std::string> line{row.name + ": paper"};
      for (std::size_t c = 0; c < table.columns.size(); ++c) line.push_back(c < row.paper.size() ? text(row.paper[c]) : "-");
      line.push_back("");
      printed.add(line);
    }
    std::vector<std::string> line{row.paper.empty() ? row.name : "  here"};
    std::vector<double> microseconds;
    for (const Cell& cell : cells[r]) {
      line.push_back(text(quantile(cell.errors, 0.5)) + " (" + text(quantile(cell.errors, 0.1)) + "-" + text(quantile(cell.errors, 0.9)) +
                     ")");
      microseconds.insert(microseconds.end(), cell.microseconds.begin(), cell.microseconds.end());
    }
    line.push_back(text(quantile(microseconds, 0.5)));
    printed.add(line);
  }
  printed.print(out);
}

void print_more(std::ostream& out, const PaperTable& table, const Cells& cells) {
  std::set<std::string> names;
  for (const auto& row : cells)
    for (const Cell& cell : row)
      for (const auto& [name, numbers] : cell.more) names.insert(name);
  for (const std::string& name : names) {
    Table printed(titles(table, name + ": mean (least-largest)"));
    for (std::size_t r = 0; r < cells.size(); ++r) {
      std::vector<std::string> line{table.rows[r].name};
      bool any = false;
      for (const Cell& cell : cells[r]) {
        const auto numbers = cell.more.find(name);
        any = any || numbers != cell.more.end();
        line.push_back(numbers == cell.more.end() ? "-" : mean_and_range(numbers->second));
      }
      if (any) printed.add(line);
    }
    printed.print(out);
  }
}

bool any_failed(const Cells& cells) {
  for (const auto& row : cells)
    for (const Cell& cell : row)
      for (const double error : cell.errors)
        if (!std::isfinite(error)) return true;
  return false;
}

}  // namespace

double quantile(std::vector<double> numbers, double q) {
  numbers.erase(std::remove_if(numbers.begin(), numbers.end(), [](double x) { return std::isnan(x); }), numbers.end());
  if (numbers.empty()) return std::numeric_limits<double>::quiet_NaN();
  std::sort(numbers.begin(), numbers.end());
  const double place = q * static_cast<double>(numbers.size() - 1);
  const auto below = static_cast<std::size_t>(place);
  const std::size_t above = std::min(below + 1, numbers.size() - 1);
  return numbers[below] + (place - static_cast<double>(below)) * (numbers[above] - numbers[below]);
}

bool run_tables(const char* suite, const std::vector<PaperTable>& tables, const RunnerOptions& options, Journal& journal,
                Terminal& terminal) {
  ThreadPool pool(options.solver.threads);
  ProgressBar bar(terminal, tables.size() * options.runs);
  const Known known(journal, options.fresh);
  bool all_is_well = true;
  for (const PaperTable& table : tables) {
    const Cells cells = run_table(suite, table, options, pool, journal, known, bar);
    bar.clear();
    terminal.out << "== " << suite << ", " << table.name << "\n"
                 << table.what << "\nMedian (10 %-90 %) of " << options.runs << " runs, seeds " << options.seed << "-"
                 << options.seed + options.runs - 1 << ". Commit " << commit() << ", " << machine()["cpu"].get<std::string>() << ", "
                 << options.solver.threads << " threads.\n";
    print_errors(terminal.out, table, cells);
    print_more(terminal.out, table, cells);
    terminal.out << std::endl;
    if (any_failed(cells)) all_is_well = false;
  }
  terminal.out << "results: " << journal.path() << "\n" << std::endl;
  return all_is_well;
}

}  // namespace holdfast::bench
