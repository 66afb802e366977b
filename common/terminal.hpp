// Where the program writes: results to out, messages and the progress bar to err.
#pragma once

#include <ostream>

namespace holdfast::common {

struct Terminal {
  std::ostream& out;
  std::ostream& err;
  bool interactive;          ///< err is a terminal somebody looks at: a progress bar makes sense
  std::ostream& data = out;  ///< what another program reads (--json -, states of track); `out` goes nowhere where only that is wanted
};

}  // namespace holdfast::common
