// Colours for a terminal somebody looks at: of what the program says, the name and the kind of each line.
#pragma once

#include <streambuf>
#include <string>

namespace holdfast::common {

/// Whether a file descriptor is a terminal that wants colours: https://no-color.org (NO_COLOR is not set), TERM is not "dumb".
bool wants_colour(int descriptor);

/// Passes on what is written, at once; the beginning of a line "holdfast: warning:", "holdfast: note:" or "holdfast:" coloured, and a line
/// "== …" bold. What was written last is passed on when it goes.
class Coloured : public std::streambuf {
 public:
  explicit Coloured(std::streambuf* to) : to_(to) {}
  ~Coloured() override { pass_on(); }

 protected:
  int_type overflow(int_type c) override;
  int sync() override;

 private:
  bool pass_on();  ///< what is held back
  bool put(const std::string& text);

  std::streambuf* to_;
  std::string held_;  ///< the beginning of a line, as long as it may become one that is coloured
  bool at_begin_ = true, is_bold_ = false;
};

}  // namespace holdfast::common
