#include <holdfast/benchmarks/instance.hpp>
#include <holdfast/graph/io_files.hpp>
#include <holdfast/graph/io_tum.hpp>

namespace holdfast::bench {
namespace {

Values true_poses(const Dataset& dataset) {
  Values truth;
  if (dataset.format != Format::PyFG) return truth;  // elsewhere vertices are somebody's guess
  for (const Vertex& vertex : dataset.vertices) {
    if (const auto* pose = std::get_if<Pose2>(&vertex.value)) truth.insert(vertex.key, *pose);
    if (const auto* pose = std::get_if<Pose3>(&vertex.value)) truth.insert(vertex.key, *pose);
  }
  return truth;
}

}  // namespace

FileProblem load(const std::string& path, const ProblemOptions& options) {
  const Dataset dataset = read(path);
  try {
    Problem problem = make_problem(dataset, options);
    return {{std::move(problem.graph), std::move(problem.start), true_poses(dataset)}, vertex_times(dataset), unknown_report(dataset)};
  } catch (const Error& error) {  // these name the record, but the user gave several files
    fail<BadFile>(path, ": ", error.what());
  }
}

}  // namespace holdfast::bench
