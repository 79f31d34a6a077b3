// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <optional>
#include <utility>

#include "definition_error.hpp"
#include "interface_parts.hpp"
#include "names.hpp"
#include "parsers.hpp"
#include "type_text.hpp"
#include "values.hpp"

namespace pipescout::generator {
namespace {

bool is_blank(char c) {
  return c == ' ' || c == '\t';
}

/// Where the comment of a line begins: at the first '#' outside of quotes.
std::size_t comment_begin(std::string_view line) {
  char quote = '\0';
  for (std::size_t i = 0; i < line.size(); ++i) {
    const char c = line[i];
    if (quote != '\0') {
      if (c == '\\') {
        ++i;
      } else if (c == quote) {
        quote = '\0';
      }
    } else if (c == '#') {
      return i;
    } else if (c == '"' ||
               (c == '\'' && (i == 0 || !std::isalnum(static_cast<unsigned char>(line[i - 1]))))) {
      quote = c;
    }
  }
  return std::string_view::npos;
}

std::string comment_text(std::string_view comment) {
  comment.remove_prefix(1);
  if (comment.starts_with(' ')) {
    comment.remove_prefix(1);
  }
  const auto last = comment.find_last_not_of(" \t\r");
  return std::string(comment.substr(0, last == std::string_view::npos ? 0 : last + 1));
}

class Parser {
 public:
  Parser(std::string_view text, const DefinitionPath& path)
      : text_(text), path_(path), interface_(empty_interface(path)) {}

  Interface run() {
    std::size_t begin = 0;
    while (begin < text_.size()) {
      const auto end = std::min(text_.find('\n', begin), text_.size());
      location_.line++;
      line(text_.substr(begin, end - begin));
      begin = end + 1;
    }
    close();
    if (part_ + 1 != interface_.structures.size()) {
      throw DefinitionError(location_, "",
                            "has " + std::to_string(part_) + " lines '---', expected " +
                                std::to_string(interface_.structures.size() - 1));
    }
    return std::move(interface_);
  }

 private:
  [[nodiscard]] Structure& structure() { return interface_.structures[part_]; }

  [[noreturn]] void fail(std::string_view name, const std::string& message) const {
    throw DefinitionError(location_, name, message);
  }

  void line(std::string_view whole) {
    const auto comment_at = comment_begin(whole);
    const auto declaration = trim(whole.substr(0, comment_at));
    const auto comment =
        comment_at == std::string_view::npos ? "" : comment_text(whole.substr(comment_at));
    if (declaration.empty()) {
      if (comment_at != std::string_view::npos) {
        above_.push_back(comment);
      } else {
        blank_line();
      }
    } else if (declaration == "---") {
      close();
      if (++part_ == interface_.structures.size()) {
        fail("", "one '---' too many");
      }
    } else {
      declare(declaration, comment);
    }
  }

  /// Comments that a blank line separates from what follows speak of the structure.
  void blank_line() {
    if (above_.empty()) {
      return;
    }
    if (structure().fields.empty() && structure().constants.empty()) {
      auto& comments = structure().comments;
      if (!comments.empty()) {
        comments.emplace_back();
      }
      comments.insert(comments.end(), above_.begin(), above_.end());
    } else {
      above_.emplace_back();
      return;
    }
    above_.clear();
  }

  /// Ends the current structure.
  void close() {
    while (!above_.empty() && above_.back().empty()) {
      above_.pop_back();
    }
    structure().closing_comments = std::exchange(above_, {});
    if (structure().fields.empty()) {
      Field placeholder;
      placeholder.name = kPlaceholder;
      placeholder.type.kind = Kind::kUInt8;
      placeholder.location = location_;
      structure().fields.push_back(std::move(placeholder));
    }
  }

  void declare(std::string_view text, const std::string& comment) {
    const auto type_end = std::ranges::find_if(text, is_blank) - text.begin();
    const auto type_text = text.substr(0, static_cast<std::size_t>(type_end));
    const auto rest = trim(text.substr(static_cast<std::size_t>(type_end)));
    const auto name_end =
        std::ranges::find_if(rest, [](char c) { return is_blank(c) || c == '='; }) - rest.begin();
    const auto name = rest.substr(0, static_cast<std::size_t>(name_end));
    const auto behind = trim(rest.substr(static_cast<std::size_t>(name_end)));
    if (name.empty()) {
      fail(type_text, "a type without a name");
    }
    auto type = parse_type(type_text, name);
    // "<=" belongs to a bound, which the type holds: a '=' behind the name makes a constant.
    if (behind.starts_with('=')) {
      constant(std::move(type), name, trim(behind.substr(1)), comment);
    } else {
      field(std::move(type), name, behind, comment);
    }
  }

