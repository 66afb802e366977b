#include <holdfast/graph/files/internal/json.hpp>
#include <holdfast/graph/files/internal/text.hpp>

namespace holdfast::io {
namespace {

constexpr int kDeepest = 100;

class Parser {
 public:
  Parser(std::string_view text, const std::string& file) : text_(text), file_(file) {}

  JsonValue parse() {
    if (text_.substr(0, 3) == "\xEF\xBB\xBF") at_ = 3;
    JsonValue value = read(0);
    skip_blanks();
    if (at_ < text_.size()) error("expected nothing behind the closing bracket");
    return value;
  }

 private:
  [[noreturn]] void error(const std::string& what) const {
    fail<BadFile>(file_, ", line ", line_, ": '", excerpt(text_.substr(at_, 40)), "': ", what,
                  at_ >= text_.size() ? " (is the file cut?)" : "");
  }
  void skip_blanks() {
    for (; at_ < text_.size(); ++at_) {
      const char c = text_[at_];
      if (c == '\n') ++line_;
      if (c != ' ' && c != '\t' && c != '\r' && c != '\n') return;
    }
  }
  bool take(char c) {
    skip_blanks();
    if (at_ >= text_.size() || text_[at_] != c) return false;
    ++at_;
    return true;
  }

  JsonValue read(int depth) {
    if (depth > kDeepest) error("lists and objects more than 100 deep; expected fewer");
    skip_blanks();
    if (at_ >= text_.size()) error("expected a value");
    JsonValue value;
    value.line = line_;
    const std::size_t begin = at_;
    const char c = text_[at_];
    if (c == '{' || c == '[') {
      read_items(value, c == '{', depth);
    } else if (c == '"') {
      value.type = JsonValue::Type::text;
      value.text = read_text();
    } else {
      read_word(value);
    }
    value.raw = text_.substr(begin, at_ - begin);
    return value;
  }
  void read_items(JsonValue& value, bool is_object, int depth) {
    value.type = is_object ? JsonValue::Type::object : JsonValue::Type::list;
    const char close = is_object ? '}' : ']';
    ++at_;
    if (take(close)) return;
    do {
      std::string name;
      if (is_object) {
        skip_blanks();
        if (at_ >= text_.size() || text_[at_] != '"') error("expected a name in quotes");
        name = read_text();
        if (!take(':')) error("expected ':' behind the name \"" + excerpt(name) + "\"");
      }
      value.items.push_back(read(depth + 1));
      value.items.back().name = std::move(name);
    } while (take(','));
    if (!take(close)) error(is_object ? "expected ',' or '}'" : "expected ',' or ']'");
  }
  std::string read_text() {
    std::string text;
    for (++at_; at_ < text_.size(); ++at_) {
      const char c = text_[at_];
      if (c == '"') {
        ++at_;
        return text;
      }
      if (c == '\n') error("expected the closing quotes");
      text += c;
      if (c != '\\') continue;
      if (++at_ >= text_.size()) break;
      text.back() = unescaped(text_[at_]);
      if (text_[at_] == 'u') {  // kept as it stands: no name of this format needs one
        text.back() = '\\';
        text += 'u';
      }
    }
    error("expected the closing quotes");
  }
  static char unescaped(char c) {
    switch (c) {
      case 'n':
        return '\n';
      case 't':
        return '\t';
      case 'r':
        return '\r';
      case 'b':
        return '\b';
      case 'f':
        return '\f';
      default:
        return c;
    }
  }
  void read_word(JsonValue& value) {
    std::size_t end = at_;
    while (end < text_.size() && std::string_view(" \t\r\n,]}:{[\"").find(text_[end]) == std::string_view::npos) ++end;
    const std::string_view word = text_.substr(at_, end - at_);
    if (word == "null")
      value.type = JsonValue::Type::null;
    else if (word == "true" || word == "false")
      value.type = JsonValue::Type::boolean;
    else if (!word.empty() && std::string_view("-+.0123456789").find(word[0]) != std::string_view::npos)
      value.type = JsonValue::Type::number;
    else
      error("expected a number, a text in quotes, a list or an object");
    at_ = end;
  }

  std::string_view text_;
  const std::string& file_;
  std::size_t at_ = 0, line_ = 1;
};

}  // namespace

const JsonValue* JsonValue::find(std::string_view member) const {
  if (type != Type::object) return nullptr;
  for (const JsonValue& item : items)
    if (item.name == member) return &item;
  return nullptr;
}

JsonValue parse_json(std::string_view text, const std::string& file) { return Parser(text, file).parse(); }

std::string to_json_text(std::string_view text) {
  std::string quoted = "\"";
  for (const char c : text) {
    if (c == '"' || c == '\\') quoted += '\\';
    if (c == '\n')
      quoted += "\\n";
    else if (c == '\t')
      quoted += "\\t";
    else
      quoted += c;
  }
  return quoted + '"';
}

}  // namespace holdfast::io
