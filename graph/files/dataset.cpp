#include <holdfast/graph/files/dataset.hpp>
#include <unordered_map>

namespace holdfast {
namespace {

template <class V>
std::vector<Key> keys(const RelativePoseEdge<V>& edge) {
  return {edge.first, edge.second};
}
template <class P>
std::vector<Key> keys(const RelativePointEdge<P>& edge) {
  return {edge.pose, edge.landmark};
}
std::vector<Key> keys(const RangeEdge& edge) { return {edge.first, edge.second}; }
template <class V>
std::vector<Key> keys(const PriorEdge<V>& edge) {
  return {edge.key};
}

template <class P>
std::vector<Key> keys(const PositionEdge<P>& edge) {
  return {edge.key};
}
std::vector<Key> keys(const BearingEdge& edge) { return {edge.pose, edge.landmark}; }

template <class V>
const char* kind(const RelativePoseEdge<V>&) {
  return V::dim > V::space_dim ? "relative pose" : "relative position";
}
template <class P>
const char* kind(const RelativePointEdge<P>&) {
  return "relative point";
}
const char* kind(const RangeEdge&) { return "range"; }
template <class V>
const char* kind(const PriorEdge<V>&) {
  return "prior";
}
template <class P>
const char* kind(const PositionEdge<P>&) {
  return "position prior";
}
const char* kind(const BearingEdge&) { return "bearing"; }

}  // namespace

std::vector<UnknownTag> unknown_tags(const Dataset& dataset) {
  std::vector<UnknownTag> tags;
  std::unordered_map<std::string, std::size_t> index;
  for (const UnknownLine& unknown : dataset.unknown) {
    const auto [it, is_new] = index.try_emplace(unknown.tag, tags.size());
    if (is_new) tags.push_back({unknown.tag, 0, unknown.line});
    ++tags[it->second].count;
  }
  return tags;
}

std::string unknown_report(const Dataset& dataset) {
  const std::vector<UnknownTag> tags = unknown_tags(dataset);
  if (tags.empty()) return {};
  std::string report = dataset.name + ": " + std::to_string(dataset.unknown.size()) + (dataset.unknown.size() == 1 ? " line" : " lines") +
                       " of " + std::to_string(tags.size()) + (tags.size() == 1 ? " unknown tag" : " unknown tags") + " left out: ";
  for (const UnknownTag& tag : tags) {
    if (&tag != &tags.front()) report += ", ";
    report += tag.tag + " (" + std::to_string(tag.count) + ", first in line " + std::to_string(tag.first_line) + ")";
  }
  return report;
}

std::vector<Key> keys_of(const Measurement& measurement) {
  return std::visit([](const auto& edge) { return keys(edge); }, measurement);
}

std::string describe(const Edge& edge) {
  std::string text = std::visit([](const auto& measurement) { return kind(measurement); }, edge.measurement);
  for (Key key : keys_of(edge.measurement)) text += " " + key.str();
  if (edge.line > 0) text += " (line " + std::to_string(edge.line) + ")";
  return text;
}

}  // namespace holdfast
