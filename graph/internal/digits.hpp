// A number as text: the shortest that reads back as the same number, whatever the locale.
#pragma once

#include <charconv>
#include <string_view>

namespace holdfast {

/// The digits live as long as this object.
class Digits {
 public:
  explicit Digits(double value) : end_(std::to_chars(text_, text_ + sizeof text_, value).ptr) {}
  operator std::string_view() const { return {text_, static_cast<std::size_t>(end_ - text_)}; }
  Digits(const Digits&) = delete;
  Digits& operator=(const Digits&) = delete;

 private:
  char text_[32];
  const char* end_;
};

}  // namespace holdfast
