// Line by line from text to Dataset: for files, and for streams that never end (`holdfast track` reads PyFG from its standard input).
#pragma once

#include <holdfast/graph/files/dataset.hpp>
#include <holdfast/graph/files/internal/text.hpp>
#include <unordered_map>

namespace holdfast {

namespace io {
struct RecordType;
}

/// Parses the lines of one file of a known format. A line that throws BadFile leaves the dataset as it was: a stream may go on.
///   LineParser parser(Format::PyFG, "stdin");
///   while (std::getline(std::cin, line)) { parser.parse(line); … parser.dataset() … }
class LineParser {
 public:
  LineParser(Format format, std::string name, const ReadOptions& options = {});

  /// g2o: ids of landmarks are numbered apart from those of poses: 0 is x0 as a pose and l0 as a landmark. Before the first line.
  void set_landmarks_apart();

  /// Appends what the next line holds: one record, a comment or blank line, or an unknown line. Throws BadFile where the line
  ///  - has too few or too many columns, something that is no finite number, a quaternion not of norm 1 (within 1e-3; normalised),
  ///    a covariance or variance that is not positive definite, an information that is not positive semidefinite (unless
  ///    ReadOptions::repair), a negative distance, an id that is no integer >= 0;
  ///  - is of another dialect (a tag of TORO in a g2o file, names of PyFG in a g2o file, …);
  ///  - names a variable by another id than an earlier line did (g2o, TORO: 5 and gtsam::Symbol('x', 5) are one key);
  ///  - defines a vertex again, goes from a key to itself, or uses a key as another type than an earlier line did (pose or point, 2D or
  ///  3D);
  ///  - names a sensor offset that is not defined above it, or one of the other dimension (g2o).
  void parse(std::string_view text);
  /// The same with a line number of the caller's.
  void parse(std::size_t number, std::string_view text);

  const Dataset& dataset() const { return dataset_; }

  /// The dataset, at the end of the file; the parser is then empty. Throws BadFile in PyFG where an edge names a key that has no
  /// vertex, with the first such line. In g2o and TORO vertices may be missing (the start is then made from the edges).
  Dataset finish();

 private:
  struct Use {
    std::size_t type;  ///< alternative of VertexValue
    std::size_t line;
    bool is_vertex;
  };
  struct Spelling {
    bool is_symbol;
    std::size_t line;
  };
  struct Orphan {
    std::size_t line;
    std::string text;
  };

  void add(Vertex vertex);
  void add(std::vector<Edge> edges, const io::RecordType& type);
  void add(const std::vector<Fixed>& fixed);
  void add(SensorOffset offset);
  void check_ids();
  void check_foreign() const;
  const SensorOffset& offset(std::uint64_t id, const io::RecordType& type) const;
  void check_type(Key key, std::size_t type) const;
  void use(Key key, std::optional<std::size_t> type);

  Dataset dataset_;
  io::Line line_;
  std::unordered_map<Key, Use> uses_;
  std::unordered_map<Key, Spelling> spellings_;  ///< how the file writes the keys x…
  std::unordered_map<Key, Orphan> orphans_;      ///< PyFG: keys used before their vertex came; in the usual order of a file there are none
};

}  // namespace holdfast
