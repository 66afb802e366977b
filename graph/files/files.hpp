// Files in and out.
//
//   Dataset data = read_dataset("plaza2.pyfg");                 // PyFG, g2o or TORO: by its content, never by its name
//   write_g2o("out.g2o", data);
//
// Numbers are those of the C locale whatever the program's locale is. Line ends LF or CRLF, columns parted by any blanks. Every line is
// read, kept, or named: blank lines and lines that begin with '#' are kept in Dataset::comments, lines with unknown tags in
// Dataset::unknown (show unknown_report() to the user).
// Whatever is wrong is a BadFile that names the file, the line number, the text and what was expected (LineParser lists it);
// then nothing is loaded.
#pragma once

#include <holdfast/graph/error.hpp>
#include <holdfast/graph/files/dataset.hpp>
#include <iosfwd>
#include <string>

namespace holdfast {

/// The dialect is that of the first line that has one; a later line of another dialect is an error. A file without any is an error.
/// A g2o file that has a vertex of a pose and one of a landmark with the same id numbers them apart, as GTSAM does: landmark 0 is l0.
Dataset read_dataset(const std::string& path, const ReadOptions& options = {});
Dataset read_dataset(const std::string& path, Format format, const ReadOptions& options = {});
inline Dataset read_pyfg(const std::string& path) { return read_dataset(path, Format::PyFG); }
inline Dataset read_g2o(const std::string& path) { return read_dataset(path, Format::G2o); }
inline Dataset read_toro(const std::string& path) { return read_dataset(path, Format::Toro); }

/// The same from a stream, up to its end; `name` stands for the file in messages.
Dataset parse_dataset(std::istream& in, const std::string& name, const ReadOptions& options = {});
Dataset parse_dataset(std::istream& in, const std::string& name, Format format, const ReadOptions& options = {});
inline Dataset parse_pyfg(std::istream& in, const std::string& name) { return parse_dataset(in, name, Format::PyFG); }
inline Dataset parse_g2o(std::istream& in, const std::string& name) { return parse_dataset(in, name, Format::G2o); }
inline Dataset parse_toro(std::istream& in, const std::string& name) { return parse_dataset(in, name, Format::Toro); }

/// The text of a file. In the format it was read from every line stands where it stood, comments and unknown lines, too; what was added
/// comes before the first edge (vertices, fixed variables) or at the end (edges). In another format: comments, sensor offsets, vertices,
/// fixed variables, edges, each in the order of the dataset. Every number reads back bit by bit. Noise of another format is converted
/// (dataset.hpp). BadFile naming the record where the format cannot hold it: a range between poses in g2o, a time stamp in g2o or TORO, a
/// pose or edge without one in PyFG, a key whose kind is no letter in PyFG, a key without an integer id (Key::id()) in g2o or TORO, an
/// unknown line of another format, a number that is not finite.
std::string to_text(const Dataset& dataset, Format format);
inline std::string to_pyfg(const Dataset& dataset) { return to_text(dataset, Format::PyFG); }
inline std::string to_g2o(const Dataset& dataset) { return to_text(dataset, Format::G2o); }
inline std::string to_toro(const Dataset& dataset) { return to_text(dataset, Format::Toro); }

/// The same into a file, whole or not at all (graph/files/atomic.hpp).
void write_dataset(const std::string& path, const Dataset& dataset, Format format);
inline void write_pyfg(const std::string& path, const Dataset& dataset) { write_dataset(path, dataset, Format::PyFG); }
inline void write_g2o(const std::string& path, const Dataset& dataset) { write_dataset(path, dataset, Format::G2o); }
inline void write_toro(const std::string& path, const Dataset& dataset) { write_dataset(path, dataset, Format::Toro); }

}  // namespace holdfast
