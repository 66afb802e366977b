#include <algorithm>
#include <filesystem>
#include <fstream>
#include <holdfast/adapters/files/range_start.hpp>
#include <holdfast/adapters/files/report.hpp>
#include <holdfast/common/instance.hpp>
#include <holdfast/graph/files/files.hpp>
#include <holdfast/graph/files/jrl.hpp>
#include <holdfast/graph/files/tum.hpp>
#include <sstream>
#ifdef HOLDFAST_WITH_MRPT
#include <holdfast/adapters/mrpt/rawlog.hpp>
#endif

namespace holdfast::common {
namespace {

namespace fs = std::filesystem;

Values true_poses(const Dataset& dataset) {
  Values truth;
  for (const Vertex& vertex : dataset.vertices) {
    if (const auto* pose = std::get_if<Pose2>(&vertex.value)) truth.insert(vertex.key, *pose);
    if (const auto* pose = std::get_if<Pose3>(&vertex.value)) truth.insert(vertex.key, *pose);
  }
  return truth;
}

/// MRPT's list of true beacons: id x y z and eight numbers more, a line a beacon.
Values true_beacons(const std::string& path) {
  constexpr Agent kBeacon('b');
  Values truth;
  std::ifstream file(path);
  file.imbue(std::locale::classic());
  for (std::string line; std::getline(file, line);) {
    std::istringstream columns(line);
    columns.imbue(std::locale::classic());
    std::uint64_t id;
    double number[11];
    int count = 0;
    columns >> id;
    while (count < 11 && columns >> number[count]) ++count;
    if (count == 11) truth.insert(kBeacon(id), Point2(number[0], number[1]));
  }
  return truth;
}

/// Its vertices may be a start, and its truth stand beside them.
bool is_jrl(const Dataset& dataset) {
  return std::any_of(dataset.edges.begin(), dataset.edges.end(),
                     [](const Edge& edge) { return std::string_view(edge.tag).find("Factor") != std::string_view::npos; });
}

bool is_rawlog(const std::string& path) { return fs::path(path).extension() == ".rawlog"; }

/// What is known of the answer: a PyFG file's own vertices, else the file of the same name that mrpt-common puts beside its data.
Values truth_of(const Dataset& dataset, const std::string& path) {
  if (is_jrl(dataset)) {
    std::ifstream file(path, std::ios::binary);
    const std::string text{std::istreambuf_iterator<char>(file), {}};
    Dataset truth;
    truth.vertices = parse_jrl_truth(text, path);
    return true_poses(truth);
  }
  if (dataset.format == Format::PyFG) return true_poses(dataset);
  const std::string stem = fs::path(path).replace_extension().string();
  if (is_rawlog(path)) return true_beacons(stem + "_ground_truth.txt");
  const std::string beside = stem + "_groundtruth" + fs::path(path).extension().string();
  return fs::is_regular_file(beside) ? true_poses(read_dataset(beside)) : Values();
}

}  // namespace

Dataset read_any(const std::string& path, const ReadOptions& reading) {
  if (!is_rawlog(path)) return read_dataset(path, reading);
#ifdef HOLDFAST_WITH_MRPT
  return located_by_ranges(read_rawlog(path));
#else
  fail<BadFile>(path, ": this build has no MRPT, which reads .rawlog files; configure with -DHOLDFAST_MRPT=ON");
#endif
}

FileProblem load(const std::string& path, const ProblemOptions& options, const ReadOptions& reading) {
  Dataset dataset = read_any(path, reading);
  try {
    Problem problem = make_problem(dataset, options);
    FileProblem result{{std::move(problem.graph), std::move(problem.start), truth_of(dataset, path)},
                       vertex_times(dataset),
                       unknown_report(dataset),
                       problem.relaxed ? problem.relaxed->str() : "",
                       use_report(dataset, options.odometry),
                       check(dataset)};
    result.dataset = std::move(dataset);
    return result;
  } catch (const Error& error) {  // these name the record, but the user gave several files
    fail<BadFile>(path, ": ", error.what());
  }
}

}  // namespace holdfast::common
