// SPDX-License-Identifier: Apache-2.0
#include "idl_lexer.hpp"

#include <utility>

#include "pipescout/runtime/introspection.hpp"

namespace pipescout {
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

  std::vector<IdlToken> run() {
    std::vector<IdlToken> tokens;
    while (skip_blank()) {
      start_line_ = line_;
      start_column_ = column_;
      const char c = peek();
      if (c == '#') {
        directive(tokens);
      } else if (is_digit(c) || (c == '.' && is_digit(peek(1)))) {
        tokens.push_back(token(IdlToken::Kind::kNumber, number()));
      } else if (is_word(c)) {
        tokens.push_back(token(IdlToken::Kind::kWord, take_while(is_word)));
      } else if (c == '"') {
        tokens.push_back(token(IdlToken::Kind::kString, string()));
      } else if (c == ':' && peek(1) == ':') {
        take();
        take();
        tokens.push_back(token(IdlToken::Kind::kPunctuation, "::"));
      } else if (std::string_view("{}[]()<>;:,=@+-").find(c) != std::string_view::npos) {
        tokens.push_back(token(IdlToken::Kind::kPunctuation, std::string(1, take())));
      } else {
        fail("unexpected character '" + std::string(1, c) + "'");
      }
    }
    start_line_ = line_;
    start_column_ = column_;
    tokens.push_back(token(IdlToken::Kind::kEnd, "end of file"));
    return tokens;
  }

 private:
  [[noreturn]] void fail(const std::string& message) const {
    fail_idl(file_, start_line_, start_column_, message);
  }

  [[nodiscard]] char peek(std::size_t ahead = 0) const {
    return position_ + ahead < text_.size() ? text_[position_ + ahead] : '\0';
  }

  char take() {
    const char c = text_[position_++];
    ++column_;
    if (c == '\n') {
      ++line_;
      column_ = 1;
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
        if (peek() != '"' && peek() != '\\') {
          fail("escape sequences other than \\\" and \\\\ are not supported");
        }
      }
      content += take();
    }
    take();
    return content;
  }

  /// False at the end of the text.
  bool skip_blank() {
    while (!at_end()) {
      if (peek() == '/' && peek(1) == '/') {
        take_while([](char c) { return c != '\n'; });
      } else if (peek() == '/' && peek(1) == '*') {
        start_line_ = line_;
        start_column_ = column_;
        take();
        take();
        while (!(peek() == '*' && peek(1) == '/')) {
          if (at_end()) {
            fail("comment is not closed");
          }
          take();
        }
        take();
        take();
      } else if (std::string_view(" \t\r\n\f\v").find(peek()) != std::string_view::npos) {
        take();
      } else {
        return true;
      }
    }
    return false;
  }

  void directive(std::vector<IdlToken>& tokens) {
    const auto line = take_while([](char c) { return c != '\n'; });
    constexpr std::string_view kInclude = "#include";
    if (line.compare(0, kInclude.size(), kInclude) != 0) {
      return;  // include guards
    }
    const auto open = line.find_first_of("\"<", kInclude.size());
    const auto close = line.find_last_of("\">");
    if (open == std::string::npos || close <= open + 1) {
      fail("#include names no file");
    }
    tokens.push_back(token(IdlToken::Kind::kInclude, line.substr(open + 1, close - open - 1)));
  }

  [[nodiscard]] IdlToken token(IdlToken::Kind kind, std::string text) const {
    return {kind, std::move(text), start_line_, start_column_};
  }

  std::string_view text_;
  const std::string& file_;
  std::size_t position_ = 0;
  int line_ = 1;
  int column_ = 1;
  int start_line_ = 1;
  int start_column_ = 1;
};

}  // namespace

std::vector<IdlToken> tokenize_idl(std::string_view text, const std::string& file) {
  return Lexer(text, file).run();
}

void fail_idl(const std::string& file, int line, int column, const std::string& message) {
  throw IdlError(file + ":" + std::to_string(line) + ":" + std::to_string(column) + ": " + message);
}

}  // namespace pipescout
