// The name of a C++ type as its source writes it: "holdfast::Range<holdfast::Pose2, holdfast::Point2>".
#pragma once

#include <string>
#include <typeinfo>

namespace holdfast::detail {

std::string demangled(const std::type_info& type);

}  // namespace holdfast::detail
