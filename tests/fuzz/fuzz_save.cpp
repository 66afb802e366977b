// A window's file with bytes changed, cut off and added, under a checksum that fits again: restore() refuses it with BadFile and leaves the
// window as it was, or takes it, and then what it took is written and read back.
#include <unistd.h>

#include <algorithm>
#include <holdfast/factors/huber_measurement.hpp>
#include <holdfast/factors/white_acceleration.hpp>
#include <holdfast/graph/files/atomic.hpp>
#include <holdfast/graph/files/internal/text.hpp>
#include <holdfast/solvers/window/window.hpp>

#include "bytes.hpp"

namespace holdfast::fuzz {
namespace {

Window window_of(char letter) {
  WindowOptions options;
  options.lag = 1;
  Window window(options);
  window.add_agent(letter, WhiteAcceleration<Motion2>::exact(0.25, 1, Matrix<4, 4>::Identity()), 0.25);
  return window;
}

void walk(Window& window, char letter) {
  window.add_state(Key(letter, 0), 0, Motion2(1, 0, 2, 0));
  for (int i = 0; i < 12; ++i) {
    const Key key = window.at(letter, 0.25 * i);
    window.add(HuberMeasurement<Motion2>::of_position(Vector<2>(-i, 1), Vector<2>(0, 0), Matrix<2, 2>::Identity()), {key}, Huber{1});
    window.step(0.25 * i);
  }
}

/// FNV-1a, 64 bits, of all but the last 8 bytes, into those.
void seal(std::string& file) {
  std::uint64_t hash = 0xcbf29ce484222325ull;
  for (std::size_t i = 0; i + 8 < file.size(); ++i) hash = (hash ^ static_cast<unsigned char>(file[i])) * 0x100000001b3ull;
  std::memcpy(file.data() + file.size() - 8, &hash, 8);
}

constexpr std::size_t kHead = 28;  // magic, version, size of the payload

void change(std::string& file, Bytes& bytes) {
  for (int changes = 1 + bytes.below(8); changes > 0; --changes) {
    const std::size_t payload = file.size() - kHead - 8;
    const std::size_t at = kHead + (bytes.byte() << 8 | bytes.byte()) % std::max<std::size_t>(payload, 1);
    switch (bytes.below(4)) {
      case 0:
      case 1:
        file[at] = static_cast<char>(bytes.byte());
        break;
      case 2:
        file.erase(at, std::min<std::size_t>(bytes.byte(), file.size() - 8 - at));
        break;
      case 3:
        file.insert(at, std::string(bytes.byte() % 16, static_cast<char>(bytes.byte())));
    }
  }
  const std::uint64_t size = file.size() - kHead - 8;
  std::memcpy(file.data() + 20, &size, sizeof size);
  seal(file);
}

}  // namespace
}  // namespace holdfast::fuzz

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace holdfast;
  using namespace holdfast::fuzz;
  static const std::string path = "/dev/shm/holdfast_fuzz_save_" + std::to_string(::getpid());
  static const std::string good = [] {
    Window window = window_of('A');
    walk(window, 'A');
    window.save(path, "a note");
    return io::read_file(path);
  }();
  Bytes bytes(data, size);
  std::string file = good;
  change(file, bytes);
  atomic_write(path, file);

  Window window = window_of('A');
  walk(window, 'A');
  const std::vector<Key> states = window.states('A');
  const Vector<4> newest = window.newest<Motion2>('A').value;
  try {
    window.restore(path);
  } catch (const BadFile&) {
    require(window.states('A') == states && window.newest<Motion2>('A').value == newest, "a refused file left a trace");
    return 0;
  }
  window.save(path);
  window_of('A').restore(path);
  return 0;
}
