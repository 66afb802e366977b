#include <holdfast/graph/draw.hpp>
#include <set>

namespace holdfast {
namespace {

/// In quotes; quotes and backslashes inside are escaped.
std::string quoted(const std::string& text) {
  std::string result = "\"";
  for (char c : text) {
    if (c == '"' || c == '\\') result += '\\';
    result += c;
  }
  return result + "\"";
}

}  // namespace

std::string to_dot(const Graph& graph) {
  std::set<Key> keys(graph.fixed().begin(), graph.fixed().end());
  std::string factors;
  int number = 0;
  for (const auto& batch : graph.batches())
    for (int i = 0; i < batch->size(); ++i, ++number) {
      const std::string node = "factor" + std::to_string(number);
      factors += "  " + node + " [shape=box, label=" + quoted(batch->name()) + "];\n";
      for (int k = 0; k < batch->arity(); ++k) {
        const Key key = batch->keys(i)[k];
        keys.insert(key);
        factors += "  " + node + " -- " + quoted(key.str()) + ";\n";
      }
    }
  std::string text = "graph holdfast {\n";
  for (Key key : keys) text += "  " + quoted(key.str()) + " [shape=circle" + (graph.is_fixed(key) ? ", style=filled" : "") + "];\n";
  return text + factors + "}\n";
}

}  // namespace holdfast
