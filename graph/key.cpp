#include <cctype>
#include <charconv>
#include <holdfast/graph/error.hpp>
#include <holdfast/graph/key.hpp>
#include <ostream>

namespace holdfast {

std::string Key::str() const { return agent() + std::to_string(index()); }

Key Key::parse(std::string_view text) {
  std::uint64_t index = 0;
  const bool has_agent =
      text.size() >= 2 && std::isgraph(static_cast<unsigned char>(text[0])) && !std::isdigit(static_cast<unsigned char>(text[0]));
  if (has_agent) {
    const auto [end, error] = std::from_chars(text.data() + 1, text.data() + text.size(), index);
    if (error == std::errc{} && end == text.data() + text.size() && index <= kIndexMask) return {text[0], index};
  }
  fail<BadKey>("'", text, "' is not a key: expected an agent letter and an index below 2^56, such as A11");
}

std::ostream& operator<<(std::ostream& out, Key key) { return out << key.agent() << key.index(); }

}  // namespace holdfast
