// The keys of a factor: as many as it has variables. Fewer or more do not compile.
//
//   graph.add(Range<Pose2, Point2>{5, 0.1}, {A(0), L(0)});      // {A(0)} is an error: "no matching function for call to add"
#pragma once

#include <array>
#include <holdfast/graph/key.hpp>
#include <type_traits>

namespace holdfast {

template <int N>
class FactorKeys {
 public:
  template <class... K, class = std::enable_if_t<sizeof...(K) == N && (std::is_convertible_v<K, Key> && ...)>>
  constexpr FactorKeys(const K&... keys) : keys_{keys...} {}
  constexpr FactorKeys(const std::array<Key, N>& keys) : keys_(keys) {}

  static constexpr std::size_t size() { return N; }
  constexpr const Key* data() const { return keys_.data(); }
  constexpr Key operator[](std::size_t i) const { return keys_[i]; }

 private:
  std::array<Key, N> keys_;
};

}  // namespace holdfast
