// The fuzz target of files without clang: random edits of valid files, for any compiler. Links with fuzz_file.cpp:
//
//   random_edits COUNT SEED FILE...        COUNT edited files; ends with a line that says how many, or aborts on the first wrong one
//
// An edit changes, swaps, repeats or removes a byte, a word or a line, or takes a word of another file; one to four of them at a time. As
// in the corpus, the first byte of what the target gets chooses how it is read. The file at hand stands in "edited.txt" before it is tried.
#include <fstream>
#include <iostream>
#include <iterator>
#include <random>
#include <sstream>
#include <vector>

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size);

namespace {

using Text = std::string;
using Random = std::mt19937_64;

std::size_t below(std::size_t n, Random& rng) { return n == 0 ? 0 : rng() % n; }

/// Begin and length of a random word, or line.
std::pair<std::size_t, std::size_t> piece(const Text& text, const char* ends, Random& rng) {
  const std::size_t at = below(text.size(), rng);
  const std::size_t before = text.find_last_of(ends, at);
  const std::size_t begin = before == Text::npos ? 0 : before + 1;
  const std::size_t end = std::min(text.find_first_of(ends, begin), text.size());
  return {begin, end - begin};
}

Text odd_word(Random& rng) {
  static const char* const words[]{
      "nan", "inf",        "-inf",  "1e308",      "-1e308", "1e-320", "0",    "-1",        "18446744073709551616",
      "x0",  "A1",         "FIX 0", "EDGE_RANGE", "#",      "1e999",  "0x10", "+1",        "",
      "L0",  "VERTEX_SE2", "{",     "é",          "\r\n",   "\t",     "1e-9", "4294967296"};
  return words[below(std::size(words), rng)];
}

void edit(Text& text, const std::vector<Text>& files, Random& rng) {
  const bool line = below(2, rng) == 0;
  const char* const ends = line ? "\n" : " \n";
  const auto [begin, size] = piece(text, ends, rng);
  const auto other = piece(text, ends, rng);
  switch (below(7, rng)) {
    case 0:
      if (!text.empty()) text[below(text.size(), rng)] = static_cast<char>(below(256, rng));
      break;
    case 1:
      text.erase(begin, size + (line ? 1 : 0));
      break;
    case 2:
      text.insert(begin, text.substr(begin, size) + ends[0]);
      break;
    case 3:
      text.replace(begin, size, text.substr(other.first, other.second));
      break;
    case 4:
      text.replace(begin, size, odd_word(rng));
      break;
    case 5: {
      const Text& from = files[below(files.size(), rng)];
      const auto theirs = piece(from, ends, rng);
      text.insert(begin, from.substr(theirs.first, theirs.second) + ends[0]);
      break;
    }
    default:
      text.resize(below(text.size() + 1, rng));
  }
}

Text text_of(const char* path) {
  std::ifstream in(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(in), {}};
}

}  // namespace

int main(int argc, char** argv) {
  if (argc < 4) {
    std::cerr << "random_edits COUNT SEED FILE...\n";
    return 2;
  }
  std::vector<Text> files;
  for (int i = 3; i < argc; ++i) {
    files.push_back(text_of(argv[i]));
    if (files.back().size() > 20000) files.back().resize(files.back().find('\n', 20000) + 1);
  }
  const std::uint64_t count = std::stoull(argv[1]);
  Random rng(std::stoull(argv[2]));
  for (std::uint64_t i = 0; i < count; ++i) {
    Text text = files[below(files.size(), rng)];
    for (std::size_t edits = 1 + below(4, rng); edits > 0; --edits) edit(text, files, rng);
    const Text input = static_cast<char>(below(48, rng)) + text;
    std::ofstream("edited.txt", std::ios::binary) << input;
    LLVMFuzzerTestOneInput(reinterpret_cast<const std::uint8_t*>(input.data()), input.size());
  }
  std::cout << count << " edited files of " << files.size() << ": nothing wrong\n";
}
