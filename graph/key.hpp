// Keys: an agent's letter and an index, printed as A11.
#pragma once

#include <cstdint>
#include <functional>
#include <iosfwd>
#include <string>
#include <string_view>

namespace holdfast {

/// Names one variable: agent letter (any printable character that is no digit) and index < 2^56.
class Key {
 public:
  constexpr Key() = default;
  constexpr Key(char agent, std::uint64_t index)
      : bits_((static_cast<std::uint64_t>(static_cast<unsigned char>(agent)) << 56) | (index & kIndexMask)) {}

  constexpr char agent() const { return static_cast<char>(bits_ >> 56); }
  constexpr std::uint64_t index() const { return bits_ & kIndexMask; }
  constexpr std::uint64_t bits() const { return bits_; }
  std::string str() const;

  /// Reads `A11`; throws BadKey naming the text where it is no letter followed by an index.
  static Key parse(std::string_view text);

  friend constexpr bool operator==(Key a, Key b) { return a.bits_ == b.bits_; }
  friend constexpr bool operator!=(Key a, Key b) { return a.bits_ != b.bits_; }
  friend constexpr bool operator<(Key a, Key b) { return a.bits_ < b.bits_; }

 private:
  static constexpr std::uint64_t kIndexMask = (std::uint64_t{1} << 56) - 1;
  std::uint64_t bits_ = 0;
};

std::ostream& operator<<(std::ostream& out, Key key);

/// Makes keys of one agent: `constexpr Agent A('A'); A(11)` is the key A11.
class Agent {
 public:
  constexpr explicit Agent(char letter) : letter_(letter) {}
  constexpr Key operator()(std::uint64_t index) const { return {letter_, index}; }

 private:
  char letter_;
};

}  // namespace holdfast

template <>
struct std::hash<holdfast::Key> {
  std::size_t operator()(holdfast::Key key) const noexcept {
    std::uint64_t x = key.bits() * 0x9E3779B97F4A7C15ull;  // Fibonacci hashing: consecutive indices spread over the table
    return static_cast<std::size_t>(x ^ (x >> 32));
  }
};
