#include <unistd.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <holdfast/common/hosts.hpp>
#include <holdfast/common/log.hpp>
#include <holdfast/common/machine.hpp>
#include <holdfast/graph/dynamic_covariance_scaling.hpp>
#include <holdfast/graph/max_mixture.hpp>
#include <holdfast/graph/switchable_constraint.hpp>
#include <holdfast/program/completion.hpp>
#include <holdfast/program/output.hpp>
#include <holdfast/program/program.hpp>
#include <holdfast/solvers/table.hpp>
#include <iostream>

namespace holdfast::program {

std::vector<std::string> backends_of(const std::string& list) {
  const std::vector<std::string> known = backend_names();
  const auto contains = [](const std::vector<std::string>& names, const std::string& name) {
    return std::find(names.begin(), names.end(), name) != names.end();
  };
  std::vector<std::string> chosen;
  const auto choose = [&](const std::string& name) {
    if (!contains(chosen, name)) chosen.push_back(name);
  };
  std::istringstream parts(list);
  for (std::string part; std::getline(parts, part, ',');) {
    if (part == "all") {
      for (const char* name : {"ceres", "irls", "nesterov"})
        if (contains(known, name)) choose(name);
      for (const std::string& name : known)
        if (name.rfind("ceres-", 0) != 0) choose(name);
    } else {
      make_backend(part);  // BadOption lists the names
      choose(part);
    }
  }
  if (chosen.empty()) fail<BadOption>("--backend names no back-end; give a list such as ceres,irls or all");
  return chosen;
}

namespace {

/// Whether the command that is run has --json -.
bool json_goes_to_output(const CLI::App& app) {
  for (const CLI::App* command : app.get_subcommands())
    if (const CLI::Option* json = command->get_option_no_throw("--json"); json != nullptr && json->count() > 0)
      return json->as<std::string>() == "-";
  return false;
}

/// What is written where a command belongs and is none: "" where there is nothing to say.
std::string unknown_command(const CLI::App& app, int argc, const char* const* argv) {
  const char* const* const end = argv + argc;
  const char* const* const first = std::find_if(argv + std::min(argc, 1), end, [](const char* word) { return word[0] != '-'; });
  if (first == end) return "";
  std::string text = std::string("there is no command '") + *first + "'; there are:";
  for (const CLI::App* command : app.get_subcommands(nullptr)) {
    if (command->get_name() == *first) return "";
    text += " " + command->get_name();
  }
  return text + "; holdfast --help says what they do";
}

}  // namespace

int run(int argc, const char* const* argv, std::ostream& out, std::ostream& err) {
  register_hosts();
  register_loss<MaxMixture>();
  register_loss<DynamicCovarianceScaling>();
  register_loss<SwitchableConstraint>();
  CLI::App app{"holdfast: robust state estimation for many robots, on back-ends that compare", "holdfast"};
  app.set_version_flag("--version", "holdfast " HOLDFAST_VERSION " (" + commit() + ")");
  bool verbose = false;
  app.add_flag("-v,--verbose", verbose, "log what is going on (stderr)");
  bool quiet = false;
  app.add_flag("-q,--quiet", quiet, "no tables and no progress: errors, warnings, the files asked for and the exit code remain");
  app.footer(help_end());
  app.require_subcommand(1);
  app.fallthrough();
  SolveArguments solve_arguments;
  CheckArguments check_arguments;
  BenchArguments bench_arguments;
  const CLI::App* solve_command = add_solve(app, solve_arguments);
  TrackArguments track_arguments;
  const CLI::App* track_command = add_track(app, track_arguments);
  const CLI::App* check_command = add_check(app, check_arguments);
  ConvertArguments convert_arguments;
  const CLI::App* convert_command = add_convert(app, convert_arguments);
  SimulateArguments simulate_arguments;
  const CLI::App* simulate_command = add_simulate(app, simulate_arguments);
  NetworkArguments network_arguments;
  const CLI::App* network_command = add_network(app, network_arguments);
  add_bench(app, bench_arguments);
  CompareArguments compare_arguments;
  const CLI::App* compare_command = add_compare(app, compare_arguments);
  PlotArguments plot_arguments;
  const CLI::App* plot_command = add_plot(app, plot_arguments);
  ReportArguments report_arguments;
  const CLI::App* report_command = add_report(app, report_arguments);
  CompletionArguments completion_arguments;
  const CLI::App* completion_command = add_completion(app, completion_arguments);
  if (const std::string unknown = unknown_command(app, argc, argv); !unknown.empty()) {
    err << "holdfast: " << unknown << '\n';
    return kUsage;
  }
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    return app.exit(error, out, err) == 0 ? kDone : kUsage;
  }

  start_log(verbose);
  std::ostream nowhere(nullptr);
  Terminal terminal{quiet || json_goes_to_output(app) ? nowhere : out, err, !quiet && &err == &std::cerr && ::isatty(STDERR_FILENO) != 0,
                    out};
  track_arguments.quiet = quiet;
  const auto run_command = [&] {
    if (solve_command->parsed()) return solve(solve_arguments, terminal);
    if (track_command->parsed()) return track(track_arguments, std::cin, terminal);
    if (check_command->parsed()) return check_file(check_arguments, terminal);
    if (convert_command->parsed()) return convert(convert_arguments, terminal);
    if (simulate_command->parsed()) return simulate_file(simulate_arguments, terminal);
    if (network_command->parsed()) return network_of_processes(network_arguments, terminal);
    if (compare_command->parsed()) return compare_results(compare_arguments, terminal);
    if (plot_command->parsed()) return plot(plot_arguments, terminal);
    if (report_command->parsed()) return report(report_arguments, terminal);
    if (completion_command->parsed()) {
      terminal.data << completion(app, completion_arguments.shell);
      return static_cast<int>(kDone);
    }
    return bench(bench_arguments, terminal);
  };
  try {
    const int code = run_command();
    if (out.flush()) return code;
    err << "holdfast: cannot write all of the results to the standard output; is the disk full?\n";
    return kFailed;
  } catch (const BadOption& error) {
    err << "holdfast: " << error.what() << '\n';
    return kUsage;
  } catch (const std::exception& error) {
    err << "holdfast: " << error.what() << '\n';
    return kFailed;
  }
}

}  // namespace holdfast::program
