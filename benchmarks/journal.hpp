// A .jsonl file of results that outlives its program: every line is on the disk before the next run starts.
#pragma once

#include <holdfast/common/run.hpp>
#include <string>
#include <vector>

namespace holdfast::bench {

using namespace common;

class Journal {
 public:
  /// Reads what is there. A line that was torn when the program was killed is dropped from the file. BadFile where it cannot be read or
  /// written.
  explicit Journal(std::string path);

  const std::string& path() const { return path_; }
  const std::vector<Json>& lines() const { return lines_; }
  /// Adds a line, flushed to the disk; BadFile where it cannot, and then the file holds none of it.
  void append(const Json& line) { append(std::vector<Json>{line}); }
  /// The same with several at once.
  void append(const std::vector<Json>& lines);

 private:
  std::string path_;
  std::vector<Json> lines_;
};

}  // namespace holdfast::bench
