// What fuzz targets share: bytes read as numbers, choices and text; a check that tells the fuzzer.
#pragma once

#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <string>
#include <string_view>

namespace holdfast::fuzz {

/// A claim about the library: where it is wrong, the fuzzer keeps the input.
inline void require(bool claim, const char* what, const std::string& details = {}) {
  if (claim) return;
  std::fprintf(stderr, "wrong: %s %s\n", what, details.c_str());
  std::abort();
}

/// The input, taken from its front; zeros behind its end.
class Bytes {
 public:
  Bytes(const std::uint8_t* data, std::size_t size) : data_(data), size_(size) {}

  bool empty() const { return size_ == 0; }
  std::uint8_t byte() {
    if (size_ == 0) return 0;
    --size_;
    return *data_++;
  }
  /// 0 … n − 1.
  int below(int n) { return byte() % n; }
  /// Of [−16, 16), in eighths: numbers of a well-behaved problem.
  double small() { return (byte() - 128) / 8.0; }
  /// Any double there is.
  double any() {
    std::uint64_t bits = 0;
    for (int i = 0; i < 8; ++i) bits = bits << 8 | byte();
    double value;
    std::memcpy(&value, &bits, sizeof value);
    return value;
  }
  std::string_view rest() const { return {reinterpret_cast<const char*>(data_), size_}; }

 private:
  const std::uint8_t* data_;
  std::size_t size_;
};

}  // namespace holdfast::fuzz
