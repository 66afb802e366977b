// What tests of faults share: a disk that is full, one that cannot be written, a program that is killed.
#pragma once

#include <gtest/gtest.h>
#include <sys/mount.h>
#include <sys/wait.h>
#include <unistd.h>

#include <chrono>
#include <csignal>
#include <filesystem>
#include <fstream>
#include <string>
#include <thread>

namespace holdfast::faults {

/// A file system of its own of a few pages, gone after the test; only root may mount one.
class SmallDisk {
 public:
  explicit SmallDisk(int kilobytes) {
    std::string pattern = (std::filesystem::temp_directory_path() / "holdfast_disk_XXXXXX").string();
    path_ = ::mkdtemp(pattern.data());
    mounted_ = ::mount("tmpfs", path_.c_str(), "tmpfs", 0, ("size=" + std::to_string(kilobytes) + "k").c_str()) == 0;
  }
  SmallDisk(const SmallDisk&) = delete;
  SmallDisk& operator=(const SmallDisk&) = delete;
  ~SmallDisk() {
    if (mounted_) ::umount2(path_.c_str(), MNT_DETACH);
    std::filesystem::remove_all(path_);
  }

  bool mounted() const { return mounted_; }
  void make_read_only() const { ASSERT_EQ(::mount("tmpfs", path_.c_str(), "tmpfs", MS_REMOUNT | MS_RDONLY, ""), 0); }
  std::string operator/(const std::string& name) const { return (path_ / name).string(); }
  std::size_t files() const {
    return static_cast<std::size_t>(
        std::distance(std::filesystem::recursive_directory_iterator(path_), std::filesystem::recursive_directory_iterator()));
  }

 private:
  std::filesystem::path path_;
  bool mounted_ = false;
};

/// Runs `work` again and again in a process of its own, and kills that after a while.
template <class Work>
void kill_while(const Work& work, std::chrono::microseconds after) {
  const pid_t child = ::fork();
  ASSERT_GE(child, 0);
  if (child == 0)
    for (;;) work();
  std::this_thread::sleep_for(after);
  ::kill(child, SIGKILL);
  int status = 0;
  ASSERT_EQ(::waitpid(child, &status, 0), child);
  ASSERT_TRUE(WIFSIGNALED(status)) << "the program ended by itself";
}

}  // namespace holdfast::faults

#define HOLDFAST_NEED_MOUNT(disk) \
  if (!(disk).mounted()) GTEST_SKIP() << "a small disk cannot be mounted; run as root"
