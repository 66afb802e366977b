// The program `holdfast` and its commands. main() only calls run(), so that tests run the same in their own process.
#pragma once

#include <CLI/App.hpp>
#include <holdfast/benchmarks/scenarios/simulation.hpp>
#include <holdfast/benchmarks/suites/suites.hpp>
#include <iosfwd>
#include <optional>
#include <string>
#include <vector>

namespace holdfast::program {

using namespace common;
using namespace bench;

/// What the program returns to the shell.
enum Exit : int {
  kDone = 0,
  kFailed = 1,  ///< a bad file, a problem without a usable answer, an output that cannot be written
  kUsage = 2    ///< a command line that makes no sense; nothing was run
};

/// Never throws, never aborts for bad input: whatever is wrong is a message on `err` and an exit code.
int run(int argc, const char* const* argv, std::ostream& out, std::ostream& err);

/// How a file is read.
struct ReadingArguments {
  std::string g2o_rotations = "half";
  std::string toro_order = "toro";
  std::string isam_noise = "root";
  std::string indefinite = "refuse";
  std::string odometry = "consecutive";
};
void add_reading(CLI::App& command, ReadingArguments& arguments);
ReadOptions read_options(const ReadingArguments& arguments);

struct SolveArguments {
  ReadingArguments reading;
  std::vector<std::string> files;
  std::string backends = "all";
  std::string loss = "squared";
  std::string start = "file";
  int threads = 1;
  int max_iterations = 0;
  double tolerance = 1e-6;
  double time_limit = 0;  ///< [s]; 0: none
  unsigned seed = 0;
  std::string json;
  std::string tum;
  std::string output;
  bool gnc = false;
  std::optional<double> alpha;
  bool pcm = false;
  bool certify = false;
  bool second_order = true;
  bool check = true;
  bool mirror = false;
};
CLI::App* add_solve(CLI::App& app, SolveArguments& arguments);
int solve(const SolveArguments& arguments, Terminal& terminal);

struct TrackArguments {
  std::string file;     ///< "-": standard input
  double lag = 20;      ///< [s]; 0: the whole history
  std::string backend;  ///< "": irls, or incremental for the whole history
  std::string loss = "truncated_squares:3";
  bool trust = true;
  std::string leaving = "marginalize";
  std::string format = "json";
  std::string states = "newest";
  double tolerance = 1e-6;
  int threads = 1;
  unsigned seed = 0;
  double landmark_sigma = 1;  ///< [m]
  std::string save;
  std::uint64_t save_every = 100;  ///< steps
  bool resume = false;
  bool strict = false;
  std::string json;
  bool quiet = false;  ///< no counts at the end
};
CLI::App* add_track(CLI::App& app, TrackArguments& arguments);
/// Reads `in` where the file is "-".
int track(const TrackArguments& arguments, std::istream& in, Terminal& terminal);

struct CheckArguments {
  ReadingArguments reading;
  std::string file;
  std::string json;
};
CLI::App* add_check(CLI::App& app, CheckArguments& arguments);
int check_file(const CheckArguments& arguments, Terminal& terminal);

struct ConvertArguments {
  std::string in, out;
  std::string to;
  ReadingArguments reading;
  std::string json;
};
CLI::App* add_convert(CLI::App& app, ConvertArguments& arguments);
int convert(const ConvertArguments& arguments, Terminal& terminal);
/// Writes a dataset in the format `to`, else that of the path's ending, else its own; returns what was changed or left out.
std::vector<std::string> write_converted(const std::string& path, const Dataset& dataset, const std::string& to);

struct SimulateArguments {
  SimulationOptions simulation;
  std::string out;
  std::string vertices = "auto";
  std::string json;
};
CLI::App* add_simulate(CLI::App& app, SimulateArguments& arguments);
int simulate_file(const SimulateArguments& arguments, Terminal& terminal);

struct NetworkArguments {
  std::int64_t agents = 10000;
  std::string backend = "petsc";
  std::string petsc;
  std::string start = "anchors";
  std::string state;
  double tolerance = 1e-6;
  double linear_tolerance = 1e-8;
  int max_iterations = 0;
  int threads = 1;
  unsigned seed = 1;
  std::string json;
};
CLI::App* add_network(CLI::App& app, NetworkArguments& arguments);
int network_of_processes(const NetworkArguments& arguments, Terminal& terminal);

struct BenchArguments {
  std::vector<std::string> suites;
  std::string out = "bench-out";
  std::string backends = "all";
  int threads = 1;
  double tolerance = 1e-10;
  double time_limit = 60;  ///< [s] a solve
  int repetitions = 3;
  unsigned seed = 1;
  unsigned runs = 0;  ///< 0: the suite's own number
  bool fresh = false;
  std::vector<std::string> graphs, kinds, methods;
  std::vector<double> shares;
  std::vector<int> sizes;
  std::string write_to;
  std::string json;
};
CLI::App* add_bench(CLI::App& app, BenchArguments& arguments);
int bench(const BenchArguments& arguments, Terminal& terminal);

struct CompareArguments {
  std::string a, b;
  bool strict = false;
  std::string json;
};
CLI::App* add_compare(CLI::App& app, CompareArguments& arguments);
int compare_results(const CompareArguments& arguments, Terminal& terminal);

struct PlotArguments {
  ReadingArguments reading;
  std::string file, out;
  std::string backend = "irls";
  std::string loss = "huber:2";
  std::string start = "file";
  unsigned seed = 0;
  std::string json;
};
CLI::App* add_plot(CLI::App& app, PlotArguments& arguments);
int plot(const PlotArguments& arguments, Terminal& terminal);

struct ReportArguments {
  std::string directory = "bench-out";
  std::string page;
  std::string script;  ///< where report.py lies; "": looked for
  std::string json;
};
CLI::App* add_report(CLI::App& app, ReportArguments& arguments);
/// Runs the report's Python script on a directory of bench.
int report(const ReportArguments& arguments, Terminal& terminal);

/// The back-ends of a comma-separated list, each once; "all": ceres, irls, nesterov (those there are), then any other but the variants
/// of Ceres, which are there to be named. Throws BadOption.
std::vector<std::string> backends_of(const std::string& list);

}  // namespace holdfast::program
