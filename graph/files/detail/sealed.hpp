// A file of the library's own: a magic line, a version, and a checksum around the bytes that matter. A torn or changed file is refused.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>

namespace holdfast::io {

struct FileKind {
  std::string_view magic;  ///< the first bytes
  std::uint32_t version;
  std::string_view what;  ///< "a holdfast window"
  std::string_view cure;  ///< of a file of another version
};

/// The file: magic, version, size of the payload, payload, and a checksum (FNV-1a, 64 bits) of all before.
std::string sealed(const FileKind& kind, std::string_view payload);
/// Its payload. Throws BadFile saying what is wrong: it cannot be read, is of another kind or version, torn, or changed.
std::string read_sealed(const FileKind& kind, const std::string& path);

}  // namespace holdfast::io
