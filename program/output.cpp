#include <CLI/CLI.hpp>
#include <filesystem>
#include <holdfast/graph/error.hpp>
#include <holdfast/graph/files/atomic.hpp>
#include <holdfast/program/output.hpp>

namespace holdfast::program {

namespace fs = std::filesystem;
using namespace common;

void add_json(CLI::App& command, std::string& path, const std::string& what) {
  command.add_option("--json", path, "write " + what + " to this file; -: to the standard output, and no tables there")->type_name("FILE");
}

void check_json(const std::string& path) {
  const fs::path json = path;
  if (path.empty() || path == "-") return;
  if (fs::is_directory(json)) fail<BadOption>("--json ", path, " is a directory; name a file");
  if (json.has_parent_path() && !fs::is_directory(json.parent_path()))
    fail<BadOption>("--json ", path, ": there is no directory ", json.parent_path().string(), "; make it first");
}

void write_json(const std::string& path, const std::vector<Json>& lines, Terminal& terminal) {
  if (path.empty()) return;
  std::string text;
  for (const Json& line : lines) text += to_line(line);
  if (path == "-")
    terminal.data << text;
  else if (!text.empty())
    atomic_write(path, text);
  else if (fs::is_regular_file(path))
    fs::remove(path);
}

void add_examples(CLI::App& command, const std::vector<std::string>& lines) {
  std::string text = "Examples:";
  for (const std::string& line : lines) text += "\n  " + line;
  command.footer(text);
}

std::string help_end() {
  return "Exit codes:\n"
         "  0  done: for check, the problem can be solved; for track, every step had an answer\n"
         "  1  failed: a bad file, a problem without a usable answer, an output that cannot be written\n"
         "  2  a command line that makes no sense; nothing was run\n"
         "\n"
         "Examples:\n"
         "  holdfast simulate fleet fleet.pyfg --outliers 0.1\n"
         "  holdfast solve fleet.pyfg --start odometry --loss huber:2\n"
         "  holdfast solve --help\n"
         "  source <(holdfast completion bash)";
}

}  // namespace holdfast::program
