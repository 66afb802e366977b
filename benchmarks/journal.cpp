#include <fcntl.h>
#include <unistd.h>

#include <cerrno>
#include <filesystem>
#include <fstream>
#include <holdfast/benchmarks/journal.hpp>
#include <holdfast/graph/error.hpp>
#include <holdfast/graph/files/atomic.hpp>
#include <system_error>

namespace holdfast::bench {
namespace fs = std::filesystem;
namespace {

[[noreturn]] void cannot_write(const std::string& path, int error, const char* consequence = "") {
  fail<BadFile>("cannot write ", path, ": ", std::generic_category().message(error), consequence, "; give another directory with --out");
}

/// Closes what it opened, whatever happens.
struct Descriptor {
  int fd;
  ~Descriptor() {
    if (fd >= 0) ::close(fd);
  }
};

}  // namespace

Journal::Journal(std::string path) : path_(std::move(path)) {
  if (!fs::exists(path_)) return;
  if (!fs::is_regular_file(path_)) fail<BadFile>("cannot write ", path_, ": it is no regular file; give another directory with --out");
  std::ifstream file(path_, std::ios::binary);
  if (!file) fail<BadFile>("cannot read ", path_, "; give another directory with --out");
  std::string kept;
  bool torn = false;
  for (std::string line; std::getline(file, line);) {
    Json json = Json::parse(line, nullptr, false);
    if (file.eof() || !json.is_object()) {  // eof: the line has no end
      torn = true;
      continue;
    }
    kept += line + '\n';
    lines_.push_back(std::move(json));
  }
  if (torn) atomic_write(path_, kept);
}

void Journal::append(const std::vector<Json>& lines) {
  if (lines.empty()) return;
  const Descriptor file{::open(path_.c_str(), O_WRONLY | O_CREAT | O_APPEND | O_CLOEXEC, 0666)};
  if (file.fd < 0) cannot_write(path_, errno);
  const off_t before = ::lseek(file.fd, 0, SEEK_END);
  const auto take_back = [&](int error) {  // a torn line would spoil the next one
    const bool whole = ::ftruncate(file.fd, before) == 0;
    cannot_write(path_, error, whole ? "" : " (its last line is torn)");
  };
  std::string text;
  for (const Json& line : lines) text += to_line(line);
  for (std::size_t written = 0; written < text.size();) {
    const ssize_t now = ::write(file.fd, text.data() + written, text.size() - written);
    if (now < 0 && errno == EINTR) continue;
    if (now < 0) take_back(errno);
    written += static_cast<std::size_t>(now);
  }
  if (::fsync(file.fd) != 0) take_back(errno);
  lines_.insert(lines_.end(), lines.begin(), lines.end());
}

}  // namespace holdfast::bench
