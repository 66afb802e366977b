#include <algorithm>
#include <holdfast/common/report.hpp>
#include <holdfast/graph/mirror.hpp>
#include <holdfast/program/second_look.hpp>
#include <holdfast/solvers/table.hpp>
#include <sstream>

namespace holdfast::program {
namespace {

std::string listed(const std::vector<Key>& keys) {
  constexpr std::size_t kMost = 6;
  std::string text;
  for (std::size_t i = 0; i < std::min(keys.size(), kMost); ++i) text += (i > 0 ? ", " : "") + keys[i].str();
  return keys.size() > kMost ? text + " and " + std::to_string(keys.size() - kMost) + " more" : text;
}

}  // namespace

std::string note_second_order(const Summary& summary, common::Json& run) {
  run["minimum"] = to_string(summary.minimum);
  run["saddles_left"] = summary.saddles_left;
  run["seconds_second_order"] = summary.seconds_second_order;
  const std::string name = run["backend"].get<std::string>();
  if (summary.minimum == Minimum::left_saddle)
    return name + " left a saddle (" + std::to_string(summary.saddles_left) + " in all): the answer is a second-order minimum";
  if (summary.minimum != Minimum::not_checked) return "";
  run["not_checked"] = summary.not_checked;
  return summary.saddles_left > 0 || summary.not_checked.find("saddle,") != std::string::npos
             ? name + ": the answer may be a saddle: " + summary.not_checked
             : "";
}

std::vector<MirrorAnswer> mirror_answers(const common::Task& task, const Graph& graph, const Values& answer, double cost) {
  std::vector<MirrorAnswer> all;
  Options options = task.options;
  options.progress = nullptr;
  const auto backend = make_backend(task.backend, options);
  for (const MirrorImage& image : mirror_images(graph, answer)) {
    MirrorAnswer other{"", mirrored(answer, image)};
    const Summary summary = backend->near_answer().solve(graph, other.answer);
    std::ostringstream text;
    text.precision(8);
    text << "mirror image: " << listed(image.points) << " on the other side of the " << (image.normal.size() == 3 ? "plane" : "line")
         << " of " << listed(image.anchors) << ": ";
    if (summary.usable())
      text << "cost " << summary.cost << " there, " << cost << " here";
    else
      text << "no answer there: " << summary.why();
    other.text = text.str();
    all.push_back(std::move(other));
  }
  return all;
}

void tell_ends_apart(const Graph& graph, const std::vector<Values>& answers, std::vector<common::Json>& runs) {
  constexpr int kIterations = 100;
  constexpr double kTight = 1e-13;
  const auto cost = [&](std::size_t i) { return runs[i]["cost"].get<double>(); };
  const auto counts = [&](std::size_t i) { return runs[i]["termination"] != "failed" && runs[i]["cost"].is_number(); };
  double best = std::numeric_limits<double>::infinity();
  for (std::size_t i = 0; i < runs.size(); ++i)
    if (counts(i)) best = std::min(best, cost(i));
  Options options;
  options.max_iterations = kIterations;
  options.cost_tolerance = kTight;
  const auto irls = make_backend("irls", options);
  for (std::size_t i = 0; i < runs.size(); ++i) {
    if (!counts(i)) continue;
    if (!common::differs(cost(i), best)) {
      runs[i]["ends"] = "at the lowest cost";
      continue;
    }
    Values further = answers[i];
    const Summary summary = irls->solve(graph, further);
    const bool arrives = summary.usable() && !common::differs(summary.cost, best);
    runs[i]["ends"] = arrives || summary.cost < best ? "not there yet" : "another minimum";
  }
}

}  // namespace holdfast::program
