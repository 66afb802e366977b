#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <atomic>
#include <cerrno>
#include <cstdio>
#include <holdfast/graph/error.hpp>
#include <holdfast/graph/io_atomic.hpp>
#include <system_error>
#include <utility>

namespace holdfast {
namespace {

/// The file under its temporary name; removed again unless it was renamed.
class Temporary {
 public:
  explicit Temporary(const std::string& target) : target_(target) {
    static std::atomic<unsigned> counter{0};
    do {
      name_ = target + ".tmp" + std::to_string(::getpid()) + "_" + std::to_string(counter++);
      fd_ = ::open(name_.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0666);  // 0666: the user's umask decides
    } while (fd_ < 0 && errno == EEXIST);
    if (fd_ < 0) cannot_write();
  }
  Temporary(const Temporary&) = delete;
  Temporary& operator=(const Temporary&) = delete;
  ~Temporary() {
    if (fd_ >= 0) ::close(fd_);
    if (!renamed_) ::unlink(name_.c_str());
  }

  void write(std::string_view content) {
    while (!content.empty()) {
      const ssize_t written = ::write(fd_, content.data(), content.size());
      if (written < 0 && errno == EINTR) continue;
      if (written < 0) cannot_write();
      content.remove_prefix(static_cast<std::size_t>(written));
    }
    if (::fsync(fd_) != 0) cannot_write();
    if (::close(std::exchange(fd_, -1)) != 0) cannot_write();
  }
  void rename() {
    if (std::rename(name_.c_str(), target_.c_str()) != 0) cannot_write();
    renamed_ = true;
  }
  void take_mode(mode_t mode) {
    if (::fchmod(fd_, mode & 07777) != 0) cannot_write();
  }

 private:
  [[noreturn]] void cannot_write() const {
    const int error = errno;
    fail<BadFile>("cannot write ", target_, ": ", std::generic_category().message(error), "; the file is as it was");
  }

  std::string target_;
  std::string name_;
  int fd_ = -1;
  bool renamed_ = false;
};

}  // namespace

void atomic_write(const std::string& path, std::string_view content) {
  struct stat status {};
  const bool exists = ::stat(path.c_str(), &status) == 0;
  if (exists && !S_ISREG(status.st_mode))
    fail<BadFile>("cannot write ", path, ": it is ", S_ISDIR(status.st_mode) ? "a directory" : "no regular file", "; name a file");
  Temporary file(path);
  if (exists) file.take_mode(status.st_mode);
  file.write(content);
  file.rename();
}

}  // namespace holdfast
