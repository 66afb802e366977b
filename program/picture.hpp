// A drawing as one HTML file of its own: an SVG picture with layers to show and hide, nothing fetched, no script.
#pragma once

#include <holdfast/common/drawing.hpp>
#include <string>

namespace holdfast::program {

/// `caption`: one line under the title. A picture of nothing has no ways and says so.
std::string picture_page(const common::Drawing& drawing, const std::string& title, const std::string& caption);

}  // namespace holdfast::program
