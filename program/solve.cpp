#include <CLI/CLI.hpp>
#include <filesystem>
#include <holdfast/common/log.hpp>
#include <holdfast/common/progress_bar.hpp>
#include <holdfast/common/report.hpp>
#include <holdfast/graph/files/tum.hpp>
#include <holdfast/program/loop_filter.hpp>
#include <holdfast/program/output.hpp>
#include <holdfast/program/program.hpp>
#include <holdfast/program/rejected.hpp>
#include <holdfast/program/second_look.hpp>
#include <holdfast/solvers/certificate.hpp>
#include <holdfast/solvers/detail/clock.hpp>
#include <holdfast/solvers/table.hpp>
#include <limits>
#include <optional>
#include <set>
#include <sstream>

namespace holdfast::program {

namespace fs = std::filesystem;

CLI::App* add_solve(CLI::App& app, SolveArguments& arguments) {
  CLI::App* command = app.add_subcommand("solve", "solve the problems of files under several back-ends, side by side");
  command->add_option("FILE", arguments.files, "PyFG, g2o or TORO files, MRPT's .graph and .rawlog")->required();
  command->add_option("--backend", arguments.backends, "comma-separated names, or all")->capture_default_str();
  command->add_option("--loss", arguments.loss, "of every measurement but the odometry between consecutive poses: huber:2, cauchy:1, …")
      ->capture_default_str();
  command
      ->add_option("--start", arguments.start,
                   "file: its vertices; odometry: dead reckoning; chordal: rotations first, as a linear problem; convex: positions from "
                   "nothing, by the convex relaxation of the ranges, rotations as chordal")
      ->check(CLI::IsMember({"file", "odometry", "chordal", "convex"}))
      ->capture_default_str();
  command->add_option("--threads", arguments.threads)->capture_default_str();
  command->add_option("--max-iterations", arguments.max_iterations, "0: the back-end's own limit")->capture_default_str();
  command->add_option("--tolerance", arguments.tolerance, "relative decrease of the cost that ends a solve")->capture_default_str();
  command->add_option("--time-limit", arguments.time_limit, "seconds a solve; 0: none")->capture_default_str();
  command->add_option("--seed", arguments.seed, "of the landmarks' start under --start odometry")->capture_default_str();
  add_json(*command, arguments.json, "one JSON object a run, one a line,");
  command->add_flag("--gnc", arguments.gnc,
                    "graduated non-convexity around every back-end (gnc-irls, …); loss truncated_squares unless another is given");
  command
      ->add_option("--alpha", arguments.alpha,
                   "probability of a false alarm: the threshold of every redescending loss, by its number of components; 0.01 under --gnc "
                   "where no loss is given, else the loss's own threshold")
      ->check(CLI::Range(1e-12, 0.5));
  command->add_flag(
      "--pcm", arguments.pcm,
      "leave out loop closures that disagree with most others before solving (pairwise consistency, maximum clique), and ranges that "
      "do (by geometry); under a redescending loss the graph is solved without the filter, too, and the lower cost over all "
      "measurements is the answer");
  command->add_flag("--certify", arguments.certify,
                    "lower bound, gap and verdict for each answer: is it the global minimum? (squared pose graphs; loose for ranges)");
  command->add_flag("--second-order,!--no-second-order", arguments.second_order,
                    "look whether an answer is a minimum, leave it where it is a saddle, and solve again (on; where there are ranges, "
                    "bearings, landmarks or positions)");
  command->add_flag("--check,!--no-check", arguments.check,
                    "say what the problem leaves open at the best answer, as holdfast check does (on)");
  command->add_flag("--mirror", arguments.mirror,
                    "where the mirror image of points fits as well (anchors in one plane or on one line), solve there, too; with --output "
                    "FILE.g2o into FILE-mirror-1.g2o, …");
  command->add_option(
      "--output", arguments.output,
      "write the file with the answer as its vertices (of several back-ends the one of the lowest cost); the name's ending says "
      "the format");
  add_reading(*command, arguments.reading);
  command->add_option("--tum", arguments.tum, "write the trajectories to DIR/<file>_<back-end>/<agent>.tum");
  add_examples(*command,
               {"holdfast solve plaza2.pyfg --start odometry --loss huber:2", "holdfast solve intel.g2o --gnc --output answer.g2o",
                "holdfast solve *.g2o --backend irls --quiet --json - | jq .cost"});
  return command;
}

namespace {

/// What the arguments mean; made before any work, so that a typing error costs nothing.
struct Plan {
  ProblemOptions problem;
  std::vector<std::string> backends;
  Options options;
  std::optional<double> alpha;
};

Plan plan_of(const SolveArguments& arguments) {
  Plan plan;
  plan.problem.loss = Loss::parse(arguments.loss);
  plan.alpha = arguments.alpha;
  if (arguments.gnc && plan.problem.loss == Loss{}) {
    constexpr double kAlpha = 0.01;
    plan.problem.loss = TruncatedSquares{1};
    if (!plan.alpha) plan.alpha = kAlpha;
  }
  if (plan.alpha && !has_threshold(plan.problem.loss))
    fail<BadOption>("--alpha: the loss ", plan.problem.loss.str(),
                    " has no threshold for outliers; give --gnc, or a loss such as truncated_squares:3");
  plan.problem.start = start_named(arguments.start);
  plan.problem.seed = arguments.seed;
  plan.problem.odometry = odometry_rule(arguments.reading.odometry);
  if (!arguments.output.empty() && arguments.files.size() > 1) fail<BadOption>("--output names one file; give one FILE to solve");
  plan.backends = backends_of(arguments.backends);
  if (arguments.gnc)
    for (std::string& backend : plan.backends) backend = "gnc-" + backend;
  plan.options.threads = arguments.threads;
  plan.options.max_iterations = arguments.max_iterations;
  plan.options.cost_tolerance = arguments.tolerance;
  if (arguments.time_limit != 0) plan.options.time_limit = arguments.time_limit;
  plan.options.second_order = arguments.second_order;
  plan.options.validate();
  check_json(arguments.json);
  return plan;
}

/// A name of its own for each file, also where two of different directories are called the same.
std::vector<std::string> stems_of(const std::vector<std::string>& files) {
  std::set<std::string> taken;
  std::vector<std::string> stems;
  for (const std::string& file : files) {
    const std::string stem = fs::path(file).stem().string();
    std::string name = stem;
    for (int i = 2; !taken.insert(name).second; ++i) name = stem + "-" + std::to_string(i);
    stems.push_back(name);
  }
  return stems;
}

class Solver {
 public:
  Solver(const SolveArguments& arguments, Terminal& terminal)
      : arguments_(arguments),
        plan_(plan_of(arguments)),
        terminal_(terminal),
        bar_(terminal, arguments.files.size() * plan_.backends.size()) {}

