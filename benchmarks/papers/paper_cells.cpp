#include <algorithm>
#include <cstdio>
#include <holdfast/benchmarks/papers/paper_cells.hpp>
#include <holdfast/common/table.hpp>
#include <ostream>
#include <set>

namespace holdfast::bench {
namespace {

std::string text(double value) { return common::cell("%.4g", value); }

std::string median_and_band(const Cell& cell) {
  std::string text_of =
      text(quantile(cell.errors, 0.5)) + " (" + text(quantile(cell.errors, 0.1)) + "-" + text(quantile(cell.errors, 0.9)) + ")";
  if (!cell.failures.empty()) text_of += ", " + std::to_string(cell.failures.size()) + " failed";
  return text_of;
}

std::string mean_and_range(const std::vector<double>& numbers) {
  double sum = 0;
  for (const double x : numbers) sum += x;
  const auto [least, largest] = std::minmax_element(numbers.begin(), numbers.end());
  return text(sum / static_cast<double>(numbers.size())) + " (" + text(*least) + "-" + text(*largest) + ")";
}

/// Where the mean of a consistent estimator's ANEES lies in 95 % of all cases.
std::string consistent_band(double freedom) {
  const double half = 1.96 * std::sqrt(2 / freedom);
  char buffer[60];
  std::snprintf(buffer, sizeof buffer, "; 95 %%: %.3f-%.3f", 1 - half, 1 + half);
  return buffer;
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
      line.push_back(median_and_band(cell));
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
        const auto freedom = cell.freedom.find(name);
        any = any || numbers != cell.more.end();
        line.push_back(numbers == cell.more.end() ? "-" : mean_and_range(numbers->second));
        if (freedom != cell.freedom.end()) line.back() += consistent_band(freedom->second);
      }
      if (any) printed.add(line);
    }
    printed.print(out);
  }
}

void print_failures(std::ostream& out, const PaperTable& table, const Cells& cells) {
  for (std::size_t r = 0; r < cells.size(); ++r)
    for (std::size_t c = 0; c < cells[r].size(); ++c) {
      const Cell& cell = cells[r][c];
      if (!cell.failures.empty())
        out << "FAILED: " << table.rows[r].name << ", " << table.columns[c] << ": " << cell.failures.size() << " of " << cell.errors.size()
            << " runs, the first with " << cell.failures.front() << "\n";
    }
}

}  // namespace

void Cell::add(const Json& line) {
  const auto number = [](const Json& json) { return json.is_number() ? json.get<double>() : std::numeric_limits<double>::quiet_NaN(); };
  errors.push_back(number(line["error"]));
  microseconds.push_back(number(line["us_per_step"]));
  for (const auto& [name, value] : line["more"].items()) {
    if (value.is_number()) more[name].push_back(value.get<double>());
    if (!value.is_object()) continue;
    more[name].push_back(value["value"].get<double>());
    freedom[name] += value["freedom"].get<double>();
  }
  if (!std::isfinite(errors.back()))
    failures.push_back("seed " + line["seed"].dump() + ": " + line.value("failure", "an error that is not a number"));
}

void print_cells(std::ostream& out, const PaperTable& table, const Cells& cells) {
  print_errors(out, table, cells);
  print_more(out, table, cells);
  print_failures(out, table, cells);
}

bool any_failed(const Cells& cells) {
  for (const auto& row : cells)
    for (const Cell& cell : row)
      if (!cell.failures.empty()) return true;
  return false;
}

double quantile(std::vector<double> numbers, double q) {
  numbers.erase(std::remove_if(numbers.begin(), numbers.end(), [](double x) { return std::isnan(x); }), numbers.end());
  if (numbers.empty()) return std::numeric_limits<double>::quiet_NaN();
  std::sort(numbers.begin(), numbers.end());
  const double place = q * static_cast<double>(numbers.size() - 1);
  const auto below = static_cast<std::size_t>(place);
  const std::size_t above = std::min(below + 1, numbers.size() - 1);
  return numbers[below] + (place - static_cast<double>(below)) * (numbers[above] - numbers[below]);
}

}  // namespace holdfast::bench
