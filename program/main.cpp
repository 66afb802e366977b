#include <unistd.h>

#include <holdfast/common/coloured.hpp>
#include <holdfast/program/program.hpp>
#include <iostream>
#include <optional>

namespace {

/// Colours a stream while it lives, where it goes to a terminal that wants them.
class Colour {
 public:
  Colour(std::ostream& stream, int descriptor) : stream_(stream), plain_(stream.rdbuf()) {
    if (holdfast::common::wants_colour(descriptor)) stream_.rdbuf(&coloured_.emplace(plain_));
  }
  ~Colour() {
    stream_.flush();
    stream_.rdbuf(plain_);
  }
  Colour(const Colour&) = delete;
  Colour& operator=(const Colour&) = delete;

 private:
  std::ostream& stream_;
  std::streambuf* plain_;
  std::optional<holdfast::common::Coloured> coloured_;
};

}  // namespace

int main(int argc, char** argv) {
  const Colour out(std::cout, STDOUT_FILENO), err(std::cerr, STDERR_FILENO);
  return holdfast::program::run(argc, argv, std::cout, std::cerr);
}
