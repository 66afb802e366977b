#include <unistd.h>

#include <algorithm>
#include <array>
#include <cstdlib>
#include <cstring>
#include <holdfast/common/coloured.hpp>
#include <utility>

namespace holdfast::common {
namespace {

constexpr const char* kPlain = "\033[0m";

/// The beginning of a line, and what is written in its place; the longest that fits counts.
struct Beginning {
  const char *text, *coloured;
  bool is_bold;  ///< to its end
};
constexpr std::array kBeginnings{Beginning{"holdfast: warning:", "\033[1mholdfast: \033[33mwarning:\033[0m", false},
                                 Beginning{"holdfast: note:", "\033[1mholdfast: \033[36mnote:\033[0m", false},
                                 Beginning{"holdfast:", "\033[1mholdfast:\033[0m", false}, Beginning{"== ", "\033[1m== ", true}};

bool starts(const std::string& text, const std::string& with) { return text.compare(0, with.size(), with) == 0; }

}  // namespace

bool wants_colour(int descriptor) {
  const char *no = std::getenv("NO_COLOR"), *term = std::getenv("TERM");
  return ::isatty(descriptor) != 0 && (no == nullptr || *no == '\0') && term != nullptr && std::strcmp(term, "dumb") != 0;
}

bool Coloured::put(const std::string& text) {
  if (text.empty()) return true;
  at_begin_ = text.back() == '\n' || text.back() == '\r';
  const bool ends_bold = is_bold_ && at_begin_;
  if (ends_bold) is_bold_ = false;
  const std::string all = ends_bold ? text.substr(0, text.size() - 1) + kPlain + text.back() : text;
  return to_->sputn(all.data(), static_cast<std::streamsize>(all.size())) == static_cast<std::streamsize>(all.size());
}

bool Coloured::pass_on() {
  const std::string text = std::exchange(held_, {});
  for (const Beginning& one : kBeginnings) {
    if (!starts(text, one.text)) continue;
    is_bold_ = one.is_bold;
    return put(one.coloured + text.substr(std::strlen(one.text)));
  }
  return put(text);
}

Coloured::int_type Coloured::overflow(int_type c) {
  if (traits_type::eq_int_type(c, traits_type::eof())) return traits_type::not_eof(c);
  const char character = traits_type::to_char_type(c);
  if (!at_begin_) return put(std::string(1, character)) ? c : traits_type::eof();
  held_ += character;
  const bool may_be_longer = std::any_of(kBeginnings.begin(), kBeginnings.end(), [&](const Beginning& one) {
    return std::strlen(one.text) > held_.size() && starts(one.text, held_);
  });
  return may_be_longer || pass_on() ? c : traits_type::eof();
}

int Coloured::sync() { return pass_on() && to_->pubsync() == 0 ? 0 : -1; }

}  // namespace holdfast::common
