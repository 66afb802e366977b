// A drawing of a small graph, in the DOT language:   holdfast::to_dot(graph) > graph.dot;   dot -Tsvg graph.dot -o graph.svg
//
// Variables are circles (fixed ones filled), factors boxes with lines to their variables. For graphs that a page can hold: some hundreds of
// factors.
#pragma once

#include <holdfast/graph/graph.hpp>
#include <string>

namespace holdfast {

std::string to_dot(const Graph& graph);

}  // namespace holdfast
