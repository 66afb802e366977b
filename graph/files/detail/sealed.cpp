#include <holdfast/graph/error.hpp>
#include <holdfast/graph/files/binary.hpp>
#include <holdfast/graph/files/detail/sealed.hpp>
#include <holdfast/graph/files/internal/text.hpp>

namespace holdfast::io {
namespace {

/// FNV-1a, 64 bits.
std::uint64_t checksum(std::string_view bytes) {
  std::uint64_t hash = 0xcbf29ce484222325ull;
  for (const char c : bytes) hash = (hash ^ static_cast<unsigned char>(c)) * 0x100000001b3ull;
  return hash;
}

}  // namespace

std::string sealed(const FileKind& kind, std::string_view payload) {
  ByteWriter out;
  out.put(kind.magic.data(), kind.magic.size()).put(kind.version).put<std::uint64_t>(payload.size()).put(payload.data(), payload.size());
  const std::uint64_t sum = checksum(out.bytes());
  return out.put(sum).bytes();
}

std::string read_sealed(const FileKind& kind, const std::string& path) {
  const std::string content = read_file(path);
  const std::string_view file = content;
  const std::size_t head_size = kind.magic.size() + sizeof(std::uint32_t) + sizeof(std::uint64_t);
  if (file.substr(0, kind.magic.size()) != kind.magic) fail<BadFile>("it is no file of ", kind.what);
  ByteReader head(file.substr(kind.magic.size()));
  const auto version = head.get<std::uint32_t>();
  if (version != kind.version)
    fail<BadFile>("it is of version ", version, ", and this program reads version ", kind.version, "; ", kind.cure);
  const auto size = head.get<std::uint64_t>();
  if (file.size() < head_size + sizeof(std::uint64_t) || size != file.size() - head_size - sizeof(std::uint64_t))
    fail<BadFile>("it is torn: ", file.size(), " bytes, where its head says ", head_size + size + sizeof(std::uint64_t));
  ByteReader tail(file.substr(head_size + size));
  if (tail.get<std::uint64_t>() != checksum(file.substr(0, head_size + size)))
    fail<BadFile>("its checksum is wrong: bytes of it have changed");
  return content.substr(head_size, size);
}

}  // namespace holdfast::io
