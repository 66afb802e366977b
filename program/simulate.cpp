// `holdfast simulate`: a built-in scenario as a file.
#include <CLI/CLI.hpp>
#include <holdfast/adapters/files/convert.hpp>
#include <holdfast/adapters/files/problem.hpp>
#include <holdfast/program/output.hpp>
#include <holdfast/program/program.hpp>

namespace holdfast::program {

CLI::App* add_simulate(CLI::App& app, SimulateArguments& arguments) {
  CLI::App* command = app.add_subcommand("simulate", "write a built-in scenario as a PyFG or g2o file, the same for the same seed");
  std::vector<std::string> names;
  std::string known;
  for (const SimulatedScenario& scenario : simulated_scenarios()) {
    names.push_back(scenario.name);
    known += std::string("\n  ") + scenario.name + ": " + scenario.what;
  }
  SimulationOptions& simulation = arguments.simulation;
  command->add_option("SCENARIO", simulation.scenario, "of:" + known)->required()->check(CLI::IsMember(names));
  command->add_option("OUT", arguments.out, "the file to write: .pyfg, .g2o, .graph or .toro (TORO), .jrl")->required();
  command->add_option("--agents", simulation.agents, "robots of a fleet (at most 25), nodes of a swarm or network")
      ->check(CLI::PositiveNumber);
  command->add_option("--steps", simulation.steps, "of a fleet, a ring or a walk")->check(CLI::PositiveNumber);
  command->add_option("--noise", simulation.noise, "times the scenario's own")->check(CLI::PositiveNumber)->capture_default_str();
  command->add_option("--outliers", simulation.outliers, "share of false ranges and closures")
      ->check(CLI::Range(0.0, 1.0))
      ->capture_default_str();
  command->add_option("--lost", simulation.lost, "share of ranges and closures left out")
      ->check(CLI::Range(0.0, 1.0))
      ->capture_default_str();
  command->add_option("--seed", simulation.seed)->capture_default_str();
  command
      ->add_option("--vertices", arguments.vertices,
                   "truth, start, or auto: the truth in PyFG, which is what its vertices are, the start in all others")
      ->check(CLI::IsMember({"auto", "truth", "start"}))
      ->capture_default_str();
  add_json(*command, arguments.json, "one JSON object");
  add_examples(*command, {"holdfast simulate fleet fleet.pyfg --agents 5 --outliers 0.1 --lost 0.3",
                          "holdfast simulate ring ring.g2o --steps 500 --outliers 0.3 --seed 7"});
  return command;
}

int simulate_file(const SimulateArguments& arguments, Terminal& terminal) {
  check_json(arguments.json);
  const std::optional<Format> format = format_of_name(arguments.out);
  const bool is_jrl = arguments.out.size() > 4 && arguments.out.compare(arguments.out.size() - 4, 4, ".jrl") == 0;
  if (!format && !is_jrl) fail<BadOption>("OUT ", arguments.out, ": its ending names no format; give .pyfg, .g2o, .graph, .toro or .jrl");
  const Simulation simulation = simulate(arguments.simulation);
  const bool has_truth = arguments.vertices == "truth" || (arguments.vertices == "auto" && format == Format::PyFG);
  const Dataset dataset = has_truth ? with_values(simulation.dataset, simulation.truth) : simulation.dataset;
  for (const std::string& note : write_converted(arguments.out, dataset, "")) terminal.err << "holdfast: note: " << note << '\n';
  terminal.out << arguments.out << ": " << arguments.simulation.scenario << ", seed " << arguments.simulation.seed << ", "
               << dataset.vertices.size() << " variables (" << (has_truth ? "truth" : "start") << "), " << dataset.edges.size()
               << " measurements, " << simulation.false_measurements << " of them false, " << simulation.lost_measurements << " lost\n";
  const SimulationOptions& asked = arguments.simulation;
  const Json json{{"out", arguments.out},
                  {"scenario", asked.scenario},
                  {"seed", asked.seed},
                  {"noise", asked.noise},
                  {"outliers", asked.outliers},
                  {"lost", asked.lost},
                  {"vertices", has_truth ? "truth" : "start"},
                  {"variables", dataset.vertices.size()},
                  {"measurements", dataset.edges.size()},
                  {"false_measurements", simulation.false_measurements},
                  {"lost_measurements", simulation.lost_measurements}};
  write_json(arguments.json, {json}, terminal);
  return kDone;
}

}  // namespace holdfast::program
