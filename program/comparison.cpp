#include <algorithm>
#include <array>
#include <filesystem>
#include <fstream>
#include <holdfast/benchmarks/scenarios/random.hpp>
#include <holdfast/common/report.hpp>
#include <holdfast/graph/error.hpp>
#include <holdfast/program/comparison.hpp>
#include <limits>
#include <map>

namespace holdfast::program {

namespace fs = std::filesystem;
using common::Json;

namespace {

constexpr double kNone = std::numeric_limits<double>::quiet_NaN();

/// What says which run a line is of; all else is what came out.
constexpr std::array kIdentity{"suite", "file",   "graph",  "walk",    "network", "table",     "column",         "row",       "kind",
                               "share", "method", "stream", "backend", "loss",    "start",     "seed",           "threads",   "tolerance",
                               "nodes", "lag",    "step",   "window",  "windows", "threshold", "max_iterations", "time_limit"};

std::vector<Json> lines_of_file(const fs::path& path) {
  std::ifstream file(path);
  if (!file) fail<BadFile>("cannot read ", path.string(), "; give a .jsonl file of holdfast bench, or a directory of them");
  std::vector<Json> lines;
  std::string text;
  for (std::size_t number = 1; std::getline(file, text); ++number) {
    Json line = Json::parse(text, nullptr, false);
    if (!line.is_object()) fail<BadFile>(path.string(), ":", number, ": not a JSON object; expected a line of holdfast bench");
    lines.push_back(std::move(line));
  }
  if (lines.empty()) return lines;
  const Json newest = lines.back().value("commit", Json());
  lines.erase(std::remove_if(lines.begin(), lines.end(), [&](const Json& line) { return line.value("commit", Json()) != newest; }),
              lines.end());
  return lines;
}

double number_of(const Json& line, const char* name) {
  const auto it = line.find(name);
  return it != line.end() && it->is_number() ? it->get<double>() : kNone;
}
/// Of the whole solve; the median of a window.
double seconds_of(const Json& line) {
  const double seconds = number_of(line, "seconds");
  return std::isfinite(seconds) ? seconds : 1e-6 * number_of(line, "median_us");
}
bool is_run(const Json& line) { return std::isfinite(seconds_of(line)) || line.contains("cost"); }
bool failed(const Json& line) { return line.value("termination", Json()) == "failed"; }

std::string group_of(const Json& line) {
  for (const char* name : {"method", "backend", "row"})
    if (const auto it = line.find(name); it != line.end() && it->is_string()) return it->get<std::string>();
  return "all";
}

std::map<std::string, const Json*> runs_of(const std::vector<Json>& lines, std::size_t& other) {
  std::map<std::string, const Json*> runs;
  for (const Json& line : lines) {
    if (!is_run(line)) {
      ++other;
      continue;
    }
    std::string name;
    for (const char* field : kIdentity)
      if (const auto it = line.find(field); it != line.end() && !it->is_null())
        name += (name.empty() ? "" : ", ") + std::string(field) + " " + (it->is_string() ? it->get<std::string>() : it->dump());
    runs[name] = &line;  // the last one
  }
  return runs;
}

double mean(const std::vector<double>& numbers) {
  double sum = 0;
  for (const double number : numbers) sum += number;
  return sum / static_cast<double>(numbers.size());
}

void set_ratio(GroupChange& group, const std::vector<double>& logs) {
  constexpr int kDraws = 2000, kFewest = 5;
  constexpr double kTail = 0.025;
  group.timed = static_cast<int>(logs.size());
  group.ratio = group.low = group.high = kNone;
  if (logs.empty()) return;
  group.ratio = std::exp(mean(logs));
  if (group.timed < kFewest) return;
  bench::Random random(1);
  std::vector<double> means(kDraws);
  std::vector<double> drawn(logs.size());
  for (double& one : means) {
    for (double& log : drawn) log = logs[random.index(group.timed)];
    one = mean(drawn);
  }
  std::sort(means.begin(), means.end());
  group.low = std::exp(means[static_cast<std::size_t>(kTail * kDraws)]);
  group.high = std::exp(means[static_cast<std::size_t>((1 - kTail) * kDraws) - 1]);
  group.speed = group.high < 1 ? Speed::faster : group.low > 1 ? Speed::slower : Speed::open;
}

}  // namespace

const char* to_string(Speed speed) {
  switch (speed) {
    case Speed::faster:
      return "faster";
    case Speed::slower:
      return "slower";
    case Speed::open:
      return "no difference seen";
    default:
      return "too few pairs";
  }
}

std::vector<Json> result_lines(const std::string& path) {
  std::vector<Json> lines;
  if (fs::is_directory(path)) {
    std::vector<fs::path> files;
    for (const auto& entry : fs::directory_iterator(path))
      if (entry.path().extension() == ".jsonl") files.push_back(entry.path());
    std::sort(files.begin(), files.end());
    for (const fs::path& file : files)
      for (Json& line : lines_of_file(file)) lines.push_back(std::move(line));
  } else {
    lines = lines_of_file(path);
  }
  if (lines.empty()) fail<BadFile>(path, " holds no results; give a .jsonl file of holdfast bench, or a directory of them");
  return lines;
}

bool Comparison::is_worse() const {
  return !worse.empty() || std::any_of(groups.begin(), groups.end(), [](const GroupChange& group) { return group.speed == Speed::slower; });
}

Comparison compare(const std::vector<Json>& a, const std::vector<Json>& b) {
  Comparison comparison;
  const auto before = runs_of(a, comparison.other), after = runs_of(b, comparison.other);
  std::map<std::string, GroupChange> groups;
  std::map<std::string, std::vector<double>> logs;
  for (const auto& [name, old_run] : before) {
    const auto it = after.find(name);
    if (it == after.end()) {
      ++comparison.only_a;
      continue;
    }
    const Json& new_run = *it->second;
    GroupChange& group = groups[group_of(new_run)];
    ++group.pairs;
    if (failed(*old_run) || failed(new_run)) {
      if (failed(*old_run) && !failed(new_run)) ++group.newly_solved;
      if (!failed(*old_run) && failed(new_run)) {
        ++group.newly_failed;
        comparison.worse.push_back(name + ": failed");
      }
      continue;
    }
    const double old_seconds = seconds_of(*old_run), new_seconds = seconds_of(new_run);
    if (old_seconds > 0 && new_seconds > 0) logs[group_of(new_run)].push_back(std::log(new_seconds / old_seconds));
    const double old_cost = number_of(*old_run, "cost"), new_cost = number_of(new_run, "cost");
    if (!std::isfinite(old_cost) || !std::isfinite(new_cost)) continue;
    if (common::differs(new_cost, old_cost)) {
      ++group.higher;
      comparison.worse.push_back(name + ": cost " + Json(old_cost).dump() + " → " + Json(new_cost).dump());
    } else {
      ++(common::differs(old_cost, new_cost) ? group.lower : group.equal);
    }
  }
  for (const auto& [name, run] : after) comparison.only_b += before.count(name) == 0 ? 1 : 0;
  for (auto& [name, group] : groups) {
    group.name = name;
    set_ratio(group, logs[name]);
    comparison.groups.push_back(group);
  }
  return comparison;
}

}  // namespace holdfast::program
