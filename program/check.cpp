#include <CLI/CLI.hpp>
#include <holdfast/common/instance.hpp>
#include <holdfast/graph/check.hpp>
#include <holdfast/program/output.hpp>
#include <holdfast/program/program.hpp>

namespace holdfast::program {

CLI::App* add_check(CLI::App& app, CheckArguments& arguments) {
  CLI::App* command = app.add_subcommand("check", "what is wrong with the problem of a file, by name; exit code 1 if it cannot be solved");
  command->add_option("FILE", arguments.file, "PyFG, g2o or TORO file")->required();
  add_reading(*command, arguments.reading);
  add_json(*command, arguments.json, "one JSON object");
  add_examples(*command, {"holdfast check plaza2.pyfg", "holdfast check intel.g2o --json - | jq .findings"});
  return command;
}

int check_file(const CheckArguments& arguments, Terminal& terminal) {
  check_json(arguments.json);
  ProblemOptions options;
  options.odometry = odometry_rule(arguments.reading.odometry);
  const FileProblem problem = load(arguments.file, options, read_options(arguments.reading));
  std::vector<Finding> findings = problem.findings;
  for (Finding& finding : check(problem.instance.graph, problem.instance.start)) findings.push_back(std::move(finding));
  terminal.out << "read: " << problem.used << '\n';
  if (!problem.unknown.empty()) terminal.out << "warning: unknown tag: " << problem.unknown << '\n';
  for (const Finding& finding : merged(findings))
    terminal.out << (finding.severity == Finding::Severity::error ? "error: " : "warning: ") << to_string(finding.kind) << ": "
                 << finding.text << '\n';
  if (findings.empty() && problem.unknown.empty())
    terminal.out << "no findings: " << problem.instance.start.size() << " variables, " << problem.instance.graph.size() << " factors\n";
  Json json{{"file", arguments.file},
            {"solvable", !has_errors(findings)},
            {"variables", problem.instance.start.size()},
            {"factors", problem.instance.graph.size()},
            {"read", problem.used},
            {"unknown", problem.unknown},
            {"findings", Json::array()}};
  for (const Finding& finding : findings)
    json["findings"].push_back({{"severity", finding.severity == Finding::Severity::error ? "error" : "warning"},
                                {"kind", to_string(finding.kind)},
                                {"text", finding.text}});
  write_json(arguments.json, {json}, terminal);
  return has_errors(findings) ? kFailed : kDone;
}

}  // namespace holdfast::program
