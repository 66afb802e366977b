// Files when things go wrong: whole or not there, whatever happens to the disk or to the program, and an error that says which and why.
#include <unistd.h>

#include <holdfast/graph/files/atomic.hpp>
#include <holdfast/graph/files/tum.hpp>
#include <random>

#include "tests/faults.hpp"
#include "tests/graph/files/helpers.hpp"

namespace holdfast {
namespace {

using faults::kill_while;
using faults::SmallDisk;
using testing_io::content;
using testing_io::expect_message;
using testing_io::TemporaryDirectory;

/// Larger than the disks below.
Dataset long_walk() {
  Dataset dataset;
  for (unsigned i = 0; i < 5000; ++i) dataset.vertices.push_back({Key('A', i), Pose2(0.1 * i, 0, 0), {}, 0.5 * i});
  return dataset;
}
Values values_of(const Dataset& dataset) {
  Values values;
  for (const Vertex& vertex : dataset.vertices) values.insert(vertex.key, std::get<Pose2>(vertex.value));
  return values;
}

/// Root may write everywhere; for the life of this object the test is nobody in particular.
class NotRoot {
 public:
  NotRoot() : user_(::geteuid()) {
    if (user_ == 0) {
      EXPECT_EQ(::seteuid(65534), 0);
    }
  }
  ~NotRoot() { EXPECT_EQ(::seteuid(user_), 0); }

 private:
  uid_t user_;
};

TEST(FullDisk, LeavesTheOldFileAndNothingElse) {
  const SmallDisk disk(64);
  HOLDFAST_NEED_MOUNT(disk);
  atomic_write(disk / "graph.pyfg", "old");
  const Dataset walk = long_walk();
  expect_message<BadFile>([&] { write_pyfg(disk / "graph.pyfg", walk); },
                          {"cannot write", "graph.pyfg", "No space left on device", "as it was"});
  EXPECT_EQ(content(disk / "graph.pyfg"), "old");
  EXPECT_EQ(disk.files(), 1u);
}

TEST(FullDisk, LeavesNoTrajectoryHalfWritten) {
  const SmallDisk disk(64);
  HOLDFAST_NEED_MOUNT(disk);
  expect_message<BadFile>([&] { write_tum_directory(disk / "run", values_of(long_walk()), {}); },
                          {"cannot write", "run/A.tum", "No space left on device"});
  EXPECT_EQ(disk.files(), 1u) << "more than the empty directory";
}

TEST(ReadOnlyDisk, IsNamed) {
  const SmallDisk disk(64);
  HOLDFAST_NEED_MOUNT(disk);
  atomic_write(disk / "a", "old");
  disk.make_read_only();
  expect_message<BadFile>([&] { atomic_write(disk / "a", "new"); }, {"cannot write", disk / "a", "Read-only file system", "as it was"});
  expect_message<BadFile>([&] { write_tum_directory(disk / "run", {}, {}); }, {"cannot make the directory", disk / "run", "Read-only"});
  EXPECT_EQ(content(disk / "a"), "old");
}

TEST(ReadOnlyDirectory, IsNamed) {
  using std::filesystem::perms;
  const TemporaryDirectory directory;
  constexpr perms everybody_reads = perms::owner_read | perms::owner_exec | perms::others_read | perms::others_exec;
  std::filesystem::permissions(directory / "", everybody_reads);
  {
    const NotRoot nobody;
    expect_message<BadFile>([&] { atomic_write(directory / "a", "new"); }, {"cannot write", directory / "a", "Permission denied"});
  }
  EXPECT_EQ(directory.files(), 0u);
  std::filesystem::permissions(directory / "", perms::owner_all);
}

TEST(SymbolicLink, StaysAndItsFileIsWritten) {
  namespace fs = std::filesystem;
  const TemporaryDirectory directory;
  fs::create_directory(directory / "disk");
  fs::create_symlink("disk/state", directory / "near");
  fs::create_symlink(directory / "near", directory / "far");
  for (const std::string text : {"the first", "the next"}) {  // there is no disk/state yet; there is one
    atomic_write(directory / "far", text);
    EXPECT_EQ(content(directory / "disk/state"), text);
    EXPECT_TRUE(fs::is_symlink(directory / "near"));
    EXPECT_TRUE(fs::is_symlink(directory / "far"));
  }
  fs::create_symlink("ring", directory / "ring");
  expect_message<BadFile>([&] { atomic_write(directory / "ring", "lost"); }, {"cannot write", "ring of symbolic links"});
  EXPECT_TRUE(fs::is_symlink(directory / "ring"));
  EXPECT_EQ(std::distance(fs::directory_iterator(directory / "disk"), fs::directory_iterator()), 1);
}

TEST(Killed, WhileWritingLeavesOneOfTheTwoTextsWhole) {
  const TemporaryDirectory directory;
  const std::string path = directory / "values", one(300000, 'a'), two(200000, 'b');
  std::mt19937_64 rng(1);
  for (int i = 0; i < 60; ++i) {
    kill_while(
        [&] {
          atomic_write(path, one);
          atomic_write(path, two);
        },
        std::chrono::microseconds(500 + rng() % 20000));
    if (::testing::Test::HasFatalFailure()) return;
    // Between its name and its last name a file may be killed, but then it is whole.
    for (const auto& entry : std::filesystem::directory_iterator(directory / "")) {
      const std::string text = content(entry.path().string());
      ASSERT_TRUE(text == one || text == two) << entry.path() << " holds " << text.size() << " bytes";
    }
  }
  EXPECT_TRUE(std::filesystem::exists(path)) << "never written in all this time";
  // A busy disk may stretch the moment between the two names; a file that had its name from the start would be left by nearly every kill.
  EXPECT_LE(directory.files(), 30u) << "what killed programs left behind";
}

}  // namespace
}  // namespace holdfast
