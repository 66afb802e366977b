// A PyFG file as a stream: line by line, in the order of time.
#pragma once

#include <holdfast/graph/files/dataset.hpp>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace holdfast::program {

/// Runs one line of the file format through a parser of its own: streams never end, so nothing of a line is kept.
Dataset parse_line(std::uint64_t number, std::string_view text, const std::string& file);
/// The lines of a PyFG file in the order of time: the vertices first, then every edge at the time of its latest state.
std::vector<std::pair<std::uint64_t, std::string_view>> in_time_order(std::string_view text, const std::string& file);

}  // namespace holdfast::program
