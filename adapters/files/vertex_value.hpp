// A variable of Values as a vertex of a file holds it.
#pragma once

#include <holdfast/graph/files/dataset.hpp>
#include <holdfast/graph/values.hpp>

namespace holdfast {

/// Nothing where the variable is of a type that files do not have. Throws BadKey where there is no such key.
std::optional<VertexValue> vertex_value(const Values& values, Key key);

/// "Pose2", for messages. Throws BadKey.
const char* type_name(const Values& values, Key key);

}  // namespace holdfast
