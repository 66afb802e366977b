// What every command has in common: --json, --quiet, examples, exit codes, completion.
#include <gmock/gmock.h>

#include <cstdlib>
#include <holdfast/common/coloured.hpp>

#include "tests/program/helpers.hpp"

namespace holdfast::program {
namespace {

using ::testing::HasSubstr;
using ::testing::Not;
using Json = nlohmann::ordered_json;

const std::vector<std::string> kCommands{"solve", "track",   "check", "convert", "simulate",  "network",
                                         "bench", "compare", "plot",  "report",  "completion"};

class Output : public InDirectory {};

TEST_F(Output, TheHelpOfEveryCommandHasExamplesWithItsName) {
  const Outcome whole = holdfast_program({"--help"});
  EXPECT_EQ(whole.code, kDone);
  EXPECT_THAT(whole.out, HasSubstr("Exit codes:\n  0  done"));
  for (const std::string& command : kCommands) {
    EXPECT_THAT(whole.out, HasSubstr("\n  " + command)) << command;
    const Outcome help = holdfast_program({command, "--help"});
    EXPECT_EQ(help.code, kDone);
    const std::size_t examples = help.out.find("Examples:");
    ASSERT_NE(examples, std::string::npos) << command;
    EXPECT_NE(help.out.find("holdfast " + command, examples), std::string::npos) << command;
    if (command != "completion") {
      EXPECT_THAT(help.out, HasSubstr("--json FILE")) << command;
    }
  }
}

TEST_F(Output, ANumberOutOfRangeIsSaidInOneShortLine) {
  const Outcome outcome = holdfast_program({"network", "--agents", "0"});
  EXPECT_EQ(outcome.code, kUsage);
  EXPECT_THAT(outcome.err, HasSubstr("not in range"));
  EXPECT_LT(outcome.err.find('\n'), 120u) << outcome.err;
}

TEST_F(Output, ACommandThatIsNoneIsNamed) {
  for (const std::vector<std::string>& call : std::vector<std::vector<std::string>>{{"slove", "intel.g2o"}, {"-q", "slove"}}) {
    const Outcome outcome = holdfast_program(call);
    EXPECT_EQ(outcome.code, kUsage);
    EXPECT_THAT(outcome.err, ::testing::StartsWith("holdfast: there is no command 'slove'; there are: solve "));
  }
}

TEST_F(Output, JsonOnTheStandardOutputStandsAlone) {
  const std::string file = write("two.pyfg", small_pyfg());
  const std::vector<std::vector<std::string>> calls{{"check", file},
                                                    {"solve", "--backend", "irls", file},
                                                    {"convert", file, at("two.jrl")},
                                                    {"simulate", "ring", at("ring.g2o"), "--steps", "20"},
                                                    {"track", file}};
  for (std::vector<std::string> call : calls) {
    const std::string command = call[0];
    call.insert(call.end(), {"--json", "-"});
    const Outcome outcome = holdfast_program(call);
    EXPECT_EQ(outcome.code, kDone) << command << outcome.err;
    ASSERT_EQ(std::count(outcome.out.begin(), outcome.out.end(), '\n'), 1) << command << outcome.out;
    EXPECT_TRUE(Json::parse(outcome.out).is_object()) << command;

    call.back() = at(command + ".json");
    EXPECT_EQ(holdfast_program(call).code, kDone);
    Json from_file = Json::parse(text_of(at(command + ".json"))), from_out = Json::parse(outcome.out);
    for (Json* json : {&from_file, &from_out}) {  // what differs from run to run
      std::vector<std::string> seconds;
      for (const auto& [key, value] : json->items())
        if (key.rfind("seconds", 0) == 0) seconds.push_back(key);
      for (const std::string& key : seconds) json->erase(key);
    }
    EXPECT_EQ(from_file, from_out) << command;
  }
}

TEST_F(Output, CheckSaysItsFindingsInJson) {
  const std::string file = write("alone.g2o", small_g2o() + "VERTEX_SE2 9 0 0 0\n");
  const Outcome outcome = holdfast_program({"check", file, "--json", "-"});
  const Json json = Json::parse(outcome.out);
  EXPECT_EQ(json["variables"], 5);
  EXPECT_EQ(json["factors"], 4);
  EXPECT_EQ(json["solvable"], outcome.code == kDone);
  bool named = false;
  for (const Json& finding : json["findings"])
    named = named || (finding["kind"] == "unconstrained variable" && finding["text"].get<std::string>().find("x9") != std::string::npos);
  EXPECT_TRUE(named) << outcome.out;
}

TEST_F(Output, BenchGivesTheLinesOfItsFiles) {
  const Outcome outcome =
      holdfast_program({"bench", "scenarios", "--backend", "irls", "--repetitions", "1", "--out", at("out"), "--json", "-"});
  EXPECT_EQ(outcome.code, kDone) << outcome.err;
  EXPECT_EQ(outcome.out, text_of(at("out/scenarios.jsonl")));
}

TEST_F(Output, QuietKeepsErrorsWarningsAndTheCode) {
  const std::string file = write("two.pyfg", small_pyfg());
  for (const std::vector<std::string>& call : std::vector<std::vector<std::string>>{
           {"--quiet", "check", file}, {"solve", "-q", "--backend", "irls", file}, {"convert", "--quiet", file, at("a.jrl")}}) {
    const Outcome outcome = holdfast_program(call);
    EXPECT_EQ(outcome.code, kDone);
    EXPECT_EQ(outcome.out, "");
  }
  const Outcome failed = holdfast_program({"solve", "--quiet", at("absent.g2o")});
  EXPECT_EQ(failed.code, kFailed);
  EXPECT_THAT(failed.err, HasSubstr("absent.g2o"));
  const Outcome tracked = holdfast_program({"track", "--quiet", file});
  EXPECT_NE(tracked.out, "");  // states are what was asked for
  EXPECT_THAT(tracked.err, Not(HasSubstr("steps")));
}

TEST_F(Output, AJsonFileThatCannotBeIsSaidBeforeAnyWork) {
  const std::string file = write("two.pyfg", small_pyfg());
  for (const std::string& json : {at("no/where.json"), at(".")})
    for (const std::string command : {"check", "solve", "track"})
      EXPECT_EQ(holdfast_program({command, file, "--json", json}).code, kUsage) << command << json;
}

class Completion : public InDirectory {
 protected:
  /// What bash offers for the last of these words.
  std::vector<std::string> offers(const std::vector<std::string>& words) {
    const std::string script = write("holdfast.bash", holdfast_program({"completion", "bash"}).out);
    std::string line;
    for (const std::string& word : words) line += " '" + word + "'";
    const std::string call =
        write("call.bash", "source '" + script + "'\nCOMP_WORDS=(" + line + ")\nCOMP_CWORD=" + std::to_string(words.size() - 1) +
                               "\n_holdfast\nprintf '%s\\n' \"${COMPREPLY[@]}\"\n");
    EXPECT_EQ(std::system(("bash '" + call + "' > '" + at("offers") + "'").c_str()), 0);
    std::istringstream text(text_of(at("offers")));
    std::vector<std::string> found;
    for (std::string word; text >> word;) found.push_back(word);
    return found;
  }
};

TEST_F(Completion, BashOffersCommandsOptionsValuesAndFiles) {
  EXPECT_THAT(offers({"holdfast", ""}), ::testing::IsSupersetOf(kCommands));
  EXPECT_THAT(offers({"holdfast", "si"}), ::testing::ElementsAre("simulate"));
  EXPECT_THAT(offers({"holdfast", "solve", "--sta"}), ::testing::ElementsAre("--start"));
  EXPECT_THAT(offers({"holdfast", "-q", "solve", "--start", ""}), ::testing::ElementsAre("file", "odometry", "chordal", "convex"));
  EXPECT_THAT(offers({"holdfast", "simulate", "wa"}), ::testing::ElementsAre("walk2d", "walk3d"));
  EXPECT_THAT(offers({"holdfast", "track", "--start"}), ::testing::IsEmpty());
  EXPECT_THAT(offers({"holdfast", "solve", "--gnc", "--sta"}), ::testing::ElementsAre("--start"));  // a flag takes no value
  const std::string file = write("some_data.g2o", "");
  EXPECT_THAT(offers({"holdfast", "check", file.substr(0, file.size() - 6)}), ::testing::ElementsAre(file));
}

TEST_F(Completion, EveryOptionOfEveryCommandIsInEveryScript) {
  for (const std::string shell : {"bash", "zsh", "fish"}) {
    const Outcome script = holdfast_program({"completion", shell});
    ASSERT_EQ(script.code, kDone);
    for (const std::string& command : kCommands) {
      std::istringstream help(holdfast_program({command, "--help"}).out);
      for (std::string word; help >> word;) {
        if (word.rfind("--", 0) != 0 || word.size() < 4) continue;
        std::string name = word.substr(2, word.find_first_not_of("abcdefghijklmnopqrstuvwxyz-0123456789", 2) - 2);
        EXPECT_THAT(script.out, HasSubstr(shell == "fish" ? "-l " + name : "--" + name)) << shell << " " << command;
      }
    }
    const bool there = std::system(("command -v " + shell + " > /dev/null").c_str()) == 0;
    if (there) {
      EXPECT_EQ(std::system((shell + " -n '" + write("script." + shell, script.out) + "'").c_str()), 0) << shell;
    }
  }
  EXPECT_EQ(holdfast_program({"completion", "csh"}).code, kUsage);
}

TEST(Coloured, TheNameAndTheKindOfALine) {
  std::ostringstream plain;
  common::Coloured colours(plain.rdbuf());
  std::ostream out(&colours);
  out << "holdfast: warning: cold\nholdfast: lost\n== suite: what\nholdfast is a word\n\n==\nhold" << std::flush;
  EXPECT_EQ(plain.str(),
            "\033[1mholdfast: \033[33mwarning:\033[0m cold\n\033[1mholdfast:\033[0m lost\n\033[1m== suite: what\033[0m\n"
            "holdfast is a word\n\n==\nhold");
}

TEST(Coloured, WhereNobodyLooksNothingIs) {
  int ends[2];
  ASSERT_EQ(::pipe(ends), 0);
  EXPECT_FALSE(common::wants_colour(ends[1]));
  ::close(ends[0]);
  ::close(ends[1]);
}

}  // namespace
}  // namespace holdfast::program
