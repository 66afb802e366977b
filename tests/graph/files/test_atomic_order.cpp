// A file is flushed to the disk before it gets its name, and its name is flushed after: a loss of power finds the old file or the new one.
#include <fcntl.h>
#include <gtest/gtest.h>
#include <sys/stat.h>
#include <sys/syscall.h>
#include <unistd.h>

#include <cerrno>
#include <cstdio>
#include <filesystem>
#include <holdfast/graph/files/atomic.hpp>
#include <string>
#include <vector>

#include "tests/graph/files/helpers.hpp"

namespace {
std::vector<std::string> events;
bool files_cannot_be_flushed = false;
}  // namespace

// These stand in for those of the C library, note that they were called, and do the same.
extern "C" {
int fsync(int fd) {
  struct stat status {};
  ::fstat(fd, &status);
  events.push_back(S_ISDIR(status.st_mode) ? "flush the directory" : "flush " + std::to_string(status.st_size) + " bytes");
  if (files_cannot_be_flushed && S_ISREG(status.st_mode)) return errno = EIO, -1;
  return static_cast<int>(::syscall(SYS_fsync, fd));
}
int rename(const char* from, const char* to) noexcept {
  events.push_back("rename");
  return static_cast<int>(::syscall(SYS_renameat2, AT_FDCWD, from, AT_FDCWD, to, 0));
}
}

namespace holdfast {
namespace {

TEST(AtomicWrite, FlushesTheFileThenNamesItThenFlushesTheDirectory) {
  const std::string path = (std::filesystem::temp_directory_path() / ("holdfast_order_" + std::to_string(::getpid()))).string();
  for (const std::string content : {"first", "second one"}) {
    events.clear();
    atomic_write(path, content);
    const std::string bytes = std::to_string(content.size());
    EXPECT_EQ(events, (std::vector<std::string>{"flush " + bytes + " bytes", "rename", "flush the directory"}));
    EXPECT_EQ(std::filesystem::file_size(path), content.size());
  }
  std::filesystem::remove(path);
}

TEST(AtomicWrite, KeepsTheOldFileWhereTheNewOneCannotBeFlushed) {
  const testing_io::TemporaryDirectory directory;
  atomic_write(directory / "a", "old");
  files_cannot_be_flushed = true;
  testing_io::expect_message<BadFile>([&] { atomic_write(directory / "a", "new text"); }, {"Input/output error", "as it was"});
  files_cannot_be_flushed = false;
  EXPECT_EQ(testing_io::content(directory / "a"), "old");
  EXPECT_EQ(directory.files(), 1u);
}

}  // namespace
}  // namespace holdfast
