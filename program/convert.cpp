#include <CLI/CLI.hpp>
#include <algorithm>
#include <filesystem>
#include <holdfast/adapters/files/convert.hpp>
#include <holdfast/adapters/files/report.hpp>
#include <holdfast/common/instance.hpp>
#include <holdfast/graph/files/files.hpp>
#include <holdfast/graph/files/jrl.hpp>
#include <holdfast/graph/files/tum.hpp>
#include <holdfast/program/output.hpp>
#include <holdfast/program/program.hpp>

namespace holdfast::program {

CLI::App* add_convert(CLI::App& app, ConvertArguments& arguments) {
  CLI::App* command = app.add_subcommand("convert", "write a file in another format; says what that format cannot hold");
  command->add_option("IN", arguments.in, "PyFG, g2o, TORO or JRL file, MRPT's .rawlog")->required();
  command->add_option("OUT", arguments.out, "the file to write: .g2o, .pyfg, .graph or .toro (TORO), .jrl; a directory for --to tum")
      ->required();
  command->add_option("--to", arguments.to, "the format, where the name of OUT does not say it")
      ->check(CLI::IsMember({"g2o", "pyfg", "toro", "jrl", "tum"}));
  add_reading(*command, arguments.reading);
  add_json(*command, arguments.json, "one JSON object");
  add_examples(*command, {"holdfast convert plaza2.pyfg plaza2.jrl", "holdfast convert intel.g2o trajectories --to tum"});
  return command;
}

namespace {

/// JRL has robots' measurements with covariances, as PyFG has, and keeps what was read from JRL.
Conversion for_jrl(const Dataset& dataset) {
  const auto is_kept = [](const UnknownLine& line) { return !line.text.empty() && line.text[0] == '"'; };
  Dataset rest = dataset;
  rest.unknown.erase(std::remove_if(rest.unknown.begin(), rest.unknown.end(), is_kept), rest.unknown.end());
  Conversion conversion = converted(rest, Format::PyFG);
  if (!conversion.dataset.unknown.empty()) conversion.notes.push_back(unknown_report(conversion.dataset));
  conversion.dataset.unknown.clear();
  std::copy_if(dataset.unknown.begin(), dataset.unknown.end(), std::back_inserter(conversion.dataset.unknown), is_kept);
  return conversion;
}

}  // namespace

std::vector<std::string> write_converted(const std::string& path, const Dataset& dataset, const std::string& to) {
  if (to == "tum") {
    write_tum_directory(path, vertex_start(dataset), vertex_times(dataset));
    return {"edges are left out: TUM has trajectories alone"};
  }
  if (to == "jrl" || (to.empty() && path.size() > 4 && path.substr(path.size() - 4) == ".jrl")) {
    Conversion conversion = for_jrl(dataset);
    write_jrl(path, conversion.dataset);
    return conversion.notes;
  }
  const std::optional<Format> named = to.empty() ? format_of_name(path) : format_of_name("." + to);
  const Conversion conversion = converted(dataset, named.value_or(dataset.format));
  write_dataset(path, conversion.dataset, named.value_or(dataset.format));
  return conversion.notes;
}

int convert(const ConvertArguments& arguments, Terminal& terminal) {
  check_json(arguments.json);
  const Dataset dataset = read_any(arguments.in, read_options(arguments.reading));
  const std::string used = use_report(dataset, odometry_rule(arguments.reading.odometry));
  Json json{{"in", arguments.in}, {"out", arguments.out}, {"read", used}, {"warnings", Json::array()}, {"notes", Json::array()}};
  for (const Finding& finding : check(dataset)) {
    terminal.err << "holdfast: warning: " << finding.text << '\n';
    json["warnings"].push_back(finding.text);
  }
  for (const std::string& note : write_converted(arguments.out, dataset, arguments.to)) {
    terminal.err << "holdfast: note: " << note << '\n';
    json["notes"].push_back(note);
  }
  terminal.out << arguments.in << ": " << used << '\n' << "written: " << arguments.out << '\n';
  write_json(arguments.json, {json}, terminal);
  return kDone;
}

}  // namespace holdfast::program
