// What the tests of files share: text in, datasets compared bit by bit, the data directory.
#pragma once

#include <gtest/gtest.h>

#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <holdfast/graph/files/files.hpp>
#include <sstream>
#include <string>

namespace holdfast::testing_io {

inline Dataset parsed(const std::string& text, Format format, const std::string& name = "test.txt") {
  std::istringstream in(text);
  return parse_dataset(in, name, format);
}

template <class T>
bool same_bits(const T& a, const T& b) {
  return std::memcmp(static_cast<const void*>(&a), static_cast<const void*>(&b), sizeof(T)) == 0;
}
inline bool same(const Columns& a, const Columns& b) { return a.size == b.size && same_bits(a.number, b.number); }
inline bool same(const std::optional<double>& a, const std::optional<double>& b) {
  return a.has_value() == b.has_value() && (!a || same_bits(*a, *b));
}
template <int N>
bool same(const MatrixNoise<N>& a, const MatrixNoise<N>& b) {
  return a.format == b.format && same_bits(a.written, b.written);
}
template <class V>
bool same(const RelativePoseEdge<V>& a, const RelativePoseEdge<V>& b) {
  return a.first == b.first && a.second == b.second && same_bits(a.measured, b.measured) && same(a.columns, b.columns) &&
         same(a.noise, b.noise);
}
template <class P>
bool same(const RelativePointEdge<P>& a, const RelativePointEdge<P>& b) {
  return a.pose == b.pose && a.landmark == b.landmark && same_bits(a.measured, b.measured) && same(a.columns, b.columns) &&
         same(a.noise, b.noise) && a.offset == b.offset;
}
template <class V>
bool same(const PriorEdge<V>& a, const PriorEdge<V>& b) {
  return a.key == b.key && same_bits(a.measured, b.measured) && same(a.columns, b.columns) && same(a.noise, b.noise) &&
         a.offset == b.offset;
}
inline bool same(const RangeEdge& a, const RangeEdge& b) {
  return a.first == b.first && a.second == b.second && same_bits(a.distance, b.distance) && same_bits(a.variance, b.variance);
}
inline bool same(const BearingEdge& a, const BearingEdge& b) {
  return a.pose == b.pose && a.landmark == b.landmark && same_bits(a.angle, b.angle) && same_bits(a.information, b.information);
}
template <class P>
bool same(const PositionEdge<P>& a, const PositionEdge<P>& b) {
  return a.key == b.key && same_bits(a.measured, b.measured) && same(a.columns, b.columns) && same(a.noise, b.noise);
}
template <class... T>
bool same(const std::variant<T...>& a, const std::variant<T...>& b) {
  if (a.index() != b.index()) return false;
  return std::visit([&](const auto& x) { return same(x, std::get<std::decay_t<decltype(x)>>(b)); }, a);
}

/// Everything but the line numbers and the name, which a new file may have otherwise.
inline void expect_same(const Dataset& a, const Dataset& b) {
  EXPECT_EQ(a.format, b.format);
  ASSERT_EQ(a.vertices.size(), b.vertices.size());
  for (std::size_t i = 0; i < a.vertices.size(); ++i) {
    const Vertex &x = a.vertices[i], &y = b.vertices[i];
    const bool same_value = x.value.index() == y.value.index() &&
                            std::visit([&](const auto& v) { return same_bits(v, std::get<std::decay_t<decltype(v)>>(y.value)); }, x.value);
    ASSERT_TRUE(x.key == y.key && same_value && same(x.columns, y.columns) && same(x.time, y.time))
        << "vertex " << i << ", " << x.key.str();
  }
  ASSERT_EQ(a.edges.size(), b.edges.size());
  for (std::size_t i = 0; i < a.edges.size(); ++i)
    ASSERT_TRUE(same(a.edges[i].measurement, b.edges[i].measurement) && same(a.edges[i].time, b.edges[i].time))
        << "edge " << i << ": " << describe(a.edges[i]);
  ASSERT_EQ(a.fixed.size(), b.fixed.size());
  for (std::size_t i = 0; i < a.fixed.size(); ++i) EXPECT_EQ(a.fixed[i].key, b.fixed[i].key);
  ASSERT_EQ(a.offsets.size(), b.offsets.size());
  for (std::size_t i = 0; i < a.offsets.size(); ++i)
    EXPECT_TRUE(a.offsets[i].id == b.offsets[i].id && same(a.offsets[i].columns, b.offsets[i].columns));
  ASSERT_EQ(a.unknown.size(), b.unknown.size());
  for (std::size_t i = 0; i < a.unknown.size(); ++i) EXPECT_EQ(a.unknown[i].text, b.unknown[i].text);
}

inline std::string written(const Dataset& dataset) { return to_text(dataset, dataset.format); }

/// Runs `action`, which must throw E, and checks that its message holds every part.
template <class E, class Action>
void expect_message(Action&& action, const std::vector<std::string>& parts) {
  try {
    action();
  } catch (const E& error) {
    for (const std::string& part : parts)
      EXPECT_NE(std::string(error.what()).find(part), std::string::npos) << "no '" << part << "' in: " << error.what();
    return;
  } catch (const std::exception& error) {
    FAIL() << "another type of exception: " << error.what();
  }
  FAIL() << "nothing thrown; expected a message with '" << (parts.empty() ? "" : parts[0]) << "'";
}

/// A directory that is gone after the test.
class TemporaryDirectory {
 public:
  TemporaryDirectory() {
    std::string pattern = (std::filesystem::temp_directory_path() / "holdfast_XXXXXX").string();
    path_ = ::mkdtemp(pattern.data());
  }
  ~TemporaryDirectory() { std::filesystem::remove_all(path_); }
  std::string operator/(const std::string& name) const { return (path_ / name).string(); }
  std::size_t files() const { return static_cast<std::size_t>(std::distance(std::filesystem::directory_iterator(path_), {})); }

 private:
  std::filesystem::path path_;
};

inline std::string content(const std::string& path) {
  std::ifstream in(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(in), {}};
}
inline void put(const std::string& path, const std::string& text) { std::ofstream(path, std::ios::binary) << text; }

/// $HOLDFAST_DATA, else the data beside the source tree; empty where there is none.
inline std::string data_directory() {
  if (const char* path = std::getenv("HOLDFAST_DATA")) return path;
#ifdef HOLDFAST_SOURCE_DIR
  const std::string beside = std::string(HOLDFAST_SOURCE_DIR) + "/../shared/data";
  if (std::filesystem::is_directory(beside)) return beside;
#endif
  return {};
}

}  // namespace holdfast::testing_io

#define HOLDFAST_NEED_DATA(path)                                                                                                         \
  if (holdfast::testing_io::data_directory().empty() || !std::filesystem::exists(holdfast::testing_io::data_directory() + "/" + (path))) \
  GTEST_SKIP() << "no " << (path) << " in the data directory '" << holdfast::testing_io::data_directory() << "'; set HOLDFAST_DATA to it"
