#include <gmock/gmock.h>

#include <csignal>
#include <iostream>
#include <map>
#include <random>
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
