// Where the program writes: results to out, messages and the progress bar to err.
#pragma once

#include <ostream>

namespace holdfast::common {

struct Terminal {
  std::ostream& out;
  std::ostream& err;
  bool interactive;  ///< err is a terminal somebody looks at: a progress bar makes sense
};

}  // namespace holdfast::common
