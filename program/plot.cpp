// `holdfast plot`: a file and its answer as a picture.
#include <CLI/CLI.hpp>
#include <filesystem>
#include <holdfast/common/progress_bar.hpp>
#include <holdfast/graph/files/atomic.hpp>
#include <holdfast/program/output.hpp>
#include <holdfast/program/picture.hpp>
#include <holdfast/program/program.hpp>
#include <holdfast/solvers/table.hpp>

namespace holdfast::program {

namespace fs = std::filesystem;

CLI::App* add_plot(CLI::App& app, PlotArguments& arguments) {
  CLI::App* command =
      app.add_subcommand("plot", "draw a file: ways, landmarks, ranges, outliers, truth where it is known, as one HTML page");
  command->add_option("FILE", arguments.file, "PyFG, g2o or TORO file, MRPT's .graph and .rawlog")->required();
  command->add_option("OUT", arguments.out, "the page; FILE with the ending .html where it is not given");
  command->add_option("--backend", arguments.backend, "what solves the file; none: its vertices as they are")->capture_default_str();
  command->add_option("--loss", arguments.loss, "of every measurement but the odometry; says which ones are outliers")
      ->capture_default_str();
  command->add_option("--start", arguments.start, "as solve has it")
      ->check(CLI::IsMember({"file", "odometry", "chordal", "convex"}))
      ->capture_default_str();
  command->add_option("--seed", arguments.seed, "of the landmarks' start under --start odometry")->capture_default_str();
  add_reading(*command, arguments.reading);
  add_json(*command, arguments.json, "what is drawn as one JSON object");
  add_examples(*command, {"holdfast plot plaza2.pyfg --start odometry", "holdfast plot intel.g2o intel.html --backend none"});
  return command;
}

int plot(const PlotArguments& arguments, Terminal& terminal) {
  constexpr std::size_t kMost = 5000;
  check_json(arguments.json);
  ProblemOptions options;
  options.loss = Loss::parse(arguments.loss);
  options.start = start_named(arguments.start);
  options.seed = arguments.seed;
  options.odometry = odometry_rule(arguments.reading.odometry);
  const bool is_solved = arguments.backend != "none";
  Task task{arguments.file, arguments.loss, arguments.start, arguments.backend, arguments.seed, {}};
  if (is_solved) make_backend(arguments.backend, task.options);  // BadOption lists the names, before any work
  ProgressBar bar(terminal, 1);
  bar.begin("reading " + arguments.file);
  task.options.progress = bar.callback();
  const FileProblem problem = load(arguments.file, options, read_options(arguments.reading));
  Values answer = problem.instance.start;
  std::string caption = "Vertices as they stand in the file, seen from above.";
  if (is_solved) {
    const Run run = run_task(task, problem.instance, answer);
    if (!run.summary.usable())
      fail<BadNumber>(arguments.file, ": ", arguments.backend, ": ", run.summary.str(), "; --backend none draws it");
    caption = "Answer of " + arguments.backend + " under " + arguments.loss + " from the start '" + arguments.start +
              "', seen from above; " + run.summary.str();
  }
  if (problem.instance.truth.size() > 0) caption += ". Laid onto the truth by a rigid motion, as the ATE has it.";
  bar.clear();
  const Drawing drawing = drawing_of(problem.instance.graph, problem.instance.truth, answer, kMost);
  const fs::path page = arguments.out.empty() ? fs::path(arguments.file).replace_extension(".html") : fs::path(arguments.out);
  atomic_write(page.string(), picture_page(drawing, fs::path(arguments.file).filename().string(), caption));
  terminal.out << page.string() << ": " << drawing.tracks.size() << " agents, " << drawing.rejected.size() << " outliers\n";
  write_json(arguments.json, {to_json(drawing)}, terminal);
  return kDone;
}

}  // namespace holdfast::program
