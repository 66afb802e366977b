// The program on a disk that is full or cannot be written: an exit code, a message with file and cause, and no torn file.
#include <gmock/gmock.h>

#include <holdfast/benchmarks/journal.hpp>
#include <holdfast/graph/error.hpp>

#include "tests/faults.hpp"
#include "tests/program/helpers.hpp"

namespace holdfast::program {
namespace {

using faults::kill_while;
using faults::SmallDisk;
using ::testing::AllOf;
using ::testing::HasSubstr;

class Faults : public InDirectory {};

/// Takes all that is left of a disk but `spare` bytes.
void fill(const SmallDisk& disk, std::uintmax_t spare) {
  const std::uintmax_t left = std::filesystem::space(disk / "").available;
  std::ofstream(disk / "filler", std::ios::binary) << std::string(left - spare, 'x');
}

TEST_F(Faults, FullDiskUnderJson) {
  const SmallDisk disk(16);
  HOLDFAST_NEED_MOUNT(disk);
  fill(disk, 0);
  const Outcome outcome = holdfast_program({"solve", write("two.pyfg", small_pyfg()), "--backend", "irls", "--json", disk / "runs.jsonl"});
  EXPECT_EQ(outcome.code, kFailed);
  EXPECT_THAT(outcome.err, AllOf(HasSubstr("cannot write " + (disk / "runs.jsonl")), HasSubstr("No space left")));
  EXPECT_EQ(disk.files(), 1u);
}

TEST_F(Faults, FullDiskUnderTum) {
  const SmallDisk disk(16);
  HOLDFAST_NEED_MOUNT(disk);
  fill(disk, 0);
  const Outcome outcome = holdfast_program({"solve", write("two.pyfg", small_pyfg()), "--backend", "irls", "--tum", disk / "out"});
  EXPECT_EQ(outcome.code, kFailed);
  EXPECT_THAT(outcome.err, AllOf(HasSubstr(".tum"), HasSubstr("No space left")));
}

TEST_F(Faults, FullStandardOutput) {
  const std::string file = write("two.pyfg", small_pyfg());
  const char* arguments[] = {"holdfast", "solve", file.c_str(), "--backend", "irls"};
  std::ofstream out("/dev/full");
  std::ostringstream err;
  EXPECT_EQ(run(5, arguments, out, err), kFailed);
  EXPECT_THAT(err.str(), HasSubstr("standard output"));
}

TEST_F(Faults, ReadOnlyOutputDirectory) {
  const SmallDisk disk(16);
  HOLDFAST_NEED_MOUNT(disk);
  disk.make_read_only();
  const std::string file = write("two.pyfg", small_pyfg());
  for (const auto& arguments : {std::vector<std::string>{"solve", file, "--backend", "irls", "--json", disk / "runs.jsonl"},
                                {"solve", file, "--backend", "irls", "--tum", disk / "out"},
                                {"bench", "scenarios", "--backend", "irls", "--out", disk / "out"}}) {
    const Outcome outcome = holdfast_program(arguments);
    EXPECT_EQ(outcome.code, kFailed);
    EXPECT_THAT(outcome.err, AllOf(HasSubstr(disk / ""), HasSubstr("Read-only file system")));
  }
}

TEST(JournalFaults, FullDiskTakesTheTornLineBack) {
  const SmallDisk disk(16);
  HOLDFAST_NEED_MOUNT(disk);
  Journal journal(disk / "suite.jsonl");
  journal.append(Json{{"run", 1}});
  fill(disk, 0);
  try {
    journal.append(Json{{"run", std::string(8000, 'y')}});  // the first page's rest fits, the next page does not
    FAIL() << "the disk took it";
  } catch (const BadFile& error) {
    EXPECT_THAT(error.what(), AllOf(HasSubstr("suite.jsonl"), HasSubstr("No space left"), HasSubstr("--out")));
  }
  EXPECT_EQ(text_of(disk / "suite.jsonl"), "{\"run\":1}\n");
  std::filesystem::remove(disk / "filler");
  journal.append(Json{{"run", 2}});
  EXPECT_EQ(Journal(disk / "suite.jsonl").lines().size(), 2u);
}

TEST_F(Faults, KilledJournalKeepsEveryFinishedLine) {
  const std::string path = at("suite.jsonl");
  std::size_t before = 0;
  for (int i = 1; i <= 20; ++i) {
    kill_while(
        [&] {
          Journal journal(path);
          for (int n = 0;; ++n) journal.append(Json{{"run", n}, {"text", std::string(5000, 'z')}});
        },
        std::chrono::milliseconds(2 * i));
    const Journal journal(path);
    EXPECT_GE(journal.lines().size(), before) << "a line that was there is gone";
    before = journal.lines().size();
    for (const Json& line : lines_of(path)) EXPECT_EQ(line["text"].get<std::string>().size(), 5000u);
  }
  EXPECT_GT(before, 0u);
}

}  // namespace
}  // namespace holdfast::program
