// A graph and its values as bytes, in the order they have in memory: read back, every sum is taken in the same order, and has the same
// bits. For programs of the same variable and factor types (graph/detail/factor_type.hpp) on the same kind of machine; not for exchange.
#pragma once

#include <holdfast/graph/graph.hpp>
#include <string>
#include <string_view>
#include <type_traits>

namespace holdfast::io {

/// Appends numbers and texts to a string of bytes.
class ByteWriter {
 public:
  template <class T>
  ByteWriter& put(T number) {
    static_assert(std::is_arithmetic_v<T>);
    return put(&number, sizeof number);
  }
  ByteWriter& put(const void* from, std::size_t size) {
    bytes_.append(static_cast<const char*>(from), size);
    return *this;
  }
  ByteWriter& put(std::string_view text) { return put<std::uint64_t>(text.size()).put(text.data(), text.size()); }
  ByteWriter& put(Key key) { return put(key.bits()); }
  template <class T>
  ByteWriter& put(const std::vector<T>& list) {
    static_assert(std::is_arithmetic_v<T>);
    return put<std::uint64_t>(list.size()).put(list.data(), sizeof(T) * list.size());
  }
  const std::string& bytes() const { return bytes_; }

 private:
  std::string bytes_;
};

/// Takes them back. Throws BadFile where the bytes end.
class ByteReader {
 public:
  explicit ByteReader(std::string_view bytes) : bytes_(bytes) {}
  template <class T>
  T get() {
    if constexpr (std::is_same_v<T, bool>) return get_bool();
    T number;
    std::memcpy(&number, take(sizeof number), sizeof number);
    return number;
  }
  const char* take(std::size_t size);
  void require(std::size_t size) const;  ///< so many bytes are left
  bool get_bool();                       ///< a byte, 0 or 1
  std::string get_text();
  Key get_key();
  /// A number of things, each of at least `bytes`; BadFile where so many cannot follow.
  std::size_t get_count(std::size_t bytes);
  template <class T>
  std::vector<T> get_list() {
    std::vector<T> list(get_count(sizeof(T)));
    if (const char* from = take(sizeof(T) * list.size()); !list.empty()) std::memcpy(list.data(), from, sizeof(T) * list.size());
    return list;
  }
  bool at_end() const { return bytes_.empty(); }

 private:
  std::string_view bytes_;
};

/// Throws BadFile naming a factor type that cannot be written.
void write_binary(ByteWriter& out, const Graph& graph, const Values& values);
/// Into an empty graph and values. Throws BadFile naming a type that this program does not have, or has otherwise.
void read_binary(ByteReader& in, Graph& graph, Values& values);

}  // namespace holdfast::io
