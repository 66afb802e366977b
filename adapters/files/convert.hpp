// A dataset as another format can hold it.
//
//   const Conversion conversion = converted(read_dataset("a.pyfg"), Format::G2o);
//   for (const std::string& note : conversion.notes) std::cerr << note << '\n';   // what was changed or left out
//   write_g2o("a.g2o", conversion.dataset);
#pragma once

#include <holdfast/graph/files/dataset.hpp>

namespace holdfast {

struct Conversion {
  Dataset dataset;
  std::vector<std::string> notes;  ///< one line each
};

/// To PyFG: poses and edges without a time get their step as time, variables without a vertex their place in vertex_start, and a FIX
/// line becomes a prior at the vertex with a sigma of 1e-4 m and rad. To g2o and TORO: time stamps are left out; to TORO FIX lines, too.
/// Lines whose tags nobody knows are left out. Whatever else the format cannot hold its writer refuses by name.
Conversion converted(const Dataset& dataset, Format format);

/// The format that a file's name asks for: .g2o, .pyfg, .graph and .toro (TORO); none for another ending.
std::optional<Format> format_of_name(const std::string& path);

}  // namespace holdfast
