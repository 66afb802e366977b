#include <CLI/CLI.hpp>
#include <csignal>
#include <cstdio>
#include <filesystem>
#include <holdfast/graph/check.hpp>
#include <holdfast/graph/files/internal/text.hpp>
#include <holdfast/graph/files/tum.hpp>
#include <holdfast/program/output.hpp>
#include <holdfast/program/program.hpp>
#include <holdfast/program/pyfg_lines.hpp>
#include <holdfast/program/tracker.hpp>
#include <iostream>
#include <nlohmann/json.hpp>

namespace holdfast::program {

CLI::App* add_track(CLI::App& app, TrackArguments& arguments) {
  CLI::App* command =
      app.add_subcommand("track", "follow the agents of a PyFG stream in a sliding window, line by line; SIGTERM ends it cleanly");
  command->add_option("FILE", arguments.file, "a PyFG file, taken in the order of time; or - for standard input")->required();
  command->add_option("--lag", arguments.lag, "seconds the window looks back; 0: the whole history")->capture_default_str();
  command->add_option("--backend", arguments.backend, "default: irls; of the whole history: incremental");
  command->add_option("--loss", arguments.loss, "of every measurement but the odometry: huber:2, cauchy:1, …")->capture_default_str();
  command->add_flag("!--no-trust", arguments.trust,
                    "believe every agent and landmark, also one most of whose latest measurements do not fit");
  command->add_option("--leaving", arguments.leaving, "what happens to states older than the lag")
      ->check(CLI::IsMember({"marginalize", "drop"}))
      ->capture_default_str();
  command->add_option("--format", arguments.format, "of the lines written; tum has no column for the agent")
      ->check(CLI::IsMember({"json", "tum"}))
      ->capture_default_str();
  command
      ->add_option("--states", arguments.states,
                   "newest: each agent's state as soon as it is known; leaving: its last estimate, a lag later")
      ->check(CLI::IsMember({"newest", "leaving"}))
      ->capture_default_str();
  command->add_option("--tolerance", arguments.tolerance, "relative decrease of the cost that ends a solve")->capture_default_str();
  command->add_option("--threads", arguments.threads)->capture_default_str();
  command->add_option("--seed", arguments.seed, "of the landmarks' start")->capture_default_str();
  command->add_option("--landmark-sigma", arguments.landmark_sigma, "of the landmarks' start round their vertices, and of their prior [m]")
      ->check(CLI::PositiveNumber)
      ->capture_default_str();
  command->add_option("--save", arguments.save, "write the window to this file every --save-every steps and at the end");
  command->add_option("--save-every", arguments.save_every, "steps")->check(CLI::PositiveNumber)->capture_default_str();
  command->add_flag("--resume", arguments.resume, "go on from the file of --save, if it is there, with the line after the last one taken");
  command->add_flag("--strict", arguments.strict, "a malformed line ends the program; else it is reported, counted and skipped");
  add_json(*command, arguments.json, "the counts of the end as one JSON object");
  add_examples(*command, {"holdfast track goats_14.pyfg --lag 10", "holdfast track goats_14.pyfg --lag 0 --states leaving",
                          "radio | holdfast track - --save window.bin --resume > states.jsonl"});
  return command;
}

namespace {

volatile std::sig_atomic_t terminated = 0;

/// SIGTERM and SIGINT set a flag, and let a blocked read return, as long as this lives.
class OnTermination {
 public:
  OnTermination() {
    terminated = 0;
    struct sigaction action {};
    action.sa_handler = [](int) { terminated = 1; };  // without SA_RESTART
    ::sigaction(SIGTERM, &action, &before_[0]);
    ::sigaction(SIGINT, &action, &before_[1]);
  }
  ~OnTermination() {
    ::sigaction(SIGTERM, &before_[0], nullptr);
    ::sigaction(SIGINT, &before_[1], nullptr);
  }
  OnTermination(const OnTermination&) = delete;
  OnTermination& operator=(const OnTermination&) = delete;

 private:
  struct sigaction before_[2];
};

TrackOptions options_of(const TrackArguments& arguments, std::ostream& err) {
  TrackOptions options;
  options.say = [&err](const std::string& text) { err << "holdfast: " << text << '\n'; };
  const bool is_whole = arguments.lag == 0;
  options.window.lag = is_whole ? std::numeric_limits<double>::infinity() : arguments.lag;
  options.window.backend = !arguments.backend.empty() ? arguments.backend : is_whole ? "incremental" : "irls";
  options.window.leaving = arguments.leaving == "drop" ? WindowOptions::Leaving::drop : WindowOptions::Leaving::marginalize;
  options.window.solver.cost_tolerance = arguments.tolerance;
  options.window.solver.threads = arguments.threads;
  options.loss = Loss::parse(arguments.loss);
  options.seed = arguments.seed;
  options.landmark_sigma = arguments.landmark_sigma;
  options.trust = arguments.trust;
  options.window.validate();
  check_json(arguments.json);
  if (arguments.resume && arguments.save.empty()) fail<BadOption>("--resume goes on from the file that --save names; give it, too");
  return options;
}

std::string json_of(const Tracked& state) {
  nlohmann::ordered_json json{{"t", state.time}, {"agent", state.key.agent().str()}, {"key", state.key.str()}};
  if (const Pose2* pose = std::get_if<Pose2>(&state.value)) {
    json["p"] = {pose->p[0], pose->p[1]};
    json["angle"] = pose->angle();
  } else if (const Pose3* pose3 = std::get_if<Pose3>(&state.value)) {
    json["p"] = {pose3->p[0], pose3->p[1], pose3->p[2]};
    json["q"] = {pose3->q.x(), pose3->q.y(), pose3->q.z(), pose3->q.w()};
  }
  return json.dump() + "\n";
}

class Track {
 public:
  Track(const TrackArguments& arguments, Terminal& terminal)
      : arguments_(arguments),
        terminal_(terminal),
        tracker_(options_of(arguments, terminal.err), [this](const Tracked& state) { print(state); }) {
    if (!arguments.resume || !std::filesystem::exists(arguments.save)) return;
    tracker_.restore(arguments.save);
    skip_ = tracker_.counts().lines;
    terminal_.err << "holdfast: resumed from " << arguments.save << " after line " << skip_ << " taken\n";
  }

