#include <algorithm>
#include <holdfast/graph/print.hpp>
#include <ostream>
#include <set>

namespace holdfast {
namespace {

constexpr std::size_t kLines = 20;

std::string counted(std::size_t n, const char* what) { return std::to_string(n) + " " + what + (n == 1 ? "" : "s"); }

void print_rest(std::ostream& out, std::size_t n) {
  if (n > kLines) out << "\n  … " << n - kLines << " more";
}

std::set<Key> keys_of(const Graph& graph) {
  std::set<Key> keys;
  for (const auto& batch : graph.batches()) keys.insert(batch->keys(0), batch->keys(batch->size()));
  return keys;
}

std::string factor_line(const FactorBatch& batch, int i) {
  std::ostringstream line;
  line.imbue(std::locale::classic());
  line << "\n  " << batch.describe(i);
  if (const std::string loss = batch.loss(i).str(); loss != Loss{}.str()) line << ", loss " << loss;
  if (batch.weight(i) != 1) line << ", weight " << batch.weight(i);
  return line.str();
}

}  // namespace

std::ostream& operator<<(std::ostream& out, const Values& values) {
  const std::vector<Key> keys = values.keys();
  out << "Values: " << counted(keys.size(), "variable");
  for (std::size_t i = 0; i < std::min(kLines, keys.size()); ++i) {
    const Values::Slot& slot = values.slot(keys[i]);
    out << "\n  " << keys[i] << "  ";
    values.pool(slot.pool).print(slot.index, out);
  }
  print_rest(out, keys.size());
  return out << "\n";
}

std::ostream& operator<<(std::ostream& out, const Graph& graph) {
  out << "Graph: " << counted(graph.size(), "factor") << " on " << counted(keys_of(graph).size(), "variable");
  if (!graph.fixed().empty()) out << ", " << graph.fixed().size() << " fixed";
  std::size_t lines = 0;
  for (const auto& batch : graph.batches())
    for (int i = 0; i < batch->size() && lines < kLines; ++i, ++lines) out << factor_line(*batch, i);
  print_rest(out, graph.size());
  return out << "\n";
}

}  // namespace holdfast
