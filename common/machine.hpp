// Where and of what a number was measured: every line of results carries both.
#pragma once

#include <nlohmann/json.hpp>
#include <string>

namespace holdfast::common {

/// {"cpu": "AMD EPYC …", "cores": 2, "compiler": "gcc 12.2.0", "holdfast": "0.2.0", "eigen": "3.4.0"}
nlohmann::ordered_json machine();

/// The commit this program was built from, with "-dirty" where files were changed, or "unknown".
std::string commit();

}  // namespace holdfast::common
