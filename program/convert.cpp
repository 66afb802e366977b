#include <CLI/CLI.hpp>
#include <filesystem>
#include <holdfast/adapters/files/convert.hpp>
#include <holdfast/adapters/files/report.hpp>
#include <holdfast/common/instance.hpp>
#include <holdfast/graph/files/files.hpp>
#include <holdfast/graph/files/tum.hpp>
#include <holdfast/program/program.hpp>

namespace holdfast::program {

CLI::App* add_convert(CLI::App& app, ConvertArguments& arguments) {
  CLI::App* command = app.add_subcommand("convert", "write a file in another format; says what that format cannot hold");
  command->add_option("IN", arguments.in, "PyFG, g2o or TORO file, MRPT's .rawlog")->required();
  command->add_option("OUT", arguments.out, "the file to write: .g2o, .pyfg, .graph or .toro (TORO); a directory for --to tum")->required();
  command->add_option("--to", arguments.to, "the format, where the name of OUT does not say it")
      ->check(CLI::IsMember({"g2o", "pyfg", "toro", "tum"}));
  add_reading(*command, arguments.reading);
  return command;
}

std::vector<std::string> write_converted(const std::string& path, const Dataset& dataset, const std::string& to) {
  if (to == "tum") {
    write_tum_directory(path, vertex_start(dataset), vertex_times(dataset));
    return {"edges are left out: TUM has trajectories alone"};
  }
  const std::optional<Format> named = to.empty() ? format_of_name(path) : format_of_name("." + to);
  const Conversion conversion = converted(dataset, named.value_or(dataset.format));
  write_dataset(path, conversion.dataset, named.value_or(dataset.format));
  return conversion.notes;
}

int convert(const ConvertArguments& arguments, Terminal& terminal) {
  const Dataset dataset = read_any(arguments.in, read_options(arguments.reading));
  for (const Finding& finding : check(dataset)) terminal.err << "holdfast: warning: " << finding.text << '\n';
  for (const std::string& note : write_converted(arguments.out, dataset, arguments.to)) terminal.err << "holdfast: note: " << note << '\n';
  terminal.out << arguments.in << ": " << use_report(dataset, odometry_rule(arguments.reading.odometry)) << '\n'
               << "written: " << arguments.out << '\n';
  return kDone;
}

}  // namespace holdfast::program
