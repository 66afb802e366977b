#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cctype>
#include <cerrno>
#include <charconv>
#include <cmath>
#include <holdfast/graph/files/internal/text.hpp>
#include <holdfast/graph/internal/digits.hpp>
#include <system_error>

namespace holdfast::io {
namespace {

bool is_space(char c) { return c == ' ' || c == '\t' || c == '\r' || c == '\n' || c == '\v' || c == '\f'; }
bool is_digit(char c) { return c >= '0' && c <= '9'; }
bool is_letter(char c) { return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z'); }

[[noreturn]] void cannot_read(const std::string& path, const std::string& why) {
  fail<BadFile>("cannot read ", path, ": ", why, "; expected a readable text file");
}
[[noreturn]] void cannot_read(const std::string& path, int error) { cannot_read(path, std::generic_category().message(error)); }

struct Descriptor {
  int fd;
  ~Descriptor() {
    if (fd >= 0) ::close(fd);
  }
};

}  // namespace

std::string read_file(const std::string& path) {
  const Descriptor file{::open(path.c_str(), O_RDONLY | O_CLOEXEC)};
  struct stat status {};
  if (file.fd < 0 || ::fstat(file.fd, &status) != 0) cannot_read(path, errno);
  if (S_ISDIR(status.st_mode)) cannot_read(path, "it is a directory");
  std::string content(static_cast<std::size_t>(status.st_size) + 1, '\0');  // the size is a hint: pipes have none
  std::size_t size = 0;
  for (;;) {
    if (size == content.size()) content.resize(2 * content.size() + 4096);
    const ssize_t got = ::read(file.fd, content.data() + size, content.size() - size);
    if (got < 0 && errno == EINTR) continue;
    if (got < 0) cannot_read(path, errno);
    if (got == 0) break;
    size += static_cast<std::size_t>(got);
  }
  content.resize(size);
  if (size == 0) cannot_read(path, "it is empty (0 bytes)");
  return content;
}

std::string excerpt(std::string_view text) {
  constexpr std::size_t kLongest = 120;
  while (!text.empty() && is_space(text.back())) text.remove_suffix(1);
  std::string shown(text.substr(0, kLongest));
  for (char& c : shown)
    if (static_cast<unsigned char>(c) < 0x20 || c == 0x7f) c = c == '\t' ? ' ' : '?';
  return text.size() > kLongest ? shown + "..." : shown;
}

std::string to_text(double value) { return std::string(Digits(value)); }

void Line::assign(std::size_t number, std::string_view text) {
  number_ = number;
  text_ = text;
  columns_.clear();
  x_ids_.clear();
  reading.offsets.clear();
  reading.repair.reset();
  reading.no_noise = false;
  cursor_ = 1;
  for (std::size_t i = 0; i < text.size();) {
    if (is_space(text[i])) {
      ++i;
      continue;
    }
    std::size_t end = i;
    while (end < text.size() && !is_space(text[end])) ++end;
    columns_.push_back(text.substr(i, end - i));
    i = end;
  }
}

double Line::next_number(const char* what) {
  const std::string_view text = column(cursor_);
  std::string_view digits = text;
  if (digits.size() > 1 && digits[0] == '+' && digits[1] != '-') digits.remove_prefix(1);  // from_chars knows no plus
  double value = 0;
  const auto [end, problem] = std::from_chars(digits.data(), digits.data() + digits.size(), value);
  if (problem == std::errc::result_out_of_range)
    error("column ", std::to_string(cursor_ + 1), " '", excerpt(text), "' is outside the range of a double; expected ", what);
  if (problem != std::errc{} || end != digits.data() + digits.size())
    error("column ", std::to_string(cursor_ + 1), " '", excerpt(text), "' is not a number; expected ", what);
  if (!std::isfinite(value)) error("column ", std::to_string(cursor_ + 1), " '", excerpt(text), "' is not finite; expected ", what);
  ++cursor_;
  return value;
}

Key Line::next_name() {
  const std::string_view text = column(cursor_);
  if (!is_name(text))
    error("column ", std::to_string(cursor_ + 1), " '", excerpt(text), "' is not a name; expected a letter and an index, such as A11");
  ++cursor_;
  try {
    return Key::parse(text);
  } catch (const BadKey& problem) {
    error(problem.what());
  }
}

Key Line::next_id() {
  const std::uint64_t id = next_index("an id");
  const Key key = Key::from_id(id);
  if (key.agent() == 'x') x_ids_.push_back({key, id == key.bits()});
  return key;
}

Key Line::next_landmark_id() {
  if (!reading.landmarks_apart) return next_id();
  const std::uint64_t id = next_index("an id");
  return id >> 32 == 0 ? Key('l', id) : Key::from_bits(id);
}

std::uint64_t Line::next_index(const char* what) {
  const std::string_view text = column(cursor_);
  std::uint64_t value = 0;
  const auto [end, problem] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (problem != std::errc{} || end != text.data() + text.size())
    error("column ", std::to_string(cursor_ + 1), " '", excerpt(text), "' is not ", what, "; expected an integer from 0 to 2^64 - 1");
  ++cursor_;
  return value;
}

bool is_name(std::string_view text) {
  if (text.size() < 2 || !is_letter(text[0])) return false;
  const std::string_view rest = text.substr(1);
  const std::size_t colon = rest.find(':');
  const auto digits = [](std::string_view part) { return !part.empty() && is_digit(part[0]) && is_integer(part); };
  return colon == std::string_view::npos ? digits(rest) : digits(rest.substr(0, colon)) && digits(rest.substr(colon + 1));
}

bool is_integer(std::string_view text) {
  if (!text.empty() && (text[0] == '-' || text[0] == '+')) text.remove_prefix(1);
  for (char c : text)
    if (!is_digit(c)) return false;
  return !text.empty();
}

Text& Text::word(std::string_view text) {
  if (text_.size() > line_start_) text_ += ' ';
  text_ += text;
  return *this;
}

Text& Text::number(double value) {
  if (!std::isfinite(value))
    fail<BadFile>("cannot write '", excerpt(std::string_view(text_).substr(line_start_)), " ", to_text(value),
                  "': the number is not finite");
  return word(Digits(value));
}

Text& Text::id(Key key) {
  const bool is_symbol = dataset_ != nullptr && !dataset_->symbols.empty() && dataset_->symbols.count(key) != 0;
  if (dataset_ != nullptr && dataset_->landmarks_apart && key.agent() == 'l') return word(std::to_string(key.step()));
  return word(std::to_string(is_symbol ? key.bits() : key.id()));
}

void Text::end_line() {
  text_ += '\n';
  line_start_ = text_.size();
}

}  // namespace holdfast::io
