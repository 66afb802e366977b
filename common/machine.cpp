#include <Eigen/Core>
#include <fstream>
#include <holdfast/common/machine.hpp>
#include <thread>
#if __has_include("holdfast_commit.hpp")  // made anew by every build: common/commit.cmake
#include "holdfast_commit.hpp"
#else
#define HOLDFAST_COMMIT "unknown"
#endif

namespace holdfast::common {

namespace {

constexpr const char* kCompiler =
#ifdef __clang__
    "clang " __clang_version__;
#else
    "gcc " __VERSION__;
#endif

}  // namespace

nlohmann::ordered_json machine() {
  std::string cpu = "unknown";
  std::ifstream info("/proc/cpuinfo");
  for (std::string line; std::getline(info, line);) {
    const std::size_t colon = line.find(": ");
    if (line.rfind("model name", 0) != 0 || colon == std::string::npos) continue;
    cpu = line.substr(colon + 2);
    break;
  }
  const std::string eigen =
      std::to_string(EIGEN_WORLD_VERSION) + "." + std::to_string(EIGEN_MAJOR_VERSION) + "." + std::to_string(EIGEN_MINOR_VERSION);
  return {{"cpu", cpu},
          {"cores", std::thread::hardware_concurrency()},
          {"compiler", kCompiler},
          {"holdfast", HOLDFAST_VERSION},
          {"eigen", eigen}};
}

std::string commit() { return HOLDFAST_COMMIT; }

}  // namespace holdfast::common
