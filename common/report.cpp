#include <algorithm>
#include <holdfast/common/report.hpp>
#include <holdfast/common/table.hpp>
#include <map>

namespace holdfast::common {
namespace {

constexpr double kNothing = 1e-6;  // of a cost, in squared sigmas: two exact fits differ by rounding and by where they stopped

std::string text(const Json& json, const char* format) { return json.is_number() ? cell(format, json.get<double>()) : "-"; }

/// Runs of one name were given the same problem.
std::string problem_of(const Json& run) {
  return run["file"].get<std::string>() + ", " + run["loss"].get<std::string>() + ", start " + run["start"].get<std::string>();
}

std::vector<std::string> numbers_of(const Json& run) {
  const bool any = run.contains("judged") && run["judged"].is_number() && run["judged"] != 0;
  const std::string rejected = any ? text(run["rejected_factors"], "%.0f") + "/" + text(run["judged"], "%.0f") : "-";
  return {text(run["cost_first"], "%.6g"),
          text(run["cost"], "%.8g"),
          text(run["iterations"], "%.0f"),
          text(run["seconds"], "%.4f"),
          text(run["ate_rmse"], "%.3f"),
          text(run["rmse"], "%.3f"),
          rejected};
}

std::string end_of(const Json& run) {
  std::string end = run["termination"].get<std::string>() + ": " + run["why"].get<std::string>();
  std::replace(end.begin(), end.end(), '\n', ' ');  // a culprit's values may fill several lines
  return end;
}

std::vector<Table::Column> number_columns() {
  std::vector<Table::Column> columns;
  for (const char* title : {"first cost", "cost", "iterations", "seconds", "ATE [m]", "unaligned [m]", "rejected"})
    columns.push_back({title, Table::Align::right});
  return columns;
}

void append(std::vector<std::string>& to, const std::vector<std::string>& from) { to.insert(to.end(), from.begin(), from.end()); }

}  // namespace

void print_solve(std::ostream& out, const std::vector<Json>& runs) {
  std::vector<Table::Column> columns{{"back-end", Table::Align::left}};
  for (const Table::Column& column : number_columns()) columns.push_back(column);
  columns.push_back({"ended", Table::Align::left});
  Table table(columns);
  for (const Json& run : runs) {
    std::vector<std::string> row{run["backend"].get<std::string>()};
    append(row, numbers_of(run));
    row.push_back(end_of(run));
    table.add(row);
  }
  table.print(out);
}

void print_suite(std::ostream& out, const std::vector<Json>& runs) {
  std::map<std::string, double> ceres_seconds;
  for (const Json& run : runs)
    if (run["backend"] == "ceres" && run["seconds"].is_number()) ceres_seconds[problem_of(run)] = run["seconds"].get<double>();

  std::vector<Table::Column> columns{{"problem", Table::Align::left}, {"loss", Table::Align::left}, {"back-end", Table::Align::left}};
  for (const Table::Column& column : number_columns()) columns.push_back(column);
  columns.push_back({"time/ceres", Table::Align::right});
  columns.push_back({"ended", Table::Align::left});
  Table table(columns);
  std::string before;
  for (const Json& run : runs) {
    const std::string problem = problem_of(run);
    const bool same = problem == before;
    before = problem;
    std::vector<std::string> row{same ? "" : run["file"].get<std::string>(), same ? "" : run["loss"].get<std::string>(),
                                 run["backend"].get<std::string>()};
    append(row, numbers_of(run));
    const auto ceres = ceres_seconds.find(problem);
    const bool comparable = ceres != ceres_seconds.end() && run["seconds"].is_number() && run["termination"] != "failed";
    row.push_back(comparable ? text(run["seconds"].get<double>() / ceres->second, "%.2f") : "-");
    row.push_back(run["termination"] == "failed" ? end_of(run) : run["termination"].get<std::string>());
    table.add(row);
  }
  table.print(out);
}

bool differs(double cost, double best) { return cost - best > kSameCost * std::abs(best) + kNothing; }

void print_differences(std::ostream& out, const std::vector<Json>& runs) {
  std::vector<std::string> order;
  std::map<std::string, std::vector<const Json*>> problems;
  for (const Json& run : runs) {
    if (run["termination"] == "failed" || !run["cost"].is_number()) continue;
    const std::string problem = problem_of(run);
    if (problems[problem].empty()) order.push_back(problem);
    problems[problem].push_back(&run);
  }
  const auto cost = [](const Json* run) { return (*run)["cost"].get<double>(); };
  for (const std::string& problem : order) {
    const auto& group = problems[problem];
    const Json* best = *std::min_element(group.begin(), group.end(), [&](const Json* a, const Json* b) { return cost(a) < cost(b); });
    std::string higher;
    for (const Json* run : group) {
      if (!differs(cost(run), cost(best))) continue;
      const double difference = cost(run) - cost(best);
      std::string why = (*run)["termination"] == "converged" ? "another minimum, or a flat valley" : "not there yet";
      if (run->contains("ends")) why = (*run)["ends"].get<std::string>();
      // Relative to a cost of next to nothing no number says anything.
      const bool is_relative = std::abs(cost(best)) > kNothing;
      higher += (higher.empty() ? " " : "; ") + (*run)["backend"].get<std::string>() + " " +
                text(is_relative ? difference / std::abs(cost(best)) : difference, "%+.2g") + (is_relative ? "" : " in all") + " (" +
                (*run)["termination"].get<std::string>() + ": " + why + ")";
    }
    if (!higher.empty())
      out << "different ends: " << problem << ": lowest cost " << text((*best)["cost"], "%.8g") << " ("
          << (*best)["backend"].get<std::string>() << "), relative to it" << higher << '\n';
  }
}

}  // namespace holdfast::common
