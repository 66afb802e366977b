#include <gtest/gtest.h>

#include <holdfast/graph/error.hpp>
#include <holdfast/graph/key.hpp>
#include <set>
#include <sstream>

namespace holdfast {
namespace {

constexpr std::uint64_t kMostIndex = (std::uint64_t{1} << 56) - 1;

TEST(Key, NamesAnAgentAndAnIndex) {
  constexpr Agent A('A');
  constexpr Key key = A(11);
  EXPECT_EQ(key.agent(), 'A');
  EXPECT_EQ(key.index(), 11u);
  EXPECT_EQ(key.str(), "A11");
  std::ostringstream out;
  out << key;
  EXPECT_EQ(out.str(), "A11");
}

TEST(Key, IsReadBackFromItsText) {
  for (const Key key : {Key('A', 0), Key('z', 7), Key('_', 123456789), Key('x', kMostIndex), Key('~', 42)})
    EXPECT_EQ(Key::parse(key.str()), key) << key;
  EXPECT_EQ(Key::parse("B007"), Key('B', 7));
}

TEST(Key, RefusesTextThatIsNone) {
  for (const char* text :
       {"", "A", "11", "1A", "AA1", "A-1", "A+1", "A 1", " A1", "A1 ", "A1.5", "A1x", "A72057594037927936", "A99999999999999999999999"}) {
    try {
      Key::parse(text);
      ADD_FAILURE() << text;
    } catch (const BadKey& error) {
      EXPECT_NE(std::string(error.what()).find("'" + std::string(text) + "'"), std::string::npos);
    }
  }
}

TEST(Key, SortsByAgentThenIndex) {
  EXPECT_LT(Key('A', 900), Key('B', 1));
  EXPECT_LT(Key('A', 9), Key('A', 10));
  EXPECT_NE(Key('A', 1), Key('B', 1));
  EXPECT_FALSE(Key('A', 1) < Key('A', 1));
}

TEST(Key, AgentsAndIndicesNeverMix) {
  EXPECT_EQ(Key('\xff', kMostIndex).index(), kMostIndex);
  EXPECT_EQ(Key('\xff', kMostIndex).agent(), '\xff');
  EXPECT_NE(Key('A', 0), Key('B', 0));
}

TEST(Key, HashSpreadsRealKeys) {
  std::set<std::size_t> buckets;
  int count = 0;
  for (char agent = 'A'; agent <= 'Z'; ++agent)
    for (std::uint64_t i = 0; i < 400; ++i, ++count) buckets.insert(std::hash<Key>{}({agent, i}) % 20011);
  EXPECT_GT(buckets.size(), 0.3 * count);  // 0.4 by chance
}

}  // namespace
}  // namespace holdfast
