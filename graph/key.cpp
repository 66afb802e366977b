#include <charconv>
#include <holdfast/graph/error.hpp>
#include <holdfast/graph/key.hpp>
#include <optional>
#include <ostream>

namespace holdfast {
namespace {

bool is_digit(char c) { return c >= '0' && c <= '9'; }
/// A kind that begins a text by itself: printable ASCII, but no space and no digit.
bool is_plain(char kind) { return kind > ' ' && kind < 0x7f && !is_digit(kind); }

std::string hexadecimal(std::uint64_t bits, std::size_t digits) {
  char buffer[16];
  const char* const end = std::to_chars(buffer, buffer + sizeof buffer, bits, 16).ptr;
  const auto size = static_cast<std::size_t>(end - buffer);
  return "0x" + std::string(digits - size, '0') + std::string(buffer, size);
}

/// The whole text as a number <= most.
std::optional<std::uint64_t> number_in(std::string_view text, std::uint64_t most, int base = 10) {
  std::uint64_t number = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), number, base);
  if (error != std::errc{} || end != text.data() + text.size() || number > most) return std::nullopt;
  return number;
}

std::optional<std::uint64_t> hexadecimal_in(std::string_view text, std::size_t digits) {
  if (text.size() != 2 + digits || text.substr(0, 2) != "0x") return std::nullopt;
  return number_in(text.substr(2), ~std::uint64_t{0}, 16);
}

std::optional<Agent> agent_in(std::string_view text) {
  if (const auto bits = hexadecimal_in(text, 8)) return Agent::from_bits(static_cast<std::uint32_t>(*bits));
  if (text.empty() || !is_plain(text[0])) return std::nullopt;
  if (text.size() == 1) return Agent(text[0]);
  const auto number = number_in(text.substr(1), Agent::kMostNumber);
  if (!number) return std::nullopt;
  return Agent(text[0], *number);
}

std::optional<Key> key_in(std::string_view text) {
  if (const auto bits = hexadecimal_in(text, 16)) return Key::from_bits(*bits);
  if (text.size() < 2 || !is_plain(text[0])) return std::nullopt;
  const std::size_t colon = text.find(':', 1);  // a colon in front would be the kind
  if (colon == std::string_view::npos) {
    const auto index = number_in(text.substr(1), Key::kMostIndex);
    if (!index) return std::nullopt;
    return Key(text[0], *index);
  }
  const auto number = number_in(text.substr(1, colon - 1), Agent::kMostNumber);
  const auto step = number_in(text.substr(colon + 1), 0xffffffffu);
  if (!number || !step) return std::nullopt;
  return Agent(text[0], *number)(*step);
}

}  // namespace

namespace detail {
void fail_agent_number(char kind, std::uint64_t number) {
  fail<BadKey>("agent number ", number, " of kind ", Agent(kind),
               " is not below 2^24 = 16777216; number agents from 0, or use another kind");
}
void fail_step(char kind, std::uint32_t number, std::uint64_t step) {
  fail<BadKey>("step ", step, " of agent ", Agent(kind, number), " is not below 2^32 = 4294967296; number steps from 0");
}
void fail_index(char kind, std::uint64_t index) {
  fail<BadKey>("index ", index, " of a key of kind ", Agent(kind), " is not below 2^56; take Key::from_bits() for a whole 64-bit key");
}
}  // namespace detail

std::string Agent::str() const {
  if (!is_plain(kind())) return hexadecimal(bits_, 8);
  return kind() + (number() > 0 ? std::to_string(number()) : std::string());
}

Agent Agent::parse(std::string_view text) {
  if (const auto agent = agent_in(text)) return *agent;
  fail<BadKey>("'", text,
               "' is not an agent: expected a character that is no digit, and a number below 2^24 unless it is 0, such as A or r1234");
}

std::string Key::str() const {
  if (!is_plain(kind())) return hexadecimal(bits_, 16);
  return agent().str() + (agent().number() > 0 ? ":" : "") + std::to_string(step());
}

Key Key::parse(std::string_view text) {
  if (const auto key = key_in(text)) return *key;
  fail<BadKey>("'", text,
               "' is not a key: expected a character that is no digit and an index below 2^56, such as A11; "
               "with an agent's number below 2^24 and a step below 2^32, such as r1234:7; or 0x and 16 hexadecimal digits");
}

std::uint64_t Key::id() const {
  if (kind() == 'x' && agent().number() == 0) return step();
  if (bits_ >> 32 == 0)
    fail<BadKey>("key ", *this, " has no integer id: ", bits_, " is the id of x", bits_, "; give it a kind, such as Key('y', ", step(),
                 ")");
  return bits_;
}

std::ostream& operator<<(std::ostream& out, Agent agent) { return out << agent.str(); }
std::ostream& operator<<(std::ostream& out, Key key) { return out << key.str(); }

}  // namespace holdfast
