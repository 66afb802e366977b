// Values and graphs for people: std::cout << values, << graph. Short: after some lines "… n more". The format may change; to read numbers
// back, write a file (graph/files/files.hpp). How a variable is printed: graph/variables/print.hpp.
#pragma once

#include <holdfast/graph/graph.hpp>

namespace holdfast {

/// "Values: 3 variables", then a line each in the order of the keys: "  A0  Pose2(1, 2, 0.5)".
std::ostream& operator<<(std::ostream& out, const Values& values);

/// "Graph: 2 factors on 3 variables, 1 fixed", then a line each: "  Range(A0, L0), loss huber:2, weight 0.5".
std::ostream& operator<<(std::ostream& out, const Graph& graph);

}  // namespace holdfast
