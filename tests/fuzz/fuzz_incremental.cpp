// An Incremental that lives through anything against a batch solution from scratch (tests/incremental_life.hpp).
#include <unistd.h>

#include "bytes.hpp"
#include "tests/incremental_life.hpp"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace holdfast;
  fuzz::Bytes bytes(data, size);
  static const std::string path = "/dev/shm/holdfast_fuzz_incremental_" + std::to_string(::getpid());
  testing::IncrementalLife life(
      bytes, [](const std::string& text) { fuzz::require(false, text.c_str()); }, bytes.below(8) == 0 ? path : std::string());
  life.live(120);
  return 0;
}
