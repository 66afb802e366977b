#include <fstream>
#include <holdfast/common/machine.hpp>
#include <thread>
#if __has_include("holdfast_commit.hpp")  // made anew by every build: common/commit.cmake
#include "holdfast_commit.hpp"
#else
#define HOLDFAST_COMMIT "unknown"
#endif

namespace holdfast::common {

nlohmann::ordered_json machine() {
  std::string cpu = "unknown";
  std::ifstream info("/proc/cpuinfo");
  for (std::string line; std::getline(info, line);) {
    const std::size_t colon = line.find(": ");
    if (line.rfind("model name", 0) != 0 || colon == std::string::npos) continue;
    cpu = line.substr(colon + 2);
    break;
  }
  return {{"cpu", cpu}, {"cores", std::thread::hardware_concurrency()}};
}

std::string commit() { return HOLDFAST_COMMIT; }

}  // namespace holdfast::common