  int solve_all() {
    const std::vector<std::string> stems = stems_of(arguments_.files);
    for (std::size_t i = 0; i < stems.size(); ++i) try_file(arguments_.files[i], stems[i]);
    bar_.clear();
    write_json(arguments_.json, lines_, terminal_);
    return all_is_well_ ? kDone : kFailed;
  }

 private:
  void try_file(const std::string& file, const std::string& stem) {
    try {
      bar_.begin("reading " + file);
      FileProblem problem = load(file, plan_.problem, read_options(arguments_.reading));
      filter_ = LoopFilter();
      if (plan_.alpha) set_thresholds(problem.instance.graph, *plan_.alpha);
      if (arguments_.pcm) filter_.leave_out(problem.instance.graph, !plan_.problem.loss.is_convex());
      solve_file(file, stem, problem);
    } catch (const std::exception& error) {  // a bad file does not stop the others
      bar_.clear();
      terminal_.err << "holdfast: " << error.what() << '\n';
      all_is_well_ = false;
    }
  }

  void solve_file(const std::string& file, const std::string& stem, const FileProblem& problem) {
    if (!problem.unknown.empty()) terminal_.err << "holdfast: warning: " << problem.unknown << '\n';
    for (const Finding& finding : merged(problem.findings)) terminal_.err << "holdfast: warning: " << finding.text << '\n';
    log(file + ": " + std::to_string(problem.instance.start.size()) + " variables, " + std::to_string(problem.instance.graph.size()) +
        " factors");
    if (arguments_.check)
      if (const Finding stuck = zero_distance(problem.instance.graph, problem.instance.start); !stuck.keys.empty())
        terminal_.err << "holdfast: warning: at the start: " << stuck.text << '\n';
    std::vector<Json> runs;
    std::vector<Values> answers;
    remarks_.clear();
    std::optional<std::size_t> best;
    const Graph* best_graph = nullptr;
    for (const std::string& backend : plan_.backends) {
      bar_.begin(file + " " + backend);
      Task task{file, plan_.problem.loss.str(), arguments_.start, backend, arguments_.seed, plan_.options};
      task.options.progress = bar_.callback();
      Values answer;
      Run run = run_task(task, problem.instance, answer);
      const Graph* const whole = filter_.whole_if_better(task, problem.instance, run, answer);
      const Graph& solved = whole != nullptr ? *whole : problem.instance.graph;
      log(file + " " + backend + ": " + run.summary.str());
      if (!run.summary.usable()) all_is_well_ = false;
      runs.push_back(to_json(run));
      remark(note_second_order(run.summary, runs.back()));
      if (arguments_.pcm) runs.back()["pcm_rejected"] = whole != nullptr ? 0 : filter_.rejected();
      if (run.summary.usable()) {
        const std::string rejected = rejected_list(solved, answer, runs.back());
        if (arguments_.gnc) remark(rejected);
      }
      if (arguments_.certify && run.summary.usable()) certify_answer(solved, answer, runs.back());
      bar_.done_with_one();
      if (run.summary.usable() && (!best || run.summary.cost < runs[*best]["cost"].get<double>())) {
        best = runs.size() - 1;
        best_graph = &solved;
      }
      if (run.summary.usable() && !arguments_.tum.empty())
        write_tum_directory((fs::path(arguments_.tum) / (stem + "_" + backend)).string(), answer, problem.times);
      answers.push_back(std::move(answer));
    }
    bar_.clear();
    if (!filter_.has_whole()) tell_ends_apart(problem.instance.graph, answers, runs);
    if (best) look_at_best(problem, *best_graph, answers[*best], runs[*best]);
    print(file, problem, runs);
    lines_.insert(lines_.end(), runs.begin(), runs.end());
  }

