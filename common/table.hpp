// Text in columns.
#pragma once

#include <ostream>
#include <string>
#include <vector>

namespace holdfast::common {

/// A number as a cell, in printf's format; "-" where it is not finite.
std::string cell(const char* format, double number);

class Table {
 public:
  enum class Align { left, right };
  struct Column {
    std::string title;
    Align align;
  };

  explicit Table(std::vector<Column> columns) : columns_(std::move(columns)) {}
  /// As many cells as there are columns.
  void add(std::vector<std::string> cells) { rows_.push_back(std::move(cells)); }
  void print(std::ostream& out) const;

 private:
  std::vector<Column> columns_;
  std::vector<std::vector<std::string>> rows_;
};

}  // namespace holdfast::common
