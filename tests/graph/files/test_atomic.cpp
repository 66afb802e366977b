// A file survives a loss of power: what atomic_write asks of the system, in its order.
#include <gmock/gmock.h>
#include <sys/stat.h>
#include <sys/syscall.h>
#include <unistd.h>

#include <holdfast/graph/files/atomic.hpp>

#include "tests/graph/files/helpers.hpp"

namespace {

std::vector<std::string> calls;
bool file_cannot_be_flushed = false;

}  // namespace

// These stand before those of the C library, for this program alone.
extern "C" int fsync(int fd) {
  struct stat status {};
  ::fstat(fd, &status);
  if (S_ISDIR(status.st_mode)) {
    calls.push_back("flush the directory");
  } else {
    calls.push_back("flush " + std::to_string(status.st_size) + " bytes");
    if (file_cannot_be_flushed) return errno = EIO, -1;
  }
  return static_cast<int>(::syscall(SYS_fsync, fd));
}
extern "C" int rename(const char* from, const char* to) noexcept {
  calls.push_back("rename");
  return static_cast<int>(::syscall(SYS_renameat2, AT_FDCWD, from, AT_FDCWD, to, 0));
}

namespace holdfast {
namespace {

using ::testing::ElementsAre;

class AtomicWrite : public ::testing::Test {
 protected:
  void SetUp() override { calls.clear(), file_cannot_be_flushed = false; }
  testing_io::TemporaryDirectory directory_;
};

TEST_F(AtomicWrite, FlushesTheWholeFileBeforeItGetsItsNameAndTheDirectoryAfter) {
  atomic_write(directory_ / "a", std::string(30000, 'x'));
  EXPECT_THAT(calls, ElementsAre("flush 30000 bytes", "rename", "flush the directory"));
}

TEST_F(AtomicWrite, KeepsTheOldFileWhereTheNewOneCannotBeFlushed) {
  atomic_write(directory_ / "a", "old");
  file_cannot_be_flushed = true;
  testing_io::expect_message<BadFile>([&] { atomic_write(directory_ / "a", "new text"); },
                                      {"cannot write", "Input/output error", "as it was"});
  EXPECT_EQ(testing_io::content(directory_ / "a"), "old");
  EXPECT_EQ(directory_.files(), 1u);
}

}  // namespace
}  // namespace holdfast