  void file(const std::string& path) {
    const std::string text = io::read_file(path);
    for (const auto& [number, line] : in_time_order(text, path)) {
      if (terminated != 0) return;
      take(number, line, path);
    }
  }
  void stream(std::istream& in) {
    std::uint64_t number = 0;
    for (std::string line; terminated == 0 && std::getline(in, line);) take(++number, line, "stdin");
  }
  int end() {
    const std::vector<Finding> findings = what_is_open();
    if (terminated == 0) tracker_.finish();
    terminal_.data.flush();
    save();
    if (!arguments_.quiet) report();
    for (const Finding& finding : findings)
      terminal_.err << "holdfast: warning: " << to_string(finding.kind) << ": " << finding.text << '\n';
    write_json(arguments_.json, {counts()}, terminal_);
    if (!terminal_.data) fail<BadFile>("cannot write the states: the output is closed or full");
    return tracker_.counts().failed == 0 ? kDone : kFailed;
  }

 private:
  /// What the last window leaves open, as `check` says it.
  std::vector<Finding> what_is_open() const {
    const Window& window = tracker_.window();
    return window.graph().size() == 0 ? std::vector<Finding>() : merged(check(window.graph(), window.values()));
  }
  void take(std::uint64_t number, std::string_view line, const std::string& file) {
    if (skip_ > 0) {
      --skip_;
      return tracker_.vertices_of(number, line, file);
    }
    const std::uint64_t steps = tracker_.counts().steps;
    try {
      tracker_.line(number, line, file);
    } catch (const BadFile& error) {
      if (arguments_.strict) {
        save();
        throw;
      }
      terminal_.err << "holdfast: " << error.what() << " (skipped)\n";
    }
    if (tracker_.counts().steps != steps && tracker_.counts().steps % arguments_.save_every == 0) save();
  }
  void save() {
    if (!arguments_.save.empty()) tracker_.save(arguments_.save);
  }
  void print(const Tracked& state) {
    if (state.leaving != (arguments_.states == "leaving")) return;
    if (arguments_.json == "-") return;  // the counts alone
    terminal_.data << (arguments_.format == "tum" ? to_tum({{state.time, state.value}}) : json_of(state));
    terminal_.data.flush();  // whoever reads a stream wants it now
  }
  Json counts() const {
    const TrackCounts& counts = tracker_.counts();
    const auto known = [](bool is_known, double number) { return is_known ? Json(number) : Json(); };
    return {{"file", arguments_.file},
            {"lines", counts.lines},
            {"measurements", counts.measurements},
            {"steps", counts.steps},
            {"malformed", counts.malformed},
            {"late", counts.late},
            {"refused", counts.refused},
            {"withheld", counts.withheld},
            {"failed", counts.failed},
            {"rmse", known(counts.scored > 0, counts.rmse())},
            {"rmse_leaving", known(counts.scored_leaving > 0, counts.rmse_leaving())},
            {"ended_by_signal", terminated != 0}};
  }
  void report() {
    const TrackCounts& counts = tracker_.counts();
    terminal_.err << "holdfast: " << counts.lines << " lines, " << counts.measurements << " measurements, " << counts.steps << " steps";
    const auto say = [&](std::uint64_t count, const char* what) {
      if (count > 0) terminal_.err << ", " << count << ' ' << what;
    };
    say(counts.malformed, "malformed lines");
    say(counts.late, "measurements older than the lag");
    say(counts.refused, "measurements refused");
    say(counts.withheld, "measurements withheld");
    say(counts.failed, "steps without an answer");
    terminal_.err << (terminated != 0 ? "; ended by a signal\n" : "\n");
    if (counts.late + counts.refused > 0 && !tracker_.last_refusal().empty())
      terminal_.err << "holdfast: the last refused: " << tracker_.last_refusal() << '\n';
    if (counts.scored > 0) terminal_.err << "holdfast: RMSE to the vertices: newest " << counts.rmse() << " m";
    if (counts.scored_leaving > 0) terminal_.err << ", leaving " << counts.rmse_leaving() << " m";
    if (counts.scored > 0) terminal_.err << '\n';
  }

  const TrackArguments& arguments_;
  Terminal& terminal_;
  Tracker tracker_;
  std::uint64_t skip_ = 0;
};

}  // namespace

int track(const TrackArguments& arguments, std::istream& in, Terminal& terminal) {
  const OnTermination on_termination;
  Track track(arguments, terminal);
  if (arguments.file == "-")
    track.stream(in);
  else
    track.file(arguments.file);
  return track.end();
}

}  // namespace holdfast::program
