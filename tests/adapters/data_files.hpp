// The real files there are: those of HOLDFAST_DATA, or else ../shared/data, and mrpt-common's.
#pragma once

#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <string>
#include <vector>

namespace holdfast::testing {

inline constexpr const char* kNoFiles = "there are neither HOLDFAST_DATA, ../shared/data nor mrpt-common's /usr/share/mrpt/datasets";

/// Those of one of these extensions.
inline std::vector<std::string> data_files(const std::vector<std::string>& extensions = {".g2o", ".pyfg", ".graph"}) {
  const char* chosen = std::getenv("HOLDFAST_DATA");
  const std::string data = chosen != nullptr ? chosen : HOLDFAST_SOURCE_DIR "/../shared/data";
  std::vector<std::string> files;
  for (const std::string& folder : {data, std::string("/usr/share/mrpt/datasets")})
    if (std::filesystem::is_directory(folder))
      for (const auto& entry : std::filesystem::recursive_directory_iterator(folder))
        if (std::count(extensions.begin(), extensions.end(), entry.path().extension().string()) != 0)
          files.push_back(entry.path().string());
  return files;
}

}  // namespace holdfast::testing