  /// What is said once of a file: at the answer of the lowest cost.
  void look_at_best(const FileProblem& problem, const Graph& graph, const Values& answer, Json& run) {
    write_output(arguments_.output, problem, answer);
    if (arguments_.check) {
      const Stopwatch watch;
      run["findings"] = Json::array();
      for (const Finding& finding : merged(check(graph, answer))) {
        const bool is_told = finding.kind == Finding::Kind::mirror_image && arguments_.mirror;
        if (!is_told) terminal_.err << "holdfast: warning: " << to_string(finding.kind) << ": " << finding.text << '\n';
        run["findings"].push_back({{"kind", to_string(finding.kind)}, {"text", finding.text}});
      }
      run["seconds_check"] = watch.seconds();
    }
    if (!arguments_.mirror) return;
    const Task task{"", "", "", run["backend"].get<std::string>(), arguments_.seed, plan_.options};
    const std::vector<MirrorAnswer> mirrors = mirror_answers(task, graph, answer, run["cost"].get<double>());
    if (mirrors.empty()) remark("mirror image: none fits as well");
    for (std::size_t i = 0; i < mirrors.size(); ++i) {
      remark(mirrors[i].text);
      if (arguments_.output.empty()) continue;
      fs::path path = arguments_.output;
      path.replace_filename(path.stem().string() + "-mirror-" + std::to_string(i + 1) + path.extension().string());
      write_output(path.string(), problem, mirrors[i].answer);
    }
  }
  void write_output(const std::string& path, const FileProblem& problem, const Values& answer) {
    if (path.empty()) return;
    for (const std::string& note : write_converted(path, with_values(problem.dataset, answer), ""))
      terminal_.err << "holdfast: note: " << note << '\n';
  }
  void remark(const std::string& text) {
    if (!text.empty()) remarks_.push_back(text);
  }

  void certify_answer(const Graph& graph, const Values& answer, Json& run) {
    Certificate certificate = certify(graph, answer);
    std::string polished;
    if (certificate.positive_definite && certificate.left_out == 0 && !certificate.is_global()) {  // the solve stopped short of it
      Options to_the_bottom = plan_.options;
      to_the_bottom.cost_tolerance = 1e-14;
      Values values = answer;
      make_backend("irls", to_the_bottom)->solve(graph, values);
      certificate = certify(graph, values);
      polished = " (polished by irls, the answer is as it was)";
    }
    run["certificate"] = to_string(certificate.verdict);
    run["bound"] = certificate.bound;
    run["gap"] = certificate.gap();
    run["seconds_certificate"] = certificate.seconds;
    remark("certificate, " + run["backend"].get<std::string>() + polished + ": " + certificate.str());
  }

  void print(const std::string& file, const FileProblem& problem, const std::vector<Json>& runs) {
    const Instance& instance = problem.instance;
    terminal_.out << file << ": " << instance.start.size() << " variables, " << instance.graph.size() << " factors, loss "
                  << plan_.problem.loss.str();
    if (plan_.alpha) terminal_.out << " with thresholds of alpha " << *plan_.alpha;
    terminal_.out << ", start " << arguments_.start;
    if (arguments_.start == "odometry") terminal_.out << " (seed " << arguments_.seed << ")";
    terminal_.out << ", tolerance " << arguments_.tolerance << ", threads " << arguments_.threads << '\n';
    if (!filter_.text().empty()) terminal_.out << filter_.text() << '\n';
    terminal_.out << "read: " << problem.used << '\n';
    if (!problem.start.empty()) terminal_.out << "start: " << problem.start << '\n';
    print_solve(terminal_.out, runs);
    print_differences(terminal_.out, runs);
    for (const std::string& remark : remarks_) terminal_.out << remark << '\n';
    terminal_.out << std::endl;
  }

  /// Whole, or not there: without a run there is nothing to say, and what an earlier call left would be mistaken for this one's.

  const SolveArguments& arguments_;
  Plan plan_;
  Terminal& terminal_;
  ProgressBar bar_;
  std::vector<Json> lines_;
  std::vector<std::string> remarks_;  ///< on the file at hand
  LoopFilter filter_;                 ///< of the file at hand
  bool all_is_well_ = true;
};

}  // namespace

int solve(const SolveArguments& arguments, Terminal& terminal) { return Solver(arguments, terminal).solve_all(); }

}  // namespace holdfast::program
