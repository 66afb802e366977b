#include <gtest/gtest.h>

#include <algorithm>
#include <holdfast/graph/error.hpp>
#include <holdfast/graph/key.hpp>
#include <random>
#include <sstream>
#include <unordered_set>

namespace holdfast {
namespace {

template <class Action>
void expect_bad_key(Action&& action, const std::vector<std::string>& parts) {
  try {
    action();
    ADD_FAILURE() << "nothing thrown; expected '" << parts.front() << "'";
  } catch (const BadKey& error) {
    for (const std::string& part : parts) EXPECT_NE(std::string(error.what()).find(part), std::string::npos) << error.what();
  }
}

TEST(Key, HasKindAgentAndStep) {
  constexpr Agent A('A'), r('r', 1234);
  constexpr Key first = A(11), second = r(7);
  static_assert(first == Key('A', 11) && first.agent() == A && first.step() == 11 && first.kind() == 'A');
  static_assert(second.agent() == r && second.step() == 7 && second.agent().number() == 1234 && second.agent().kind() == 'r');
  EXPECT_EQ(first.bits(), 0x4100000000000000u + 11);
  EXPECT_EQ(second.bits(), 0x720004d200000007u);
  EXPECT_EQ(second.index(), 0x0004d200000007u);
  EXPECT_EQ(Key::from_bits(0x720004d200000007u), second);
  EXPECT_EQ(Agent::from_bits(0x720004d2u), r);
}

TEST(Key, IsPrinted) {
  EXPECT_EQ(Key('A', 11).str(), "A11");
  EXPECT_EQ(Agent('r', 1234)(7).str(), "r1234:7");
  EXPECT_EQ(Agent('r', 1234).str(), "r1234");
  EXPECT_EQ(Agent('A').str(), "A");
  EXPECT_EQ(Agent(':', 5)(7).str(), ":5:7");
  EXPECT_EQ(Key::from_bits(0x0041000000000005u).str(), "0x0041000000000005");
  EXPECT_EQ(Key('7', 1).str(), "0x3700000000000001");
  EXPECT_EQ(Agent('\0', 0x410000).str(), "0x00410000");
  std::ostringstream out;
  out << Key('A', 11) << ' ' << Agent('r', 1234);
  EXPECT_EQ(out.str(), "A11 r1234");
}

// All kinds, all sizes of agent number and step.
TEST(Key, EveryKeyIsReadBackFromItsText) {
  std::mt19937_64 rng(7);
  for (int kind = 0; kind < 256; ++kind)
    for (int number_bits = 0; number_bits <= 24; ++number_bits)
      for (int step_bits = 0; step_bits <= 32; ++step_bits) {
        const std::uint64_t number = rng() & ((std::uint64_t{1} << number_bits) - 1), step = rng() & ((std::uint64_t{1} << step_bits) - 1);
        const Agent agent(static_cast<char>(kind), number);
        ASSERT_EQ(Agent::parse(agent.str()), agent) << agent;
        ASSERT_EQ(Key::parse(agent(step).str()), agent(step)) << agent(step);
      }
  for (int i = 0; i < 100'000; ++i) {
    const Key key = Key::from_bits(rng());
    ASSERT_EQ(Key::parse(key.str()), key) << key;
  }
}

TEST(Key, IsReadFromTextThatPeopleWrite) {
  EXPECT_EQ(Key::parse("B007"), Key('B', 7));
  EXPECT_EQ(Key::parse("r0:7"), Key('r', 7));
  EXPECT_EQ(Key::parse("x72057594037927935"), Key('x', Key::kMostIndex));
  EXPECT_EQ(Key::parse("0x00000000000000FF"), Key::from_bits(255));
}

TEST(Key, RefusesTextThatIsNone) {
  for (const char* text : {"",
                           "A",
                           "11",
                           "1A",
                           "AA1",
                           "A-1",
                           "A+1",
                           "A 1",
                           " A1",
                           "A1 ",
                           "A1.5",
                           "A1x",
                           "A72057594037927936",
                           "A99999999999999999999999",
                           "r1:",
                           "r:1",
                           ":1:",
                           "r1:2:3",
                           "r16777216:0",
                           "r1:4294967296",
                           "0x41",
                           "0x000000000000000g",
                           "0x00000000000000000",
                           "0x-000000000000001"})
    expect_bad_key([&] { Key::parse(text); }, {"'" + std::string(text) + "' is not a key", "A11"});
  for (const char* text : {"", "7", "77", "A-1", "r16777216", "r1:", "r1:2", "0x0041", "0x004100000", "AA"})
    expect_bad_key([&] { Agent::parse(text); }, {"'" + std::string(text) + "' is not an agent", "r1234"});
}

TEST(Key, NumbersThatDoNotFitAreNamed) {
  EXPECT_EQ(Agent('r', (1 << 24) - 1)(0xffffffffu).bits(), 0x72ffffffffffffffu);
  expect_bad_key([] { Agent('r', 1 << 24); }, {"16777216", "kind r", "2^24"});
  expect_bad_key([] { Agent('r', 5)(std::uint64_t{1} << 32); }, {"4294967296", "r5", "2^32"});
  expect_bad_key([] { Key('x', std::uint64_t{1} << 56); }, {"72057594037927936", "kind x", "2^56", "from_bits"});
}

TEST(Key, SortsByKindThenAgentThenStep) {
  EXPECT_LT(Key('A', 900), Key('B', 1));
  EXPECT_LT(Key('A', 9), Key('A', 10));
  EXPECT_LT(Agent('A', 1)(900), Agent('A', 2)(1));
  EXPECT_LT(Agent('A', 900)(1), Agent('B', 1)(1));
  EXPECT_LT(Key('A', 1), Key('\xff', 1));  // as bits, whatever the sign of a char
  EXPECT_NE(Key('A', 1), Key('B', 1));
  EXPECT_FALSE(Key('A', 1) < Key('A', 1));
  EXPECT_LT(Agent('A'), Agent('A', 1));
  EXPECT_NE(Agent('A'), Agent('B'));
}

TEST(Key, ACharacterIsAnAgentAndANumberIsNone) {
  EXPECT_EQ(Key('A', 3).agent(), 'A');
  EXPECT_NE(Agent('A', 1)(3).agent(), 'A');
  static_assert(std::is_convertible_v<char, Agent>);
  static_assert(!std::is_convertible_v<int, Agent> && !std::is_convertible_v<unsigned char, Agent>);
}

// Symbol: character (8) · index (56). LabeledSymbol: character (8) · label (8) · index (48).
TEST(Key, HasTheBitsOfGtsamsSymbols) {
  EXPECT_EQ(Key('a', 0).bits(), 6989586621679009792u);  // gtsam::Symbol('a', 0), as GTSAM writes it into a g2o file
  EXPECT_EQ(Key('b', 3).bits(), 7061644215716937731u);
  const std::uint64_t labeled = (std::uint64_t{'x'} << 56) | (std::uint64_t{'B'} << 48) | 12;
  EXPECT_EQ(Agent('x', 'B' << 16)(12).bits(), labeled);
  EXPECT_EQ(Key::from_bits(labeled).bits(), labeled);
}

TEST(Key, HasAnIntegerId) {
  EXPECT_EQ(Key::from_id(11), Key('x', 11));
  EXPECT_EQ(Key::from_id(0xffffffffu), Key('x', 0xffffffffu));
  EXPECT_EQ(Key::from_id(std::uint64_t{1} << 32).bits(), std::uint64_t{1} << 32);
  const std::uint64_t robot = (std::uint64_t{'A'} << 48) | 5;
  EXPECT_EQ(Key::from_id(robot).agent(), Agent('\0', 'A' << 16));
  EXPECT_EQ(Key::from_id(robot).step(), 5u);
  std::mt19937_64 rng(11);
  for (int i = 0; i < 100'000; ++i) {
    const std::uint64_t id = rng() >> (rng() % 64);
    ASSERT_EQ(Key::from_id(id).id(), id);
  }
  EXPECT_EQ(Key('A', 3).id(), Key('A', 3).bits());
  expect_bad_key([] { Key::from_bits(5).id(); }, {"0x0000000000000005", "x5"});
}

/// Pairs of keys in one bucket of a std::unordered_map, by what chance would give; and the fullest bucket.
std::pair<double, std::size_t> crowding(const std::vector<Key>& keys) {
  const std::unordered_set<Key> table(keys.begin(), keys.end());
  double pairs = 0;
  std::size_t fullest = 0;
  for (std::size_t b = 0; b < table.bucket_count(); ++b) {
    const auto size = table.bucket_size(b);
    pairs += 0.5 * static_cast<double>(size) * (static_cast<double>(size) - 1);
    fullest = std::max(fullest, size);
  }
  const double n = static_cast<double>(keys.size());
  return {pairs / (0.5 * n * (n - 1) / static_cast<double>(table.bucket_count())), fullest};
}

std::vector<Key> keys_of(int kinds, int agents, int steps) {
  std::vector<Key> keys;
  for (int kind = 0; kind < kinds; ++kind)
    for (int agent = 0; agent < agents; ++agent)
      for (int step = 0; step < steps; ++step)
        keys.push_back(Agent(static_cast<char>('A' + kind), static_cast<std::uint64_t>(agent))(static_cast<std::uint64_t>(step)));
  return keys;
}

TEST(Key, HashSpreadsAgentsStepsAndKinds) {
  for (const auto& keys : {keys_of(1, 100'000, 10), keys_of(1, 100'000, 1), keys_of(1, 1, 100'000), keys_of(26, 100, 400)}) {
    const auto [pairs, fullest] = crowding(keys);
    EXPECT_LT(pairs, 1.1) << keys.front() << " … " << keys.back();
    EXPECT_LE(fullest, 12u) << keys.front() << " … " << keys.back();
  }
}

TEST(Agent, HashesApart) {
  std::unordered_set<std::size_t> hashes;
  for (std::uint64_t number = 0; number < 100'000; ++number) hashes.insert(std::hash<Agent>{}(Agent('r', number)));
  EXPECT_EQ(hashes.size(), 100'000u);
}

}  // namespace
}  // namespace holdfast
