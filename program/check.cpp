#include <CLI/CLI.hpp>
#include <holdfast/common/instance.hpp>
#include <holdfast/graph/check.hpp>
#include <holdfast/program/program.hpp>

namespace holdfast::program {

CLI::App* add_check(CLI::App& app, CheckArguments& arguments) {
  CLI::App* command = app.add_subcommand("check", "what is wrong with the problem of a file, by name; exit code 1 if it cannot be solved");
  command->add_option("FILE", arguments.file, "PyFG, g2o or TORO file")->required();
  add_reading(*command, arguments.reading);
  return command;
}

int check_file(const CheckArguments& arguments, Terminal& terminal) {
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
  return has_errors(findings) ? kFailed : kDone;
}

}  // namespace holdfast::program
