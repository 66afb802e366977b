#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <atomic>
#include <cerrno>
#include <cstdio>
#include <filesystem>
#include <holdfast/graph/error.hpp>
#include <holdfast/graph/files/atomic.hpp>
#include <system_error>
#include <utility>

namespace holdfast {
namespace {

std::string directory_of(const std::string& path) {
  const std::size_t slash = path.rfind('/');
  return slash == std::string::npos ? "." : path.substr(0, slash + 1);
}

/// The file itself where the path is a link to it, be it there or not: the link stays, and the file may lie on another disk.
std::string behind_links(const std::string& path) {
  namespace fs = std::filesystem;
  constexpr int kMostLinks = 40;  // as Linux has it
  std::error_code error;
  fs::path file = path;
  for (int links = 0; fs::is_symlink(fs::symlink_status(file, error)); ++links) {
    if (links == kMostLinks) fail<BadFile>("cannot write ", path, ": it is a ring of symbolic links; name a file");
    file = file.parent_path() / fs::read_symlink(file, error);
  }
  return file.string();
}

/// The file before it is there. It has no name at all until it is whole (O_TMPFILE), so that a program that is killed leaves nothing
/// behind; where the file system knows no nameless files it has a temporary name from the start. Removed again unless it was renamed.
class Temporary {
 public:
  explicit Temporary(const std::string& target) : target_(target) {
    if (::access("/proc/self/fd", X_OK) == 0)                                              // by which it gets its name
      fd_ = ::open(directory_of(target).c_str(), O_WRONLY | O_TMPFILE | O_CLOEXEC, 0666);  // 0666: the user's umask decides
    if (fd_ < 0) under_new_name([this] { return fd_ = ::open(name_.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0666); });
  }
  Temporary(const Temporary&) = delete;
  Temporary& operator=(const Temporary&) = delete;
  ~Temporary() {
    if (fd_ >= 0) ::close(fd_);
    if (!renamed_ && !name_.empty()) ::unlink(name_.c_str());
  }

  void write(std::string_view content) {
    while (!content.empty()) {
      const ssize_t written = ::write(fd_, content.data(), content.size());
      if (written < 0 && errno == EINTR) continue;
      if (written < 0) cannot_write();
      content.remove_prefix(static_cast<std::size_t>(written));
    }
    if (::fsync(fd_) != 0) cannot_write();
  }
  void rename() {
    if (name_.empty()) {
      const std::string nameless = "/proc/self/fd/" + std::to_string(fd_);
      under_new_name([&] { return ::linkat(AT_FDCWD, nameless.c_str(), AT_FDCWD, name_.c_str(), AT_SYMLINK_FOLLOW); });
    }
    if (::close(std::exchange(fd_, -1)) != 0) cannot_write();
    if (std::rename(name_.c_str(), target_.c_str()) != 0) cannot_write();
    renamed_ = true;
  }
  void take_mode(mode_t mode) {
    if (::fchmod(fd_, mode & 07777) != 0) cannot_write();
  }

 private:
  /// Runs `create` with a name_ that nobody has.
  template <class Create>
  void under_new_name(const Create& create) {
    static std::atomic<unsigned> counter{0};
    int result = 0;
    do {
      name_ = target_ + ".tmp" + std::to_string(::getpid()) + "_" + std::to_string(counter++);
      result = create();
    } while (result < 0 && errno == EEXIST);
    if (result >= 0) return;
    name_.clear();  // not ours
    cannot_write();
  }
  [[noreturn]] void cannot_write() const {
    const int error = errno;
    fail<BadFile>("cannot write ", target_, ": ", std::generic_category().message(error), "; the file is as it was");
  }

  std::string target_;
  std::string name_;
  int fd_ = -1;
  bool renamed_ = false;
};

/// The new name outlives a loss of power, too. Not every directory can be flushed; the file is whole either way.
void flush_directory(const std::string& path) {
  const int fd = ::open(path.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
  if (fd < 0) return;
  ::fsync(fd);
  ::close(fd);
}

}  // namespace

void atomic_write(const std::string& path, std::string_view content) {
  struct stat status {};
  const bool exists = ::stat(path.c_str(), &status) == 0;
  if (exists && !S_ISREG(status.st_mode))
    fail<BadFile>("cannot write ", path, ": it is ", S_ISDIR(status.st_mode) ? "a directory" : "no regular file", "; name a file");
  const std::string target = behind_links(path);
  Temporary file(target);
  if (exists) file.take_mode(status.st_mode);
  file.write(content);
  file.rename();
  flush_directory(directory_of(target));
}

}  // namespace holdfast
