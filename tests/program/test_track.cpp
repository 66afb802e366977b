#include <gmock/gmock.h>

#include <array>
#include <csignal>
#include <filesystem>
#include <holdfast/program/sought.hpp>
#include <iostream>
#include <map>
#include <random>
#include <regex>
#include <thread>

#include "tests/faults.hpp"
#include "tests/program/helpers.hpp"

namespace holdfast::program {
namespace {

using ::testing::HasSubstr;

class CliTrack : public InDirectory {
 protected:
  /// The program with this text as its standard input.
  static Outcome piped(const std::string& text, std::vector<std::string> arguments) {
    std::istringstream in(text);
    std::streambuf* const before = std::cin.rdbuf(in.rdbuf());
    std::cin.clear();
    arguments.insert(arguments.begin(), {"track", "-"});
    const Outcome outcome = holdfast_program(arguments);
    std::cin.rdbuf(before);
    return outcome;
  }
  /// The same, ended by a signal where the text ends: saved, and not finished.
  static Outcome ended_by_a_signal(const std::string& text, std::vector<std::string> arguments) {
    struct Ending : std::stringbuf {
      using std::stringbuf::stringbuf;
      int_type underflow() override {
        const int_type next = std::stringbuf::underflow();
        if (next == traits_type::eof()) std::raise(SIGTERM);
        return next;
      }
    } ending(text);
    std::streambuf* const before = std::cin.rdbuf(&ending);
    std::cin.clear();
    arguments.insert(arguments.begin(), {"track", "-"});
    const Outcome outcome = holdfast_program(arguments);
    std::cin.rdbuf(before);
    return outcome;
  }
};

std::vector<nlohmann::ordered_json> states_of(const std::string& out) {
  std::istringstream text(out);
  std::vector<nlohmann::ordered_json> states;
  for (std::string line; std::getline(text, line);) states.push_back(nlohmann::ordered_json::parse(line));
  return states;
}

TEST_F(CliTrack, PrintsEachAgentAsItMoves) {
  const Outcome outcome = holdfast_program({"track", write("small.pyfg", small_pyfg()), "--lag", "2"});
  EXPECT_EQ(outcome.code, kDone) << outcome.err;
  const auto states = states_of(outcome.out);
  ASSERT_EQ(states.size(), 8u);  // A1 … A4 and B1 … B4; where both start is given
  double time = 0;
  for (const auto& state : states) {
    EXPECT_GE(state["t"].get<double>(), time);
    time = state["t"].get<double>();
    EXPECT_NEAR(state["p"][0].get<double>(), time, 0.3) << state.dump();
    EXPECT_NEAR(state["p"][1].get<double>(), state["agent"] == "A" ? 0 : 3, 0.3) << state.dump();
  }
  EXPECT_THAT(outcome.err, HasSubstr("23 measurements"));
  EXPECT_THAT(outcome.err, HasSubstr("RMSE to the vertices"));
}

TEST_F(CliTrack, TheWholeHistoryIsThatOfALagWithoutEnd) {
  const std::string file = write("small.pyfg", small_pyfg());
  const Outcome whole = holdfast_program({"track", file, "--lag", "0"});
  EXPECT_EQ(whole.code, kDone) << whole.err;
  const auto states = states_of(whole.out), expected = states_of(holdfast_program({"track", file, "--lag", "1e9"}).out);
  ASSERT_EQ(states.size(), expected.size());
  ASSERT_FALSE(states.empty());
  for (std::size_t i = 0; i < states.size(); ++i) {
    EXPECT_EQ(states[i]["key"], expected[i]["key"]);
    for (int k = 0; k < 2; ++k) EXPECT_NEAR(states[i]["p"][k].get<double>(), expected[i]["p"][k].get<double>(), 1e-3) << states[i].dump();
  }
}

TEST_F(CliTrack, SaysWhatTheLastWindowLeavesOpen) {
  std::ostringstream text;
  for (const char* agent : {"A", "B"})  // nothing ties one to the other
    for (int k = 0; k < 3; ++k) {
      text << "VERTEX_SE2 " << k << ' ' << agent << k << ' ' << k << " 0 0\n";
      if (k > 0) text << "EDGE_SE2 " << k - 1 << ' ' << agent << k - 1 << ' ' << agent << k << " 1 0 0 0.0025 0 0 0.0025 0 0.0001\n";
    }
  const std::string file = write("apart.pyfg", text.str());
  const Outcome outcome = holdfast_program({"track", file, "--lag", "5"});
  EXPECT_EQ(outcome.code, kDone) << outcome.err;
  EXPECT_THAT(outcome.err, HasSubstr("share no factor with the other 1 parts of the graph"));
}

// Names of other robots of one kind: r1234:0 is written r5299989643264 in files of other programs.
TEST_F(CliTrack, TellsRobotsOfOneKindApart) {
  const std::string noise = " 0.01 0 0 0.01 0 0.01\n";
  const Outcome outcome = holdfast_program({"track",
                                            write("robots.pyfg",
                                                  "VERTEX_SE2 0 r1:0 0 0 0\nVERTEX_SE2 0 r5299989643264 0 3 0\n"
                                                  "VERTEX_SE2 1 r1:1 1 0 0\nVERTEX_SE2 1 r1234:1 2 3 0\n"
                                                  "EDGE_SE2 1 r1:0 r1:1 1 0 0" +
                                                      noise + "EDGE_SE2 1 r5299989643264 r1234:1 2 0 0" + noise),
                                            "--lag", "2"});
  EXPECT_EQ(outcome.code, kDone) << outcome.err;
  std::map<std::string, double> x;
  for (const auto& state : states_of(outcome.out))
    if (state["t"] == 1) x[state["agent"].get<std::string>() + " " + state["key"].get<std::string>()] = state["p"][0].get<double>();
  ASSERT_EQ(x.size(), 2u) << outcome.out;
  EXPECT_NEAR(x["r1 r1:1"], 1, 1e-9);
  EXPECT_NEAR(x["r1234 r1234:1"], 2, 1e-9);
}

TEST_F(CliTrack, AStreamGivesWhatTheFileGives) {
  const std::string file = write("small.pyfg", small_pyfg());
  const Outcome of_file = holdfast_program({"track", file, "--lag", "2", "--format", "tum"});
  std::string sorted;  // the file in the order of time
  std::istringstream lines(small_pyfg());
  std::vector<std::string> edges[5];
  for (std::string line; std::getline(lines, line);) {
    if (line[0] == 'V')
      sorted += line + "\n";
    else
      edges[line[line.find(' ') + 1] - '0'].push_back(line);
  }
  for (const auto& at_one_time : edges)
    for (const std::string& line : at_one_time) sorted += line + "\n";
  const Outcome of_stream = piped(sorted, {"--lag", "2", "--format", "tum"});
  EXPECT_EQ(of_stream.out, of_file.out);
  EXPECT_EQ(of_stream.code, kDone) << of_stream.err;
}

TEST_F(CliTrack, ReportsAMalformedLineAndGoesOnOrNot) {
  const std::string text = small_pyfg() + "EDGE_RANGE 4 A4 B4 three 0.01\nEDGE_RANGE 4 A4 Z9 1 0.01\n";
  const Outcome lenient = piped(text, {});
  EXPECT_EQ(lenient.code, kDone);
  EXPECT_THAT(lenient.err, HasSubstr("line 35"));
  EXPECT_THAT(lenient.err, HasSubstr("1 malformed lines"));
  EXPECT_THAT(lenient.err, HasSubstr("1 measurements refused"));
  const Outcome strict = piped(text, {"--strict"});
  EXPECT_EQ(strict.code, kFailed);
  EXPECT_THAT(strict.err, HasSubstr("line 35"));
}

/// A robot on a circle among four beacons, a range in every step; `lie` changes the range of this step to this beacon.
template <class Lie>
std::string ring_of_beacons(int steps, unsigned seed, const Lie& lie) {
  std::mt19937_64 rng(seed);
  std::normal_distribution<double> normal;
  const double beacons[4][2] = {{-15, -10}, {15, -12}, {14, 13}, {-13, 14}};
  const double turn = 0.02, radius = 0.2 / turn;
  const auto pose = [&](int k) { return std::array<double, 3>{radius * std::sin(turn * k), -radius * std::cos(turn * k), turn * k}; };
  std::ostringstream text;
  text.precision(12);
  for (int l = 0; l < 4; ++l) text << "VERTEX_XY L" << l << ' ' << beacons[l][0] << ' ' << beacons[l][1] << '\n';
  for (int k = 0; k < steps; ++k)
    text << "VERTEX_SE2 " << 0.2 * k << " A" << k << ' ' << pose(k)[0] << ' ' << pose(k)[1] << ' ' << pose(k)[2] << '\n';
  for (int k = 1; k < steps; ++k) {
    const double half = 0.5 * turn, chord = 2 * radius * std::sin(half);
    text << "EDGE_SE2 " << 0.2 * k << " A" << k - 1 << " A" << k << ' ' << chord * std::cos(half) + 0.01 * normal(rng) << ' '
         << chord * std::sin(half) + 0.01 * normal(rng) << ' ' << turn + 0.002 * normal(rng) << " 1e-4 0 0 1e-4 0 4e-6\n";
    const int l = k % 4;
    const double distance = std::hypot(pose(k)[0] - beacons[l][0], pose(k)[1] - beacons[l][1]) + 0.1 * normal(rng);
    text << "EDGE_RANGE " << 0.2 * k << " A" << k << " L" << l << ' ' << lie(k, l, distance, rng) << " 0.01\n";
  }
  return text.str();
}

double worst_error(const std::string& out, int from, int to) {
  double worst = 0;
  for (const auto& state : states_of(out)) {
    const int k = std::stoi(state["key"].get<std::string>().substr(1));
    if (k < from || k >= to) continue;
    worst = std::max(
        worst, std::hypot(state["p"][0].get<double>() - 10 * std::sin(0.02 * k), state["p"][1].get<double>() + 10 * std::cos(0.02 * k)));
  }
  return worst;
}

// Nothing but outliers for five, fifteen and thirty seconds, at random or all too long by the same: the odometry holds, the window says so,
// and is back two seconds later.
TEST_F(CliTrack, HoldsThroughABurstOfOutliersAndIsBack) {
  for (const int steps : {25, 75, 150})
    for (const bool biased : {false, true})
      for (unsigned seed = 1; seed <= 4; ++seed) {
        const int begin = 200, end = begin + steps;
        const std::string text = ring_of_beacons(end + 150, seed, [&](int k, int, double distance, std::mt19937_64& rng) {
          if (k < begin || k >= end) return distance;
          return biased ? distance + 12 : 100 * std::generate_canonical<double, 53>(rng);
        });
        const Outcome outcome = holdfast_program({"track", write("burst.pyfg", text), "--lag", "20", "--landmark-sigma", "0.1"});
        EXPECT_EQ(outcome.code, kDone) << outcome.err;
        const std::string of =
            std::to_string(steps) + (biased ? " biased" : " random") + " steps, seed " + std::to_string(seed) + '\n' + outcome.err;
        EXPECT_THAT(outcome.err, HasSubstr("most of what A measures does not fit")) << of;
        EXPECT_THAT(outcome.err, HasSubstr("what A measures fits again")) << of;
        EXPECT_LT(worst_error(outcome.out, begin, end), 2.0) << of;
        EXPECT_LT(worst_error(outcome.out, end + 10, end + 150), 0.5) << of;
      }
}

TEST_F(CliTrack, NamesABeaconThatLies) {
  int named = 0, accused = 0;
  for (unsigned seed = 1; seed <= 20; ++seed) {
    const std::string text = ring_of_beacons(
        300, seed, [&](int k, int l, double distance, std::mt19937_64&) { return l == 2 && k > 100 ? distance + 8 : distance; });
    const Outcome outcome = holdfast_program({"track", write("liar.pyfg", text), "--lag", "20", "--landmark-sigma", "0.1"});
    named += outcome.err.find("most of what L2 measures does not fit") != std::string::npos;
    for (const char* other : {"of what A ", "of what L0 ", "of what L1 ", "of what L3 "})
      accused += outcome.err.find(other) != std::string::npos;
    EXPECT_LT(worst_error(outcome.out, 120, 300), 0.6) << outcome.err;
  }
  EXPECT_GE(named, 19);
  EXPECT_EQ(accused, 0);
}

TEST(Sought, APointIsFoundWhereItsMirrorImageIsRuledOut) {
  const Vector<3> place(30, 20, 0);
  std::vector<Sight> sights;
  const auto see = [&](double x, double y) { sights.push_back({sights.size(), {x, y, 0}, (place - Vector<3>(x, y, 0)).norm(), 0.1}); };
  for (int k = 0; k < 40; ++k) see(k, 0);
  EXPECT_FALSE(located(sights, std::nullopt, 2)) << "from a straight path (30, -20) is as good";
  EXPECT_LT((located(sights, Guess{{25, 30, 0}, 10}, 2).value_or(Vector<3>::Zero()) - place).norm(), 0.1) << "the guess is on one side";
  for (int k = 0; k < 4; ++k) see(40, k);
  EXPECT_LT((located(sights, std::nullopt, 2).value_or(Vector<3>::Zero()) - place).norm(), 0.01);
  sights[3].distance += 50;  // one gross outlier
  EXPECT_LT((located(sights, std::nullopt, 2).value_or(Vector<3>::Zero()) - place).norm(), 0.05);
  EXPECT_FALSE(located({sights.begin(), sights.begin() + 2}, std::nullopt, 2));
}

TEST(Sought, InSpaceItTakesAPathThatIsNotFlat) {
  const Vector<3> place(5, 6, 7);
  std::vector<Sight> sights;
  const auto see = [&](const Vector<3>& from) { sights.push_back({sights.size(), from, (place - from).norm(), 0.05}); };
  for (int k = 0; k < 40; ++k) see({4 * std::cos(0.3 * k), 4 * std::sin(0.3 * k), 0});
  EXPECT_FALSE(located(sights, std::nullopt, 3)) << "from a flat path (5, 6, -7) is as good";
  for (int k = 0; k < 10; ++k) see({0, 0, 0.3 * k});
  EXPECT_LT((located(sights, std::nullopt, 3).value_or(Vector<3>::Zero()) - place).norm(), 0.01);
}

// Beacons of which the file says little (100 m) or nothing: they are found, and the path is as good as with them but for how the map lies.
TEST_F(CliTrack, FindsBeaconsOfWhichNothingIsKnown) {
  for (const bool has_vertices : {true, false})
    for (unsigned seed = 1; seed <= 4; ++seed) {
      std::string text = ring_of_beacons(400, seed, [](int, int, double distance, std::mt19937_64&) { return distance; });
      if (!has_vertices) text = std::regex_replace(text, std::regex("VERTEX_XY [^\n]*\n"), "");
      const Outcome outcome = holdfast_program(
          {"track", write("unknown.pyfg", text), "--lag", "20", "--landmark-sigma", "100", "--seed", std::to_string(seed)});
      EXPECT_EQ(outcome.code, kDone) << outcome.err;
      for (const char* beacon : {"L0 is found by", "L1 is found by", "L2 is found by", "L3 is found by"})
        EXPECT_THAT(outcome.err, HasSubstr(beacon)) << has_vertices << seed;
      EXPECT_LT(worst_error(outcome.out, 100, 400), 1.5) << outcome.err;
    }
}

TEST_F(CliTrack, ResumesWhileItLooksForABeacon) {
  const std::string text = ring_of_beacons(200, 1, [](int, int, double distance, std::mt19937_64&) { return distance; });
  const Outcome whole = piped(text, {"--save", at("whole"), "--landmark-sigma", "100"});
  const std::size_t found = whole.err.find("is found by");
  ASSERT_NE(found, std::string::npos) << whole.err;
  for (const char* stop : {"EDGE_RANGE 1 ", "EDGE_RANGE 2 ", "EDGE_RANGE 6 "}) {
    std::filesystem::remove(at("part"));
    const std::size_t end = text.find('\n', text.find(stop)) + 1;
    const Outcome first = ended_by_a_signal(text.substr(0, end), {"--save", at("part"), "--landmark-sigma", "100"});
    const Outcome second = piped(text, {"--save", at("part"), "--resume", "--landmark-sigma", "100"});
    EXPECT_EQ(first.out + second.out, whole.out) << stop;
    EXPECT_EQ(text_of(at("part")), text_of(at("whole"))) << stop;
  }
}

TEST_F(CliTrack, ResumesInTheMiddleOfABurst) {
  const std::string text = ring_of_beacons(400, 1, [&](int k, int, double distance, std::mt19937_64& rng) {
    return k < 200 || k >= 260 ? distance : 100 * std::generate_canonical<double, 53>(rng);
  });
  const Outcome whole = piped(text, {"--save", at("whole")});
  const std::size_t end = text.find('\n', text.find("EDGE_RANGE 46 ")) + 1;  // k = 230
  const Outcome first = ended_by_a_signal(text.substr(0, end), {"--save", at("part")});
  EXPECT_THAT(first.err, HasSubstr("most of what A measures"));
  const Outcome second = piped(text, {"--save", at("part"), "--resume"});
  EXPECT_EQ(first.out + second.out, whole.out);
  EXPECT_EQ(text_of(at("part")), text_of(at("whole")));
}

TEST_F(CliTrack, ResumesAfterTheLastLineTaken) {
  const std::string text = small_pyfg();
  const Outcome whole = piped(text, {"--save", at("whole")});
  for (const double part : {0.4, 0.7, 0.9}) {
    std::filesystem::remove(at("part"));
    const std::size_t end = text.find('\n', static_cast<std::size_t>(part * static_cast<double>(text.size()))) + 1;
    std::istringstream in(text.substr(0, end));
    // Ended by a signal at the end of what has come so far: saved, and not finished.
    struct Ending : std::stringbuf {
      using std::stringbuf::stringbuf;
      int_type underflow() override {
        const int_type next = std::stringbuf::underflow();
        if (next == traits_type::eof()) std::raise(SIGTERM);
        return next;
      }
    } ending(text.substr(0, end));
    std::streambuf* const before = std::cin.rdbuf(&ending);
    std::cin.clear();
    const Outcome first = holdfast_program({"track", "-", "--save", at("part")});
    std::cin.rdbuf(before);
    EXPECT_THAT(first.err, HasSubstr("ended by a signal"));
    EXPECT_EQ(first.code, kDone);
    const Outcome second = piped(text, {"--save", at("part"), "--resume"});
    EXPECT_THAT(second.err, HasSubstr("resumed"));
    EXPECT_EQ(first.out + second.out, whole.out);
    EXPECT_EQ(text_of(at("part")), text_of(at("whole")));
  }
}

// The power goes at any moment; scripts/kill_track does it from outside, on real data and as often as wanted.
TEST_F(CliTrack, KilledTwentyTimesEndsAsIfNothingHadHappened) {
  const std::string file = write("long.pyfg", small_pyfg(400));
  const auto track = [&](const std::string& save) {
    return holdfast_program({"track", file, "--lag", "20", "--save", at(save), "--save-every", "3", "--resume"});
  };
  const auto begin = std::chrono::steady_clock::now();
  ASSERT_EQ(track("whole").code, kDone);
  const std::chrono::duration<double, std::micro> alone = std::chrono::steady_clock::now() - begin;
  std::mt19937_64 rng(1);
  int in_between = 0;
  for (int kill = 0; kill < 20; ++kill) {
    faults::kill_while([&] { track("part"); },
                       std::chrono::microseconds(static_cast<long>(alone.count() / 6 * std::generate_canonical<double, 53>(rng))));
    const std::string saved = text_of(at("part"));
    if (saved == text_of(at("whole")))
      std::filesystem::remove(at("part"));  // it came to its end: once more
    else
      in_between += saved.empty() ? 0 : 1;
  }
  EXPECT_GT(in_between, 5) << "most kills came before the first save, or after the last one";
  EXPECT_EQ(track("part").code, kDone);
  EXPECT_EQ(text_of(at("part")), text_of(at("whole")));
}

TEST_F(CliTrack, SaysWhatIsWrongWithTheCommandLine) {
  const std::string file = write("small.pyfg", small_pyfg());
  EXPECT_EQ(holdfast_program({"track", file, "--lag", "-1"}).code, kUsage);
  EXPECT_EQ(holdfast_program({"track", file, "--loss", "nobody"}).code, kUsage);
  EXPECT_EQ(holdfast_program({"track", file, "--resume"}).code, kUsage);
  EXPECT_EQ(holdfast_program({"track", at("absent")}).code, kFailed);
  EXPECT_EQ(holdfast_program({"track", file, "--save", at("no/where")}).code, kFailed);
  const Outcome foreign = holdfast_program({"track", file, "--save", file, "--resume"});
  EXPECT_EQ(foreign.code, kFailed);
  EXPECT_THAT(foreign.err, HasSubstr("no file of a holdfast window"));
  EXPECT_EQ(text_of(file), small_pyfg());  // and it is still there
}

}  // namespace
}  // namespace holdfast::program
