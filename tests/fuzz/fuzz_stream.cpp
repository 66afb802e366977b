// Any lines through a LineParser, as `holdfast track` feeds it: a line that is refused leaves no trace, so the good lines alone make
// the same dataset. The first byte chooses the format.
#include <holdfast/graph/files/files.hpp>
#include <holdfast/graph/files/internal/parser.hpp>

#include "bytes.hpp"

namespace holdfast {
namespace {

struct Counts {
  explicit Counts(const Dataset& d) : n{d.vertices.size(), d.edges.size(), d.fixed.size(), d.offsets.size(), d.unknown.size()} {}
  std::size_t n[5];
  bool operator==(const Counts& other) const { return std::equal(n, n + 5, other.n); }
};

std::string finished(LineParser& parser) {
  try {
    const Dataset dataset = parser.finish();
    return to_text(dataset, dataset.format);
  } catch (const BadFile& problem) {
    return problem.what();
  }
}

}  // namespace
}  // namespace holdfast

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace holdfast;
  fuzz::Bytes bytes(data, size);
  const Format format = static_cast<Format>(bytes.below(3));
  LineParser parser(format, "fuzz"), only_good(format, "fuzz");
  io::for_each_line(bytes.rest(), [&](std::size_t number, std::string_view line) {
    const Counts before(parser.dataset());
    try {
      parser.parse(number, line);
    } catch (const BadFile&) {
      fuzz::require(before == Counts(parser.dataset()), "a refused line left something behind:", std::string(line));
      return;
    }
    only_good.parse(number, line);
  });
  fuzz::require(Counts(parser.dataset()) == Counts(only_good.dataset()), "bad lines change what good lines make");
  const std::string all = finished(parser);
  fuzz::require(all == finished(only_good), "bad lines change what good lines make:\n", all);
  return 0;
}
