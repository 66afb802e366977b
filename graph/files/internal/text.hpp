// Text in and out, the same in every locale: files as a whole, lines as columns, numbers as the shortest text that reads back bit by bit.
#pragma once

#include <cstdint>
#include <holdfast/graph/error.hpp>
#include <holdfast/graph/files/dataset.hpp>
#include <holdfast/graph/key.hpp>
#include <string>
#include <string_view>
#include <vector>

namespace holdfast::io {

/// The whole file. BadFile, with the system's reason, where it is missing, a directory, unreadable or of 0 bytes.
std::string read_file(const std::string& path);

/// Calls visit(number, line) for each line, without its LF or CRLF, numbers from 1. A byte order mark at the start is skipped.
template <class Visit>
void for_each_line(std::string_view text, Visit&& visit) {
  if (text.substr(0, 3) == "\xEF\xBB\xBF") text.remove_prefix(3);
  for (std::size_t number = 1; !text.empty(); ++number) {
    const std::size_t end = text.find('\n');
    visit(number, text.substr(0, end));
    text.remove_prefix(end == std::string_view::npos ? text.size() : end + 1);
  }
}

/// At most 120 characters, on one line, none of them a control character: a line of a file as a message may show it.
std::string excerpt(std::string_view text);

/// Shortest text that reads back to the same bits.
std::string to_text(double value);

/// One line of a file as columns that are read one after the other; every failure is a BadFile that shows file, number and text.
class Line {
 public:
  explicit Line(std::string file) : file_(std::move(file)) {}

  /// Takes the next line; `text` must live as long as it is read.
  void assign(std::size_t number, std::string_view text);

  bool is_blank() const { return columns_.empty() || columns_[0][0] == '#'; }
  std::string_view tag() const { return columns_[0]; }
  std::string_view column(std::size_t i) const { return i < columns_.size() ? columns_[i] : std::string_view{}; }
  std::size_t size() const { return columns_.size(); }  ///< columns, the tag among them
  std::string_view text() const { return text_; }
  std::size_t number() const { return number_; }
  const std::string& file() const { return file_; }

  bool at_end() const { return cursor_ == columns_.size(); }
  double next_number(const char* what);        ///< finite
  Key next_name();                             ///< A11, or r1234:7
  Key next_id();                               ///< Key::from_id: 11 → x11
  Key next_landmark_id();                      ///< the same; 11 → l11 where landmarks are numbered apart
  std::uint64_t next_index(const char* what);  ///< an integer >= 0 below 2^64

  /// What next_id() made keys x… of on this line: a plain number, or (is_symbol) the 64 bits of the key.
  struct XId {
    Key key;
    bool is_symbol;
  };
  const std::vector<XId>& x_ids() const { return x_ids_; }

  /// How the file is read, and what its reading has found out about this line.
  struct Reading {
    ReadOptions options;
    bool landmarks_apart = false;
    std::vector<std::uint64_t> offsets;  ///< the sensor offsets that the line names
    std::optional<Repair> repair;
    bool no_noise = false;
  };
  Reading reading;

  template <class... Parts>
  [[noreturn]] void error(const Parts&... parts) const {
    fail<BadFile>(file_, ", line ", std::to_string(number_), ": '", excerpt(text_), "': ", parts...);
  }

 private:
  std::string file_;
  std::size_t number_ = 0;
  std::string_view text_;
  std::vector<std::string_view> columns_;
  std::vector<XId> x_ids_;
  std::size_t cursor_ = 1;
};

/// Is it a letter and digits (or such an agent, a colon and digits), as PyFG names variables? Digits, perhaps signed, as g2o and TORO do?
bool is_name(std::string_view text);
bool is_integer(std::string_view text);

/// Lines being written.
class Text {
 public:
  Text() = default;
  /// Ids as this dataset has them (symbols, landmarks_apart); it must live as long.
  explicit Text(const Dataset& dataset) : dataset_(&dataset) {}
  Text& word(std::string_view text);
  Text& number(double value);  ///< BadFile naming the line so far where it is not finite
  Text& id(Key key);           ///< Key::id(), or the bits of one of the symbols; BadKey where the key has no id
  void end_line();
  std::size_t size() const { return text_.size(); }
  std::string take() { return std::move(text_); }

 private:
  const Dataset* dataset_ = nullptr;
  std::string text_;
  std::size_t line_start_ = 0;
};

}  // namespace holdfast::io
