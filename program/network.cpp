// `holdfast network`: a network of agents in many processes.
#include <CLI/CLI.hpp>
#include <cmath>
#include <holdfast/program/output.hpp>
#include <holdfast/program/program.hpp>
#ifdef HOLDFAST_WITH_MPI
#include <holdfast/program/spread_network.hpp>
#include <holdfast/solvers/detail/clock.hpp>
#include <holdfast/solvers/distributed/nesterov_mpi.hpp>
#include <holdfast/solvers/distributed/petsc.hpp>
#include <holdfast/solvers/distributed/state.hpp>
#include <numeric>
#endif

namespace holdfast::program {

CLI::App* add_network(CLI::App& app, NetworkArguments& arguments) {
  CLI::App* command = app.add_subcommand("network", "solve a random network of agents by ranges, in as many processes as mpirun starts");
  command->add_option("--agents", arguments.agents, "one a square metre, a tenth of them anchors, eight neighbours each")
      ->check(CLI::Range(2, 2000000000))
      ->capture_default_str();
  command->add_option("--backend", arguments.backend)->check(CLI::IsMember({"petsc", "nesterov-mpi"}))->capture_default_str();
  command->add_option("--petsc", arguments.petsc, "PETSc's own options, as one text: \"-ksp_type cg -pc_type asm\"");
  command->add_option("--start", arguments.start, "anchors: amid the anchors about; middle: all in the middle of the network")
      ->check(CLI::IsMember({"anchors", "middle"}))
      ->capture_default_str();
  command->add_option("--state", arguments.state, "a directory: goes on from the state there, and saves it every iteration (petsc)");
  command->add_option("--tolerance", arguments.tolerance, "relative decrease of the cost that ends the solve")
      ->check(CLI::NonNegativeNumber)
      ->capture_default_str();
  command->add_option("--linear-tolerance", arguments.linear_tolerance, "relative residual of PETSc's iterative solvers")
      ->check(CLI::Range(1e-16, 0.999))
      ->capture_default_str();
  command->add_option("--max-iterations", arguments.max_iterations, "0: the back-end's own limit")->check(CLI::NonNegativeNumber);
  command->add_option("--threads", arguments.threads, "of each process")->check(CLI::PositiveNumber)->capture_default_str();
  command->add_option("--seed", arguments.seed)->capture_default_str();
  add_json(*command, arguments.json, "one JSON object");
  add_examples(*command, {"holdfast network --agents 10000", "mpirun -np 4 holdfast network --agents 1000000",
                          "mpirun -np 4 holdfast network --agents 100000 --state state   # killed: the same line goes on"});
  return command;
}

#ifdef HOLDFAST_WITH_MPI
namespace {

Summary solve_network(const NetworkArguments& arguments, DistributedGraph& graph, Json& json) {
  Options options;
  options.cost_tolerance = arguments.tolerance;
  options.max_iterations = arguments.max_iterations;
  options.threads = arguments.threads;
  if (arguments.backend == "nesterov-mpi") return NesterovMpi(options).solve(graph);
  if (!arguments.state.empty())
    options.progress = [&](const Iteration& iteration) {
      save_state(graph, arguments.state, iteration.number);
      return true;
    };
  OfPetsc of_petsc;
  of_petsc.text = arguments.petsc;
  of_petsc.tolerance = arguments.linear_tolerance;
  Petsc petsc(options, of_petsc);
  Summary summary = petsc.solve(graph);
  const PetscReport& report = petsc.report();
  json["linear_solver"] = report.solver;
  json["linear_systems"] = report.iterations.size();
  json["linear_iterations"] = std::accumulate(report.iterations.begin(), report.iterations.end(), std::int64_t{0});
  json["linear_iterations_most"] = report.iterations.empty() ? 0 : *std::max_element(report.iterations.begin(), report.iterations.end());
  return summary;
}

}  // namespace

int network_of_processes(const NetworkArguments& arguments, Terminal& terminal) {
  check_json(arguments.json);
  if (!arguments.state.empty() && arguments.backend != "petsc") fail<BadOption>("--state is of --backend petsc");
  const Communicator all;
  Stopwatch watch;
  SpreadNetwork part = spread_network(arguments.agents, arguments.seed, arguments.start == "anchors", all.rank(), all.size());
  DistributedGraph graph(all, std::move(part.graph), std::move(part.values));
  const double seconds_made = all.max(watch.seconds());
  Json json;
  const std::int64_t resumed = arguments.state.empty() ? 0 : load_state(graph, arguments.state);
  const std::int64_t agents = graph.total_variables(), ranges = graph.total_factors();
  const double boundary = all.sum(8.0 * static_cast<double>(graph.boundary_numbers()));
  const double links = all.sum(static_cast<double>(graph.neighbours().size()));
  graph.communicator().traffic() = {};
  const Summary summary = solve_network(arguments, graph, json);
  const Traffic& traffic = graph.communicator().traffic();
  double sent[2] = {static_cast<double>(traffic.bytes), static_cast<double>(traffic.messages)};
  const auto reductions = traffic.reductions;
  all.sum(sent, 2);
  const double seconds = all.max(summary.seconds);
  if (!arguments.state.empty() && summary.usable()) save_state(graph, arguments.state, summary.iterations);
  if (all.rank() != 0) return summary.usable() ? kDone : kFailed;

  terminal.out << agents << " agents, " << ranges << " ranges, " << all.size() << " processes, seed " << arguments.seed << "; made in "
               << seconds_made << " s\n";
  if (resumed > 0) terminal.out << "gone on from " << arguments.state << " for " << resumed << " of them\n";
  terminal.out.precision(15);
  terminal.out << arguments.backend << ": cost " << summary.cost_first << " -> " << summary.cost << '\n';
  terminal.out.precision(6);
  terminal.out << "  " << to_string(summary.termination) << " (" << summary.why() << "), " << summary.iterations << " iterations, "
               << seconds << " s";
  if (std::isfinite(summary.decrement) && summary.cost > 0)
    terminal.out << "; above the minimum by about " << summary.decrement / summary.cost << " of the cost";
  terminal.out << "\n  boundary states: " << boundary << " bytes in " << links << " messages for all; sent in the solve: " << sent[0]
               << " bytes, " << sent[1] << " messages; reductions: " << reductions << " a process\n";
  if (json.contains("linear_solver"))
    terminal.out << "  " << json["linear_solver"].get<std::string>() << ": " << json["linear_systems"] << " systems, "
                 << json["linear_iterations"] << " iterations, at most " << json["linear_iterations_most"] << "\n";
  json.update(Json{{"agents", agents},
                   {"ranges", ranges},
                   {"processes", all.size()},
                   {"seed", arguments.seed},
                   {"backend", arguments.backend},
                   {"resumed", resumed},
                   {"cost_first", summary.cost_first},
                   {"cost", summary.cost},
                   {"decrement", summary.decrement},
                   {"termination", to_string(summary.termination)},
                   {"iterations", summary.iterations},
                   {"boundary_bytes", boundary},
                   {"boundary_messages", links},
                   {"bytes", sent[0]},
                   {"messages", sent[1]},
                   {"reductions", reductions},
                   {"seconds_made", seconds_made},
                   {"seconds", seconds}});
  write_json(arguments.json, {json}, terminal);
  return summary.usable() ? kDone : kFailed;
}
#else
int network_of_processes(const NetworkArguments&, Terminal&) {
  fail<BadOption>(
      "this holdfast was built without MPI and PETSc; install them (Debian: libopenmpi-dev openmpi-bin libpetsc-real-dev) and "
      "build it with -DHOLDFAST_MPI=ON");
}
#endif

}  // namespace holdfast::program
