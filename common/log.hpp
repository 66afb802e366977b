// The program's log: glog on stderr where it is found, else nothing. Results and errors do not go here: they are the program's output.
#pragma once

#include <string>

namespace holdfast::common {

/// Once a process; later calls only set how much is shown: everything (Ceres' warnings, too), or nothing.
void start_log(bool verbose);
void log(const std::string& message);

}  // namespace holdfast::common
