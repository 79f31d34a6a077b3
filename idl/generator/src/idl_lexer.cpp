// SPDX-License-Identifier: Apache-2.0
#include "idl_lexer.hpp"

#include <utility>

#include "definition_error.hpp"
#include "values.hpp"

namespace pipescout::generator {
namespace {

bool is_digit(char c) {
  return c >= '0' && c <= '9';
}

bool is_word(char c) {
  return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || c == '_' || is_digit(c);
}

class Lexer {
 public:
  Lexer(std::string_view text, const std::string& file) : text_(text), file_(file) {}

  IdlTokens run() {
    while (skip_blank()) {
      start_line_ = line_;
      const char c = peek();
      if (c == '#') {
        directive();
      } else if (is_digit(c) || (c == '.' && is_digit(peek(1)))) {
        add(IdlToken::Kind::kNumber, number());
      } else if (c == '"' || (c == 'L' && peek(1) == '"')) {
        if (c == 'L') {
          take();
        }
        add(IdlToken::Kind::kString, string());
      } else if (is_word(c)) {
        add(IdlToken::Kind::kWord, take_while(is_word));
      } else if (c == ':' && peek(1) == ':') {
        take();
        take();
        add(IdlToken::Kind::kPunctuation, "::");
      } else if (std::string_view("{}[]()<>;:,=@+-").find(c) != std::string_view::npos) {
        add(IdlToken::Kind::kPunctuation, std::string(1, take()));
      } else {
        fail("unexpected character '" + std::string(1, c) + "'");
      }
    }
    start_line_ = line_;
    add(IdlToken::Kind::kEnd, "end of file");
    return std::move(result_);
  }

 private:
  [[noreturn]] void fail(const std::string& message) const {
    throw DefinitionError({file_, start_line_}, "", message);
  }

  [[nodiscard]] char peek(std::size_t ahead = 0) const {
    return position_ + ahead < text_.size() ? text_[position_ + ahead] : '\0';
  }

  char take() {
    const char c = text_[position_++];
    if (c == '\n') {
      ++line_;
    }
    return c;
  }

  [[nodiscard]] bool at_end() const { return position_ >= text_.size(); }

  template <class Predicate>
  std::string take_while(Predicate predicate) {
    std::string taken;
    while (!at_end() && predicate(peek())) {
      taken += take();
    }
    return taken;
  }

  std::string number() {
    std::string taken;
    while (!at_end()) {
      const char c = peek();
      const bool hexadecimal = taken.size() > 1 && (taken[1] == 'x' || taken[1] == 'X');
      const bool exponent_sign = (c == '+' || c == '-') && !taken.empty() && !hexadecimal &&
                                 (taken.back() == 'e' || taken.back() == 'E');
      if (!is_word(c) && c != '.' && !exponent_sign) {
        break;
      }
      taken += take();
    }
    return taken;
  }

  std::string string() {
    take();
    std::string content;
    while (peek() != '"') {
      if (at_end() || peek() == '\n') {
        fail("string is not closed");
      }
      if (peek() == '\\') {
        take();
        content += escaped();
      } else {
        content += take();
      }
    }
    take();
    return content;
  }

  char escaped() {
    if (at_end()) {
      fail("string is not closed");
    }
    constexpr std::string_view kEscapes = "nt\"\\'?";
    constexpr std::string_view kMeanings = "\n\t\"\\'?";
    const auto index = kEscapes.find(take());
    if (index == std::string_view::npos) {
      fail("the escape sequences of a string are \\n \\t \\\" \\\\ \\' and \\?");
    }
    return kMeanings[index];
  }

  /// False at the end of the text.
  bool skip_blank() {
    while (!at_end()) {
      if (peek() == '/' && peek(1) == '/') {
        const int line = line_;
        const auto text = take_while([](char c) { return c != '\n'; });
        comment(std::string_view(text).substr(2), line);
      } else if (peek() == '/' && peek(1) == '*') {
        block_comment();
      } else if (std::string_view(" \t\r\n\f\v").find(peek()) != std::string_view::npos) {
        take();
      } else {
        return true;
      }
    }
    return false;
  }

  void block_comment() {
    start_line_ = line_;
    take();
    take();
    std::string text;
    int line = line_;
    while (!(peek() == '*' && peek(1) == '/')) {
      if (at_end()) {
        fail("comment is not closed");
      }
      if (peek() == '\n') {
        comment(text, line);
        text.clear();
        take();
        line = line_;
      } else {
        text += take();
      }
    }
    take();
    take();
    comment(text, line);
  }

  void comment(std::string_view text, int line) {
    const bool alone = result_.tokens.empty() || result_.tokens.back().line != line;
    // One blank separates the text from its sign; further ones may be indentation.
    if (text.starts_with(' ')) {
      text.remove_prefix(1);
    }
    const auto last = text.find_last_not_of(" \t\r");
    text = text.substr(0, last == std::string_view::npos ? 0 : last + 1);
    result_.comments.push_back({std::string(text), line, alone});
  }

  void directive() {
    const auto line = take_while([](char c) { return c != '\n'; });
    constexpr std::string_view kInclude = "#include";
    if (!line.starts_with(kInclude)) {
      const auto directive = std::string(trim(line.substr(0, line.find(' '))));
      fail("'" + directive +
           "' is not supported, as rosidl does not; of the preprocessor there "
           "is #include only, and no file needs include guards");
    }
    const auto open = line.find_first_of("\"<", kInclude.size());
    const auto close = line.find_last_of("\">");
    if (open == std::string::npos || close <= open + 1) {
      fail("#include names no file");
    }
    add(IdlToken::Kind::kInclude, line.substr(open + 1, close - open - 1));
  }

  void add(IdlToken::Kind kind, std::string text) {
    result_.tokens.push_back({kind, std::move(text), start_line_});
  }

  std::string_view text_;
  const std::string& file_;
  IdlTokens result_;
  std::size_t position_ = 0;
  int line_ = 1;
  int start_line_ = 1;
};

}  // namespace

IdlTokens tokenize_idl(std::string_view text, const std::string& file) {
  return Lexer(text, file).run();
}

}  // namespace pipescout::generator
