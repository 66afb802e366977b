// Any bytes as a file. Either BadFile, or a dataset that its own format gives back bit by bit, and a problem that the check, the starts
// and a solver take or refuse by a typed error. The first byte chooses whether to solve, the start and the loss.
#include <holdfast/adapters/files/problem.hpp>
#include <holdfast/graph/check.hpp>
#include <holdfast/graph/files/files.hpp>
#include <holdfast/graph/files/tum.hpp>
#include <holdfast/solvers/table.hpp>
#include <sstream>

#include "bytes.hpp"
#include "tests/graph/files/every_line.hpp"

namespace holdfast {
namespace {

constexpr std::size_t kLargest = 48;  // edges of a problem that is solved

void write_and_read_again(const Dataset& dataset) {
  const std::string text = to_text(dataset, dataset.format);
  std::istringstream in(text);
  const Dataset again = parse_dataset(in, "again", dataset.format, dataset.reading);
  fuzz::require(to_text(again, again.format) == text, "a file written, read and written again has changed:\n", text);
  fuzz::require(again.vertices.size() == dataset.vertices.size() && again.edges.size() == dataset.edges.size() &&
                    again.fixed.size() == dataset.fixed.size() && again.unknown.size() == dataset.unknown.size(),
                "records are lost:\n", text);
}

/// A format that cannot hold a record says so; what it writes it can read, but for noise that its conversion ruins by rounding.
void convert(Dataset dataset) {
  for (Vertex& vertex : dataset.vertices) vertex.time.reset();
  for (Edge& edge : dataset.edges) edge.time.reset();
  dataset.unknown.clear();
  for (Format format : {Format::PyFG, Format::G2o, Format::Toro}) {
    try {
      std::istringstream in(to_text(dataset, format));
      parse_dataset(in, "converted", format);
    } catch (const BadFile&) {
    }
  }
}

void solve_it(const Dataset& dataset, ProblemOptions::Start start, const Loss& loss) {
  ProblemOptions how;
  how.start = start;
  how.loss = loss;
  const Problem problem = make_problem(dataset, how);
  check(problem.graph, problem.start);
  Options options;
  options.max_iterations = 4;
  Values answer = problem.start;
  const Summary summary = make_backend("irls", options)->solve(problem.graph, answer);
  if (summary.usable()) fuzz::require(summary.cost <= summary.cost_first, "a solve ends above its start", summary.str());
  with_values(dataset, answer);
}

}  // namespace
}  // namespace holdfast

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace holdfast;
  fuzz::Bytes bytes(data, size);
  const int choice = bytes.byte();
  try {
    std::istringstream in{std::string(bytes.rest())};
    ReadOptions reading;
    reading.repair = choice % 2 == 1;
    const Dataset dataset = parse_dataset(in, "fuzz", reading);
    const bool is_json =
        std::string_view(bytes.rest()).find('{') == std::string_view(bytes.rest()).find_first_not_of("\xEF\xBB\xBF \t\r\n");
    fuzz::require(is_json || testing_io::missing_line(dataset, bytes.rest()).empty(), "a line is lost in silence:\n",
                  std::string(bytes.rest()));
    write_and_read_again(dataset);
    convert(dataset);
    unknown_report(dataset);
    vertex_times(dataset);
    if (choice % 4 != 0 || dataset.edges.size() > kLargest || dataset.vertices.size() > kLargest)
      return 0;  // a solve costs as much as many files
    static const Loss losses[]{Squared{}, Huber{2}, Cauchy{1}, per_component(Tukey{4})};
    solve_it(dataset, static_cast<ProblemOptions::Start>(choice / 4 % 3), losses[choice / 12 % 4]);
  } catch (const Error&) {  // typed, and nothing else
  }
  return 0;
}
