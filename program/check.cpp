#include <CLI/CLI.hpp>
#include <holdfast/common/instance.hpp>
#include <holdfast/graph/check.hpp>
#include <holdfast/program/program.hpp>

namespace holdfast::program {

CLI::App* add_check(CLI::App& app, CheckArguments& arguments) {
  CLI::App* command = app.add_subcommand("check", "what is wrong with the problem of a file, by name; exit code 1 if it cannot be solved");
  command->add_option("FILE", arguments.file, "PyFG, g2o or TORO file")->required();
  return command;
}

int check_file(const CheckArguments& arguments, Terminal& terminal) {
  const FileProblem problem = load(arguments.file, {});
  const std::vector<Finding> findings = check(problem.instance.graph, problem.instance.start);
  if (!problem.unknown.empty()) terminal.out << "warning: unknown tag: " << problem.unknown << '\n';
  for (const Finding& finding : findings)
    terminal.out << (finding.severity == Finding::Severity::error ? "error: " : "warning: ") << to_string(finding.kind) << ": "
                 << finding.text << '\n';
  if (findings.empty() && problem.unknown.empty())
    terminal.out << "no findings: " << problem.instance.start.size() << " variables, " << problem.instance.graph.size() << " factors\n";
  return has_errors(findings) ? kFailed : kDone;
}

}  // namespace holdfast::program
