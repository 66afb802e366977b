// Every line of a file is read, kept or named: nothing is lost in silence.
#pragma once

#include <holdfast/graph/files/dataset.hpp>
#include <holdfast/graph/files/internal/text.hpp>
#include <set>
#include <string_view>

namespace holdfast::testing_io {

/// The lines that are in the dataset as a record, a comment, or a line that is kept.
inline std::set<std::size_t> lines_of(const Dataset& dataset) {
  std::set<std::size_t> lines;
  for (const Vertex& one : dataset.vertices) lines.insert(one.line);
  for (const Edge& one : dataset.edges) lines.insert(one.line);
  for (const Fixed& one : dataset.fixed) lines.insert(one.line);
  for (const SensorOffset& one : dataset.offsets) lines.insert(one.line);
  for (const UnknownLine& one : dataset.unknown) lines.insert(one.line);
  for (const KeptLine& one : dataset.comments) lines.insert(one.line);
  return lines;
}

/// 1 … the number of lines of the text, each of which must be in the dataset; "" or which is missing.
inline std::string missing_line(const Dataset& dataset, std::string_view text) {
  const std::set<std::size_t> lines = lines_of(dataset);
  std::string missing;
  std::size_t count = 0;
  io::for_each_line(text, [&](std::size_t number, std::string_view line) {
    count = number;
    if (missing.empty() && lines.count(number) == 0) missing = "line " + std::to_string(number) + " is lost: " + std::string(line);
  });
  if (missing.empty() && lines.size() != count) missing = "there are lines that the file has not";
  return missing;
}

}  // namespace holdfast::testing_io
