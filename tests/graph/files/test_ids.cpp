// Integer ids of any 64 bits, as other programs write them into g2o and TORO files, and keys of many agents in any format.
#include <holdfast/graph/files/tum.hpp>
#include <holdfast/graph/starts/start.hpp>
#include <random>

#include "tests/graph/files/helpers.hpp"

namespace holdfast {
namespace {

using namespace testing_io;

constexpr const char* kUnit = " 1 0 0 1 0 0 1 0 1\n";  // one step forwards, identity information

std::string edge(std::uint64_t a, std::uint64_t b) { return "EDGE_SE2 " + std::to_string(a) + " " + std::to_string(b) + kUnit; }
std::string pose(std::uint64_t id) { return "VERTEX_SE2 " + std::to_string(id) + " 0 0 0\n"; }
constexpr std::uint64_t symbol(char c, std::uint64_t index) { return (static_cast<std::uint64_t>(c) << 56) | index; }

// Two robots, as GTSAM writes them (gtsam::Symbol).
TEST(Ids, SymbolsOfGtsamAreTheirKeys) {
  const std::string text = pose(6989586621679009792u) + pose(6989586621679009793u) + pose(7061644215716937728u) +
                           edge(6989586621679009792u, 6989586621679009793u) + edge(6989586621679009793u, 7061644215716937728u);
  const Dataset data = parsed(text, Format::G2o);
  EXPECT_EQ(data.vertices[0].key, Key('a', 0));
  EXPECT_EQ(data.vertices[1].key, Key('a', 1));
  EXPECT_EQ(data.vertices[2].key, Key('b', 0));
  EXPECT_EQ(odometry_edges(data), (std::vector<bool>{true, false}));  // from one robot to the other is none
  EXPECT_EQ(to_g2o(data), text);
}

// 'A' << 48 | n: what several multi-robot programs write.
TEST(Ids, ALetterInBit48KeepsRobotsApart) {
  const std::uint64_t A = std::uint64_t{'A'} << 48, B = std::uint64_t{'B'} << 48;
  const Dataset data = parsed(edge(A, A + 1) + edge(A + 1, B) + edge(B, B + 1), Format::G2o);
  EXPECT_EQ(odometry_edges(data), (std::vector<bool>{true, false, true}));
  EXPECT_EQ(to_g2o(data), edge(A, A + 1) + edge(A + 1, B) + edge(B, B + 1));
}

TEST(Ids, EveryIdComesBack) {
  std::mt19937_64 rng(3);
  for (const Format format : {Format::G2o, Format::Toro}) {
    std::string text;
    std::uint64_t last = 0;
    for (int i = 0; i < 1000; ++i) {
      const std::uint64_t id = std::max<std::uint64_t>(1, rng() >> (rng() % 64)) ^ last;  // of any length
      if (Key::from_id(id) == Key::from_id(last)) continue;
      text += format == Format::G2o ? edge(last, id) : "EDGE2 " + std::to_string(last) + " " + std::to_string(id) + " 1 0 0 1 0 1 1 0 0\n";
      last = id;
    }
    for (const std::uint64_t id : {symbol('x', 1u << 31), symbol('z', 5), ~std::uint64_t{0}})
      text += format == Format::G2o ? edge(last, id) : "EDGE2 " + std::to_string(last) + " " + std::to_string(id) + " 1 0 0 1 0 1 1 0 0\n";
    const Dataset data = parsed(text, format);
    EXPECT_EQ(written(data), text);
    expect_same(parsed(written(data), format), data);
  }
}

TEST(Ids, PlainNumbersAndSymbolsOfXStandInOneFile) {
  const std::string text = pose(5) + pose(symbol('x', 6)) + "FIX " + std::to_string(symbol('x', 6)) + "\n" + edge(5, symbol('x', 6));
  const Dataset data = parsed(text, Format::G2o);
  EXPECT_EQ(data.vertices[0].key, Key('x', 5));
  EXPECT_EQ(data.vertices[1].key, Key('x', 6));
  EXPECT_EQ(to_g2o(data), text);
}

TEST(Ids, TwoIdsOfOneKeyAreRefused) {
  const std::string five = std::to_string(symbol('x', 5));
  for (const std::string& second : {pose(symbol('x', 5)), edge(5, symbol('x', 6)) + edge(symbol('x', 5), 7), "FIX " + five + "\n"})
    expect_message<BadFile>([&] { parsed(pose(5) + second, Format::G2o); },
                            {"names x5 by the id " + five, "line 1 by the id 5", "gtsam::Symbol('x', 5)"});
  expect_message<BadFile>([&] { parsed("FIX 5\n" + pose(1) + pose(symbol('x', 5)), Format::G2o); }, {"line 3", "line 1 by the id 5"});
  expect_message<BadFile>([&] { parsed(pose(symbol('x', 5)) + pose(5), Format::G2o); },
                          {"names x5 by the id 5", "line 1 by the id " + five});
}

TEST(Ids, KeysOfOtherFormatsBecomeSymbols) {
  Dataset data = parsed("VERTEX_SE2 0 A0 0 0 0\nVERTEX_SE2 1 A1 1 0 0\n", Format::PyFG);
  for (Vertex& vertex : data.vertices) vertex.time.reset();
  data.vertices[1].key = Agent('r', 1234)(7);
  EXPECT_EQ(to_g2o(data), "VERTEX_SE2 4683743612465315840 0 0 0\nVERTEX_SE2 " + std::to_string(0x720004d200000007u) + " 1 0 0\n");
  EXPECT_EQ(parsed(to_g2o(data), Format::G2o).vertices[1].key, Agent('r', 1234)(7));
}

// Other programs read a letter and an index; we read our own text, too.
TEST(Ids, PyfgNamesAreALetterAndAnIndex) {
  const std::string text = "VERTEX_SE2 0 r5299989643271 0 0 0\nVERTEX_SE2 1 A72057594037927935 1 0 0\n";
  const Dataset data = parsed(text, Format::PyFG);
  EXPECT_EQ(data.vertices[0].key, Agent('r', 1234)(7));
  EXPECT_EQ(to_pyfg(data), text);
  EXPECT_EQ(parsed("VERTEX_SE2 0 r1234:7 0 0 0\n", Format::PyFG).vertices[0].key, Agent('r', 1234)(7));
  Dataset unnamed = data;
  unnamed.vertices[0].key = Key::from_id(std::uint64_t{'A'} << 48);
  expect_message<BadFile>([&] { to_pyfg(unnamed); }, {"a PyFG file cannot hold", "a letter and an index; rename 0x0041000000000000"});
}

}  // namespace
}  // namespace holdfast
