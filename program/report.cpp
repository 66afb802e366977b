// `holdfast report`: the page of what bench measured, drawn by benchmarks/report/report.py.
#include <sys/wait.h>
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <filesystem>
#include <holdfast/program/output.hpp>
#include <holdfast/program/program.hpp>

namespace holdfast::program {

namespace fs = std::filesystem;

CLI::App* add_report(CLI::App& app, ReportArguments& arguments) {
  CLI::App* command = app.add_subcommand("report", "draw one self-contained page of what bench measured (needs Python with plotly)");
  command->add_option("DIR", arguments.directory, "the results of bench")->capture_default_str();
  command->add_option("PAGE", arguments.page, "the page; DIR/index.html where it is not given");
  command->add_option("--script", arguments.script, "report.py, where it is not in the source tree this program was built from");
  add_json(*command, arguments.json, "one JSON object");
  add_examples(*command, {"holdfast report bench-out", "holdfast report bench-out page.html"});
  return command;
}

namespace {

/// The virtual environment that scripts/report makes has plotly; else whatever Python there is.
std::string python_beside(const fs::path& script) {
  const fs::path own = script.parent_path() / "../../build/venv/bin/python";
  return fs::exists(own) ? own.lexically_normal().string() : "python3";
}

/// Waits for a program whose output goes where that of this one goes; its exit code, 127 where there is no such program.
int run_program(const std::vector<std::string>& words, bool is_silent) {
  std::vector<char*> argv;
  for (const std::string& word : words) argv.push_back(const_cast<char*>(word.c_str()));
  argv.push_back(nullptr);
  const pid_t child = ::fork();
  if (child < 0) fail<BadOption>("cannot start ", words[0], ": the system has no process left");
  if (child == 0) {
    constexpr int kNotFound = 127;
    if (is_silent) ::close(STDOUT_FILENO);
    ::execvp(argv[0], argv.data());
    ::_exit(kNotFound);
  }
  int status = 0;
  ::waitpid(child, &status, 0);
  return WIFEXITED(status) ? WEXITSTATUS(status) : kFailed;
}

}  // namespace

int report(const ReportArguments& arguments, Terminal& terminal) {
  check_json(arguments.json);
  const fs::path script =
      arguments.script.empty() ? fs::path(HOLDFAST_SOURCE_DIR) / "benchmarks/report/report.py" : fs::path(arguments.script);
  if (!fs::exists(script)) fail<BadFile>("there is no ", script.string(), "; name benchmarks/report/report.py with --script");
  const std::string page = arguments.page.empty() ? (fs::path(arguments.directory) / "index.html").string() : arguments.page;
  const std::string python = python_beside(script);
  terminal.out.flush();
  const int code = run_program({python, script.string(), arguments.directory, page}, !terminal.out);
  if (code == 127) fail<BadFile>("there is no ", python, "; install Python 3, or run scripts/report");
  if (code == 0) write_json(arguments.json, {{{"page", page}, {"bytes", fs::file_size(page)}}}, terminal);
  return code == 0 ? kDone : kFailed;
}

}  // namespace holdfast::program