  void constant(Type type, std::string_view name, std::string_view value,
                const std::string& comment) {
    if (type.shape != Shape::kSingle || type.kind == Kind::kMessage) {
      fail(name, "a constant is a number, a truth value or a string");
    }
    if (value.empty() && !is_text(type.kind)) {
      fail(name, "a constant without a value");
    }
    Constant result;
    result.name = name;
    result.value = parse_value(type.kind, value, location_, name);
    result.type = std::move(type);
    result.comments = {std::exchange(above_, {}), comment};
    result.location = location_;
    structure().constants.push_back(std::move(result));
  }

  void field(Type type, std::string_view name, std::string_view default_text,
             const std::string& comment) {
    Field result;
    result.name = name;
    if (!default_text.empty()) {
      if (type.kind == Kind::kMessage) {
        fail(name, "a message cannot have a default value");
      }
      result.default_value = parse_default(type, default_text, location_, name);
    }
    result.type = std::move(type);
    result.comments = {std::exchange(above_, {}), comment};
    result.location = location_;
    structure().fields.push_back(std::move(result));
  }

  [[nodiscard]] std::size_t bound(std::string_view text, std::string_view name) const {
    const auto value =
        std::get<std::uint64_t>(parse_number(Kind::kUInt32, text, false, location_, name));
    if (value == 0) {
      fail(name, "a size or bound is at least 1");
    }
    return value;
  }

  /// "string<=5[<=3]", "Header", "geometry_msgs/Point[]".
  [[nodiscard]] Type parse_type(std::string_view text, std::string_view name) const {
    Type type;
    auto element = text;
    if (text.ends_with(']')) {
      const auto open = text.rfind('[');
      if (open == std::string_view::npos) {
        fail(name, "'" + std::string(text) + "' is no type");
      }
      element = text.substr(0, open);
      auto size = text.substr(open + 1, text.size() - open - 2);
      type.shape = Shape::kArray;
      if (size.empty() || size.starts_with("<=")) {
        type.shape = Shape::kSequence;
        size.remove_prefix(std::min<std::size_t>(2, size.size()));
      }
      type.length = size.empty() && text[open + 1] == ']' ? 0 : bound(size, name);
    }
    if (const auto at = element.find("<="); at != std::string_view::npos) {
      type.text_length = bound(element.substr(at + 2), name);
      element = element.substr(0, at);
      if (element != "string" && element != "wstring") {
        fail(name, "only strings have a bound, " + std::string(element) + " has none");
      }
    }
    if (const auto kind = kind_of_msg_name(element)) {
      type.kind = *kind == Kind::kChar ? Kind::kUInt8 : *kind;
      return type;
    }
    type.kind = Kind::kMessage;
    type.message = message_name(element, name);
    return type;
  }

  [[nodiscard]] std::string message_name(std::string_view text, std::string_view name) const {
    // These three need no package, as in ROS 1.
    if (text == "Header") {
      return "std_msgs/msg/Header";
    }
    const auto slash = text.find('/');
    if (slash == std::string_view::npos) {
      check_type_name(text, location_);
      return path_.package + "/msg/" + std::string(text);
    }
    auto package = text.substr(0, slash);
    auto type = text.substr(slash + 1);
    if (type.starts_with("msg/")) {
      type.remove_prefix(4);
    }
    check_package_name(package, location_);
    if (type.find('/') != std::string_view::npos) {
      fail(name, "'" + std::string(text) + "' is no type: package/Type");
    }
    check_type_name(type, location_);
    return std::string(package) + "/msg/" + std::string(type);
  }

  std::string_view text_;
  const DefinitionPath& path_;
  Interface interface_;
  Location location_{path_.file, 0};
  std::size_t part_ = 0;
  std::vector<std::string> above_;
};

}  // namespace

Interface parse_msg(std::string_view text, const DefinitionPath& path) {
  auto interface = Parser(text, path).run();
  check_interface(interface);
  return interface;
}

}  // namespace pipescout::generator
