// Keys name variables; an agent is what has many of them, one a step: a robot, a landmark, a sensor's bias.
//
// Layout of the 64 bits:   kind (8)  ·  agent number (24)  ·  step (32)
//
//   constexpr Agent A('A');            // kind A, number 0
//   A(11)                              // its step 11: the key A11, the same as Key('A', 11)
//   Agent('r', 1234)(7)                // robot 1234 of kind r, step 7: the key r1234:7
//
// Whatever the library does "per agent" (odometry, chains, trajectories, windows) it does for each pair of kind and number.
//
// Text. Every one of the 2^64 keys has a text, and parse(str()) gives it back:
//   A11        the agent's number is 0
//   r1234:7    it is not
//   0x…        16 hexadecimal digits, where the kind is no printable ASCII character, or is a digit
// An agent's text is A, r1234, or 0x and 8 hexadecimal digits.
//
// Keys of other programs.
//   gtsam::Symbol('x', j)              has the bits of Key('x', j), for any j < 2^56: from_bits() and bits().
//   gtsam::LabeledSymbol('x', 'B', j)  character (8) · label (8) · index (48): the bits of Agent('x', 'B' << 16)(j) for j < 2^32.
//   ids in g2o, TORO and MRPT          from_id() and id(): n < 2^32 is the key x<n>, any other id is taken bit by bit, so GTSAM's
//                                      symbols and 'A' << 48 | n (robot A, its n-th pose) keep agents apart.
#pragma once

#include <cstdint>
#include <functional>
#include <iosfwd>
#include <string>
#include <string_view>
#include <type_traits>

namespace holdfast {

class Key;

namespace detail {
[[noreturn]] void fail_agent_number(char kind, std::uint64_t number);
[[noreturn]] void fail_step(char kind, std::uint32_t number, std::uint64_t step);
[[noreturn]] void fail_index(char kind, std::uint64_t index);
}  // namespace detail

/// A kind (any character) and a number < 2^24. A character alone converts to the agent of that kind with number 0.
class Agent {
 public:
  static constexpr std::uint64_t kMostNumber = (std::uint64_t{1} << 24) - 1;

  constexpr Agent() = default;
  template <class Char, class = std::enable_if_t<std::is_same_v<Char, char>>>  // no int becomes an agent by accident
  constexpr Agent(Char kind) : Agent(kind, 0) {}
  /// BadKey where the number is 2^24 or more.
  constexpr Agent(char kind, std::uint64_t number)
      : bits_((static_cast<std::uint32_t>(static_cast<unsigned char>(kind)) << 24) | static_cast<std::uint32_t>(number)) {
    if (number > kMostNumber) detail::fail_agent_number(kind, number);
  }
  static constexpr Agent from_bits(std::uint32_t bits) {
    Agent agent;
    agent.bits_ = bits;
    return agent;
  }

  /// Its key of this step. BadKey where the step is 2^32 or more.
  constexpr Key operator()(std::uint64_t step) const;

  constexpr char kind() const { return static_cast<char>(bits_ >> 24); }
  constexpr std::uint32_t number() const { return bits_ & kMostNumber; }
  constexpr std::uint32_t bits() const { return bits_; }
  std::string str() const;
  /// Reads what str() writes; throws BadKey naming the text.
  static Agent parse(std::string_view text);

  friend constexpr bool operator==(Agent a, Agent b) { return a.bits_ == b.bits_; }
  friend constexpr bool operator!=(Agent a, Agent b) { return a.bits_ != b.bits_; }
  friend constexpr bool operator<(Agent a, Agent b) { return a.bits_ < b.bits_; }

 private:
  std::uint32_t bits_ = 0;
};

/// Names one variable. Keys sort by kind, then agent number, then step.
class Key {
 public:
  static constexpr std::uint64_t kMostIndex = (std::uint64_t{1} << 56) - 1;

  constexpr Key() = default;
  /// The index fills step and agent number as one number, as gtsam::Symbol's does: Key('A', 11) is A11. BadKey where it is 2^56 or more.
  constexpr Key(char kind, std::uint64_t index) : bits_((static_cast<std::uint64_t>(static_cast<unsigned char>(kind)) << 56) | index) {
    if (index > kMostIndex) detail::fail_index(kind, index);
  }
  static constexpr Key from_bits(std::uint64_t bits) {
    Key key;
    key.bits_ = bits;
    return key;
  }
  /// The key of an integer id; see above.
  static constexpr Key from_id(std::uint64_t id) { return id >> 32 == 0 ? Key('x', id) : from_bits(id); }

  constexpr std::uint64_t bits() const { return bits_; }
  /// The integer that from_id() makes this key of. The 2^32 keys of kind 0 and agent number 0 have none: BadKey.
  std::uint64_t id() const;
  constexpr Agent agent() const { return Agent::from_bits(static_cast<std::uint32_t>(bits_ >> 32)); }
  constexpr char kind() const { return static_cast<char>(bits_ >> 56); }
  constexpr std::uint32_t step() const { return static_cast<std::uint32_t>(bits_); }
  /// Agent number and step as one number < 2^56: gtsam::Symbol's index.
  constexpr std::uint64_t index() const { return bits_ & kMostIndex; }

  std::string str() const;
  /// Reads what str() writes, and a kind with any index < 2^56; throws BadKey naming the text.
  static Key parse(std::string_view text);

  friend constexpr bool operator==(Key a, Key b) { return a.bits_ == b.bits_; }
  friend constexpr bool operator!=(Key a, Key b) { return a.bits_ != b.bits_; }
  friend constexpr bool operator<(Key a, Key b) { return a.bits_ < b.bits_; }

 private:
  std::uint64_t bits_ = 0;
};

constexpr Key Agent::operator()(std::uint64_t step) const {
  if (step >> 32 != 0) detail::fail_step(kind(), number(), step);
  return Key::from_bits((static_cast<std::uint64_t>(bits_) << 32) | step);
}

std::ostream& operator<<(std::ostream& out, Agent agent);
std::ostream& operator<<(std::ostream& out, Key key);

}  // namespace holdfast

template <>
struct std::hash<holdfast::Key> {
  std::size_t operator()(holdfast::Key key) const noexcept {
    // A product alone leaves keys that differ in high bits only (agents at one step) crowded; so fold, multiply, fold, twice.
    std::uint64_t x = key.bits();
    x = (x ^ (x >> 32)) * 0x9E3779B97F4A7C15ull;
    x = (x ^ (x >> 29)) * 0xBF58476D1CE4E5B9ull;
    return static_cast<std::size_t>(x ^ (x >> 32));
  }
};
template <>
struct std::hash<holdfast::Agent> {
  std::size_t operator()(holdfast::Agent agent) const noexcept {
    return std::hash<holdfast::Key>()(holdfast::Key::from_bits(agent.bits()));
  }
};
