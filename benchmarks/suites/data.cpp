#include <array>
#include <cstdlib>
#include <filesystem>
#include <holdfast/benchmarks/suites/suites.hpp>

namespace holdfast::bench {
namespace fs = std::filesystem;

std::string data_directory() {
  if (const char* chosen = std::getenv("HOLDFAST_DATA"); chosen != nullptr && *chosen != 0) return chosen;
  for (const fs::path& place : {fs::path(HOLDFAST_SOURCE_DIR) / ".." / "shared" / "data", fs::path("..") / "shared" / "data"})
    if (fs::is_directory(place)) return place.lexically_normal().string();
  return "";
}

std::vector<Case> data_cases(unsigned seed) {
  std::vector<Case> cases;
  for (const char* name : {"plaza2", "single_drone", "tiers", "mrclam5a", "goats_14"})
    for (const char* loss : {"squared", "huber:2"})
      cases.push_back(data_case("range/" + std::string(name) + ".pyfg", loss, "odometry", seed));
  for (const char* name : {"intel", "MIT", "M3500", "sphere2500", "smallGrid3D", "tinyGrid3D"})
    cases.push_back(data_case("pose_graph/" + std::string(name) + ".g2o", "squared", "file", seed));
#ifdef HOLDFAST_WITH_MRPT
  for (const char* loss : {"squared", "huber:2"})  // Debian's mrpt-common; the beacons are found without a guess
    cases.push_back(data_case("/usr/share/mrpt/datasets/RO-SLAM_demo.rawlog", loss, "file", seed));
#endif
  cases.push_back(data_case("/usr/share/mrpt/datasets/graph_2d_circle_50nodes.graph", "squared", "file", seed));
  return cases;
}

}  // namespace holdfast::bench
