#include <CLI/CLI.hpp>
#include <filesystem>
#include <holdfast/common/log.hpp>
#include <holdfast/common/progress_bar.hpp>
#include <holdfast/common/report.hpp>
#include <holdfast/graph/files/atomic.hpp>
#include <holdfast/graph/files/tum.hpp>
#include <holdfast/program/program.hpp>
#include <holdfast/program/rejected.hpp>
#include <holdfast/solvers/certificate.hpp>
#include <holdfast/solvers/pairwise_consistency.hpp>
#include <holdfast/solvers/second_order.hpp>
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
  command->add_option("--json", arguments.json, "write one JSON object a run, one a line");
  command->add_flag("--gnc", arguments.gnc,
                    "graduated non-convexity around every back-end (gnc-irls, …); loss truncated_squares unless another is given");
  command
      ->add_option("--alpha", arguments.alpha,
                   "probability of a false alarm: the threshold of every redescending loss, by its number of components; 0.01 under --gnc "
                   "where no loss is given, else the loss's own threshold")
      ->check(CLI::Range(1e-12, 0.5));
  command->add_flag("--pcm", arguments.pcm,
                    "leave out loop closures that disagree with most others before solving (pairwise consistency, maximum clique); under a "
                    "redescending loss the graph is solved without the filter, too, and the lower cost over all loops is the answer");
  command->add_flag("--certify", arguments.certify,
                    "lower bound, gap and verdict for each answer: is it the global minimum? (squared pose graphs; loose for ranges)");
  command->add_flag("--second-order,!--no-second-order", arguments.second_order,
                    "look whether an answer is a minimum, leave it where it is a saddle, and solve again (on; where there are ranges, "
                    "bearings, landmarks or positions)");
  command->add_option(
      "--output", arguments.output,
      "write the file with the answer as its vertices (of several back-ends the one of the lowest cost); the name's ending says "
      "the format");
  add_reading(*command, arguments.reading);
  command->add_option("--tum", arguments.tum, "write the trajectories to DIR/<file>_<back-end>/<agent>.tum");
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
  const bool has_threshold = !plan.problem.loss.is_convex() && plan.problem.loss.kind != Loss::Kind::StudentT;
  if (plan.alpha && !has_threshold)
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
  plan.options.validate();
  const fs::path json = arguments.json;
  if (!json.empty() && fs::is_directory(json)) fail<BadOption>("--json ", arguments.json, " is a directory; name a file");
  if (!json.empty() && json.has_parent_path() && !fs::is_directory(json.parent_path()))
    fail<BadOption>("--json ", arguments.json, ": there is no directory ", json.parent_path().string(), "; make it first");
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
    write_json();
    return all_is_well_ ? kDone : kFailed;
  }

 private:
  void try_file(const std::string& file, const std::string& stem) {
    try {
      bar_.begin("reading " + file);
      FileProblem problem = load(file, plan_.problem, read_options(arguments_.reading));
      pcm_.clear();
      whole_.reset();
      if (plan_.alpha) set_thresholds(problem.instance.graph, *plan_.alpha);
      if (arguments_.pcm) leave_out_inconsistent(problem.instance.graph);
      solve_file(file, stem, problem);
    } catch (const std::exception& error) {  // a bad file does not stop the others
      bar_.clear();
      terminal_.err << "holdfast: " << error.what() << '\n';
      all_is_well_ = false;
    }
  }

  void solve_file(const std::string& file, const std::string& stem, const FileProblem& problem) {
    if (!problem.unknown.empty()) terminal_.err << "holdfast: warning: " << problem.unknown << '\n';
    for (const Finding& finding : problem.findings) terminal_.err << "holdfast: warning: " << finding.text << '\n';
    log(file + ": " + std::to_string(problem.instance.start.size()) + " variables, " + std::to_string(problem.instance.graph.size()) +
        " factors");
    std::vector<Json> runs;
    certificates_.clear();
    Values best;
    double least = std::numeric_limits<double>::infinity();
    rejected_.clear();
    saddles_.clear();
    for (const std::string& backend : plan_.backends) {
      bar_.begin(file + " " + backend);
      Task task{file, plan_.problem.loss.str(), arguments_.start, backend, arguments_.seed, plan_.options};
      task.options.progress = bar_.callback();
      Values answer;
      Run run = run_task(task, problem.instance, answer);
      const bool all_loops = pcm_harms(task, problem.instance, run, answer);
      const Graph& solved = all_loops ? *whole_ : problem.instance.graph;
      const SecondOrder end = leave_saddles(solved, problem.instance.truth, run, answer);
      log(file + " " + backend + ": " + run.summary.str());
      if (!run.summary.usable()) all_is_well_ = false;
      runs.push_back(to_json(run));
      note_second_order(end, runs.back());
      if (arguments_.pcm) runs.back()["pcm_rejected"] = all_loops ? 0 : rejected_loops_;
      if (run.summary.usable()) {
        const std::string rejected = rejected_list(solved, answer, runs.back());
        if (arguments_.gnc && !rejected.empty()) rejected_.push_back(rejected);
      }
      if (arguments_.certify && run.summary.usable()) certify_answer(solved, answer, runs.back());
      bar_.done_with_one();
      if (run.summary.usable() && run.summary.cost < least && !arguments_.output.empty()) {
        least = run.summary.cost;
        best = answer;
      }
      if (run.summary.usable() && !arguments_.tum.empty())
        write_tum_directory((fs::path(arguments_.tum) / (stem + "_" + backend)).string(), answer, problem.times);
    }
    bar_.clear();
    if (best.size() > 0)
      for (const std::string& note : write_converted(arguments_.output, with_values(problem.dataset, best), ""))
        terminal_.err << "holdfast: note: " << note << '\n';
    print(file, problem, runs);
    lines_.insert(lines_.end(), runs.begin(), runs.end());
  }

  /// Run and answer are those of the minimum that lies below where the back-end stopped at a saddle.
  SecondOrder leave_saddles(const Graph& graph, const Values& truth, Run& run, Values& answer) const {
    SecondOrder end;
    end.summary = run.summary;
    end.why = "--no-second-order";
    if (!arguments_.second_order) return end;
    end.why = run.summary.usable() ? "no factor that could hide a saddle" : "the solve failed";
    if (!run.summary.usable() || !may_hide_saddles(graph)) return end;
    std::string name = run.task.backend;  // GNC would begin with the start again
    if (const std::string gnc = "gnc-"; name.rfind(gnc, 0) == 0) name = name.substr(gnc.size());
    Options options = run.task.options;
    options.progress = nullptr;
    end = second_order_from(graph, answer, *make_backend(name, options), run.summary);
    if (end.saddles == 0) return end;
    if (!end.summary.usable()) {  // the answer is as it was
      end.summary = run.summary;
      return end;
    }
    run.summary = end.summary;
    run.seconds = {end.summary.seconds + end.seconds_check};
    run.error = position_error(truth, answer);
    run.ranges = count_ranges(graph, answer);
    return end;
  }
  void note_second_order(const SecondOrder& end, Json& run) {
    run["minimum"] = to_string(end.verdict);
    run["saddles_left"] = end.saddles;
    run["seconds_second_order"] = end.seconds_check;
    if (end.verdict == SecondOrder::Verdict::not_checked) run["not_checked"] = end.why;
    const std::string name = run["backend"].get<std::string>();
    if (end.verdict == SecondOrder::Verdict::left_saddle)
      saddles_.push_back(name + " left a saddle (" + std::to_string(end.saddles) + " in all): the answer is a second-order minimum");
    else if (end.curvature < 0 && end.verdict == SecondOrder::Verdict::not_checked)
      saddles_.push_back(name + ": the answer may be a saddle: " + end.why);
  }

  void leave_out_inconsistent(Graph& graph) {
    constexpr std::size_t kMostNames = 20;
    const ConsistentLoops found = consistent_loops(graph);
    pcm_ = "pcm: " + found.str();
    for (std::size_t i = 0; i < std::min(found.rejected.size(), kMostNames); ++i) {
      const Graph::Place& place = graph.place(found.rejected[i]);
      pcm_ += (i == 0 ? "\nrejected: " : ", ") + graph.batches()[place.batch]->describe(place.index);
    }
    if (found.rejected.size() > kMostNames) pcm_ += ", and " + std::to_string(found.rejected.size() - kMostNames) + " more";
    rejected_loops_ = found.rejected.size();
    if (rejected_loops_ > 0 && !plan_.problem.loss.is_convex()) whole_ = graph;
    for (const FactorId id : found.rejected) graph.remove(id);
  }

  /// Under a loss that outliers cannot pull along, the cost over all loops says which is better, the answer with pcm or the one without;
  /// run and answer are those of the better one.
  bool pcm_harms(const Task& task, const Instance& filtered, Run& run, Values& answer) {
    if (!whole_) return false;
    const Instance all{*whole_, filtered.start, filtered.truth};
    Values without;
    Run other = run_task(task, all, without);
    if (!other.summary.usable()) return false;
    const double with_pcm = run.summary.usable() ? whole_->cost(answer) : std::numeric_limits<double>::infinity();
    const bool harms = whole_->cost(without) < with_pcm;
    std::ostringstream text;
    text << "pcm, " << task.backend << ": over all loops the cost is " << with_pcm << " with it and " << whole_->cost(without)
         << " without it; the answer is the one " << (harms ? "without" : "with") << " it";
    pcm_ += "\n" + text.str();
    if (harms) {
      run = std::move(other);
      answer = std::move(without);
    }
    return harms;
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
    certificates_.push_back("certificate, " + run["backend"].get<std::string>() + polished + ": " + certificate.str());
  }

  void print(const std::string& file, const FileProblem& problem, const std::vector<Json>& runs) {
    const Instance& instance = problem.instance;
    terminal_.out << file << ": " << instance.start.size() << " variables, " << instance.graph.size() << " factors, loss "
                  << plan_.problem.loss.str();
    if (plan_.alpha) terminal_.out << " with thresholds of alpha " << *plan_.alpha;
    terminal_.out << ", start " << arguments_.start;
    if (arguments_.start == "odometry") terminal_.out << " (seed " << arguments_.seed << ")";
    terminal_.out << ", tolerance " << arguments_.tolerance << ", threads " << arguments_.threads << '\n';
    if (!pcm_.empty()) terminal_.out << pcm_ << '\n';
    terminal_.out << "read: " << problem.used << '\n';
    if (!problem.start.empty()) terminal_.out << "start: " << problem.start << '\n';
    print_solve(terminal_.out, runs);
    print_differences(terminal_.out, runs);
    for (const std::string& saddle : saddles_) terminal_.out << saddle << '\n';
    for (const std::string& rejected : rejected_) terminal_.out << rejected << '\n';
    for (const std::string& certificate : certificates_) terminal_.out << certificate << '\n';
    terminal_.out << std::endl;
  }

  /// Whole, or not there: without a run there is nothing to say, and what an earlier call left would be mistaken for this one's.
  void write_json() const {
    if (arguments_.json.empty()) return;
    std::string text;
    for (const Json& line : lines_) text += to_line(line);
    if (!text.empty())
      atomic_write(arguments_.json, text);
    else if (fs::is_regular_file(arguments_.json))
      fs::remove(arguments_.json);
  }

  const SolveArguments& arguments_;
  Plan plan_;
  Terminal& terminal_;
  ProgressBar bar_;
  std::vector<Json> lines_;
  std::vector<std::string> rejected_;
  std::vector<std::string> saddles_;       ///< of the file at hand
  std::vector<std::string> certificates_;  ///< of the file at hand
  std::string pcm_;                        ///< what was left out of it
  std::optional<Graph> whole_;             ///< with it, where a fall-back can be judged
  std::size_t rejected_loops_ = 0;
  bool all_is_well_ = true;
};

}  // namespace

int solve(const SolveArguments& arguments, Terminal& terminal) { return Solver(arguments, terminal).solve_all(); }

}  // namespace holdfast::program
