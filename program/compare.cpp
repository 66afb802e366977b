// `holdfast compare`: what got faster or worse between two outputs of bench.
#include <CLI/CLI.hpp>
#include <holdfast/common/table.hpp>
#include <holdfast/program/comparison.hpp>
#include <holdfast/program/output.hpp>
#include <holdfast/program/program.hpp>

namespace holdfast::program {

CLI::App* add_compare(CLI::App& app, CompareArguments& arguments) {
  CLI::App* command = app.add_subcommand("compare", "what got faster or worse between two outputs of bench, pair by pair");
  command->add_option("A", arguments.a, "before: a .jsonl file of bench, or a directory of them")->required();
  command->add_option("B", arguments.b, "after: another")->required();
  command->add_flag("--strict", arguments.strict, "exit code 1 where a back-end is slower, or a run fails or ends at a higher cost");
  add_json(*command, arguments.json, "one JSON object a back-end or method");
  add_examples(*command, {"holdfast compare before after", "holdfast compare before/data.jsonl after/data.jsonl --strict"});
  return command;
}

namespace {

void print(std::ostream& out, const Comparison& comparison) {
  constexpr std::size_t kMost = 20;
  constexpr auto left = Table::Align::left, right = Table::Align::right;
  Table table({{"back-end", left},
               {"pairs", right},
               {"B/A time", right},
               {"95 %", left},
               {"", left},
               {"costs: lower", right},
               {"equal", right},
               {"higher", right},
               {"newly failed", right},
               {"newly solved", right}});
  for (const GroupChange& group : comparison.groups)
    table.add({group.name, std::to_string(group.pairs), cell("%.3f", group.ratio),
               group.speed == Speed::too_few ? "-" : cell("%.3f", group.low) + " to " + cell("%.3f", group.high), to_string(group.speed),
               std::to_string(group.lower), std::to_string(group.equal), std::to_string(group.higher), std::to_string(group.newly_failed),
               std::to_string(group.newly_solved)});
  table.print(out);
  for (std::size_t i = 0; i < std::min(kMost, comparison.worse.size()); ++i) out << "worse: " << comparison.worse[i] << '\n';
  if (comparison.worse.size() > kMost) out << "worse: " << comparison.worse.size() - kMost << " more\n";
  if (comparison.only_a + comparison.only_b > 0)
    out << "without a partner: " << comparison.only_a << " runs of A, " << comparison.only_b << " of B\n";
}

std::vector<Json> lines_of(const Comparison& comparison) {
  const auto known = [](double number) { return std::isfinite(number) ? Json(number) : Json(); };
  std::vector<Json> lines;
  for (const GroupChange& group : comparison.groups)
    lines.push_back({{"name", group.name},
                     {"pairs", group.pairs},
                     {"timed", group.timed},
                     {"ratio", known(group.ratio)},
                     {"low", known(group.low)},
                     {"high", known(group.high)},
                     {"speed", to_string(group.speed)},
                     {"costs_lower", group.lower},
                     {"costs_equal", group.equal},
                     {"costs_higher", group.higher},
                     {"newly_failed", group.newly_failed},
                     {"newly_solved", group.newly_solved}});
  return lines;
}

}  // namespace

int compare_results(const CompareArguments& arguments, Terminal& terminal) {
  check_json(arguments.json);
  const Comparison comparison = compare(result_lines(arguments.a), result_lines(arguments.b));
  if (comparison.groups.empty())
    fail<BadFile>(arguments.a, " and ", arguments.b, " have no run in common: compare the same suites with the same settings and seeds");
  print(terminal.out, comparison);
  write_json(arguments.json, lines_of(comparison), terminal);
  return arguments.strict && comparison.is_worse() ? kFailed : kDone;
}

}  // namespace holdfast::program
