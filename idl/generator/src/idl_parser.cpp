// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <map>
#include <optional>
#include <utility>

#include "definition_error.hpp"
#include "idl_lexer.hpp"
#include "interface_parts.hpp"
#include "names.hpp"
#include "parsers.hpp"
#include "type_text.hpp"
#include "values.hpp"

namespace pipescout::generator {
namespace {

/// What stands in parentheses behind an annotation: `value` and `text` by name, or one value alone.
struct Annotation {
  std::string name;
  std::map<std::string, std::vector<IdlToken>> arguments;
  int line = 0;
};

class Parser {
 public:
  Parser(IdlTokens tokens, const DefinitionPath& path)
      : path_(path), tokens_(std::move(tokens.tokens)), comments_(std::move(tokens.comments)) {}

  Interface run() {
    while (peek().kind != IdlToken::Kind::kEnd) {
      if (peek().kind == IdlToken::Kind::kInclude) {
        take();
      } else {
        definition({});
      }
    }
    return assemble();
  }

 private:
  using Scope = std::vector<std::string>;

  [[nodiscard]] const IdlToken& peek() const { return tokens_[position_]; }

  const IdlToken& take() {
    const auto& token = tokens_[position_];
    if (token.kind != IdlToken::Kind::kEnd) {
      ++position_;
    }
    return token;
  }

  [[noreturn]] void fail(const IdlToken& token, const std::string& message,
                         std::string_view name = "") const {
    throw DefinitionError({path_.file, token.line}, name, message);
  }

  [[nodiscard]] bool at(std::string_view text) const {
    return peek().text == text &&
           (peek().kind == IdlToken::Kind::kWord || peek().kind == IdlToken::Kind::kPunctuation);
  }

  bool accept(std::string_view text) {
    if (!at(text)) {
      return false;
    }
    take();
    return true;
  }

  void expect(std::string_view text) {
    if (!accept(text)) {
      fail(peek(), "expected '" + std::string(text) + "', found '" + peek().text + "'");
    }
  }

  /// Without the underscore that escapes a word of IDL.
  std::string identifier() {
    if (peek().kind != IdlToken::Kind::kWord) {
      fail(peek(), "expected a name, found '" + peek().text + "'");
    }
    const auto& word = take().text;
    return word.starts_with('_') ? word.substr(1) : word;
  }

  /// The comments that stand on lines of their own directly above `line`.
  [[nodiscard]] std::vector<std::string> comments_above(int line) const {
    std::vector<std::string> above;
    auto comment = std::ranges::lower_bound(comments_, line, {}, &IdlComment::line);
    while (comment != comments_.begin()) {
      --comment;
      if (!comment->alone || comment->line != line - static_cast<int>(above.size()) - 1) {
        break;
      }
      above.insert(above.begin(), comment->text);
    }
    return above;
  }

  [[nodiscard]] std::string comment_on(int line) const {
    const auto comment = std::ranges::find_if(
        comments_, [&](const IdlComment& c) { return c.line == line && !c.alone; });
    return comment != comments_.end() ? comment->text : std::string();
  }

  std::vector<Annotation> annotations() {
    std::vector<Annotation> result;
    while (at("@")) {
      Annotation annotation;
      annotation.line = take().line;
      annotation.name = identifier();
      while (accept("::")) {
        annotation.name += "::" + identifier();
      }
      if (accept("(")) {
        arguments(annotation);
      }
      result.push_back(std::move(annotation));
    }
    return result;
  }

  void arguments(Annotation& annotation) {
    while (!accept(")")) {
      std::string name = "value";
      if (peek().kind == IdlToken::Kind::kWord && tokens_[position_ + 1].text == "=") {
        name = take().text;
        take();
      }
      auto& tokens = annotation.arguments[name];
      while (!at(",") && !at(")")) {
        if (peek().kind == IdlToken::Kind::kEnd) {
          fail(peek(), "the parenthesis of @" + annotation.name + " is not closed");
        }
        tokens.push_back(take());
      }
      accept(",");
    }
  }

  static std::string joined(const std::vector<IdlToken>& tokens) {
    std::string text;
    for (const auto& token : tokens) {
      text += token.text;
    }
    return text;
  }

  static std::string argument(const Annotation& annotation, const std::string& name) {
    const auto found = annotation.arguments.find(name);
    return found != annotation.arguments.end() ? joined(found->second) : std::string();
  }

  void definition(const Scope& scope) {
    const int first_line = peek().line;
    const auto notes = annotations();
    if (accept("module")) {
      auto inner = scope;
      inner.push_back(identifier());
      expect("{");
      while (!accept("}")) {
        if (peek().kind == IdlToken::Kind::kEnd) {
          fail(peek(), "module '" + inner.back() + "' is not closed");
        }
        definition(inner);
      }
      expect(";");
    } else if (accept("struct")) {
      structure(scope, notes, first_line);
    } else if (accept("const")) {
      constant(scope, notes, first_line);
    } else if (accept("typedef")) {
      auto type = type_spec(scope);
      const auto at_name = peek();
      const auto name = identifier();
      dimension(type);
      if (!typedefs_.emplace(join(scope, name), std::move(type)).second) {
        fail(at_name, "a second typedef of this name", name);
      }
      expect(";");
    } else {
      fail(peek(), "expected 'module', 'struct', 'const' or 'typedef', found '" + peek().text +
                       "': ROS 2 messages are made of structures and constants");
    }
  }

  static std::string join(const Scope& scope, const std::string& name) {
    std::string joined;
    for (const auto& part : scope) {
      joined += part + "/";
    }
    return joined + name;
  }

  [[nodiscard]] static std::vector<std::string> verbatim_comment(
      const std::vector<Annotation>& notes) {
    std::vector<std::string> lines;
    for (const auto& note : notes) {
      if (note.name != "verbatim" || argument(note, "language") != "comment") {
        continue;
      }
      const auto text = argument(note, "text");
      for (std::size_t begin = 0; begin <= text.size();) {
        const auto end = std::min(text.find('\n', begin), text.size());
        lines.push_back(text.substr(begin, end - begin));
        begin = end + 1;
      }
    }
    return lines;
  }

  /// Those written as comments, then those of @verbatim.
  [[nodiscard]] std::vector<std::string> all_comments(const std::vector<Annotation>& notes,
                                                      int first_line) const {
    auto lines = comments_above(first_line);
    const auto verbatim = verbatim_comment(notes);
    lines.insert(lines.end(), verbatim.begin(), verbatim.end());
    return lines;
  }

  void structure(const Scope& scope, const std::vector<Annotation>& notes, int first_line) {
    const auto at_name = peek();
    Structure structure;
    structure.name = join(scope, identifier());
    structure.location = {path_.file, at_name.line};
    structure.comments = all_comments(notes, first_line);
    if (at(":")) {
      fail(peek(), "a structure cannot be derived from another", structure.name);
    }
    expect("{");
    while (!at("}")) {
      structure.fields.push_back(member(scope));
    }
    if (structure.fields.empty()) {
      fail(at_name,
           "has no member; a structure without fields gets uint8 " + std::string(kPlaceholder),
           structure.name);
    }
    structure.closing_comments = comments_above(take().line);
    expect(";");
    if (std::ranges::find(structures_, structure.name, &Structure::name) != structures_.end()) {
      fail(at_name, "a second structure of this name", structure.name);
    }
    structures_.push_back(std::move(structure));
  }

  Field member(const Scope& scope) {
    const int first_line = peek().line;
    const auto notes = annotations();
    Field field;
    field.type = type_spec(scope);
    const auto at_name = peek();
    field.name = identifier();
    field.location = {path_.file, at_name.line};
    dimension(field.type);
    if (at(",")) {
      fail(peek(), "declare one member at a time", field.name);
    }
    const int last_line = peek().line;
    expect(";");
    field.comments = {all_comments(notes, first_line), comment_on(last_line)};
    for (const auto& note : notes) {
      if (note.name == "default") {
        field.default_value = default_value(note, field);
      } else if (note.name == "unit") {
        field.unit = argument(note, "value");
      } else if (note.name == "key") {
        field.is_key = true;
      } else if (note.name == "optional") {
        fail(at_name, "@optional changes the bytes on the wire, and ROS 2 has no such fields",
             field.name);
      }
    }
    return field;
  }

  [[nodiscard]] std::vector<Value> default_value(const Annotation& note, const Field& field) const {
    const auto found = note.arguments.find("value");
    const Location location{path_.file, note.line};
    if (found == note.arguments.end()) {
      throw DefinitionError(location, field.name, "@default has no value");
    }
    if (field.type.shape != Shape::kSingle) {
      // rosidl writes a list of Python in a string.
      return parse_default(field.type, joined(found->second), location, field.name);
    }
    return {literal(field.type.kind, found->second, location, field.name)};
  }

  static Value literal(Kind kind, const std::vector<IdlToken>& tokens, const Location& location,
                       std::string_view name) {
    const bool is_string = std::ranges::all_of(
        tokens, [](const IdlToken& token) { return token.kind == IdlToken::Kind::kString; });
    if (is_text(kind)) {
      if (!is_string || tokens.empty()) {
        throw DefinitionError(location, name, "expected a string, found '" + joined(tokens) + "'");
      }
      return joined(tokens);
    }
    auto text = joined(tokens);
    if (is_floating_point(kind) && text.size() > 1 && (text.back() == 'f' || text.back() == 'd')) {
      text.pop_back();
    }
    return parse_number(kind, text, true, location, name);
  }

  /// `x[9]`; nothing for `x`.
  void dimension(Type& type) {
    const auto& bracket = peek();
    if (!accept("[")) {
      return;
    }
    if (type.shape != Shape::kSingle) {
      fail(bracket, "arrays of arrays or sequences are not supported");
    }
    type.shape = Shape::kArray;
    type.length = size();
    expect("]");
    if (at("[")) {
      fail(peek(), "arrays of more than one dimension are not supported");
    }
  }

  std::size_t size() {
    const auto& token = take();
    std::size_t value = 0;
    if (token.kind == IdlToken::Kind::kNumber) {
      value = std::get<std::uint64_t>(
          parse_number(Kind::kUInt32, token.text, true, {path_.file, token.line}, ""));
    }
    if (value == 0) {
      fail(token, "expected a size of at least 1, found '" + token.text + "'");
    }
    return value;
  }

  Type type_spec(const Scope& scope) {
    const auto& first = peek();
    if (accept("sequence")) {
      expect("<");
      auto type = type_spec(scope);
      if (type.shape != Shape::kSingle) {
        fail(first, "sequences of arrays or sequences are not supported");
      }
      type.shape = Shape::kSequence;
      if (accept(",")) {
        type.length = size();
      }
      expect(">");
      return type;
    }
    Type type;
    if (at("string") || at("wstring")) {
      type.kind = take().text == "string" ? Kind::kString : Kind::kWString;
      if (accept("<")) {
        type.text_length = size();
        expect(">");
      }
      return type;
    }
    if (const auto primitive = primitive_kind()) {
      type.kind = *primitive;
      return type;
    }
    return named_type(scope);
  }

  /// Takes the words of a primitive type, or nothing.
  std::optional<Kind> primitive_kind() {
    static const std::map<std::string_view, Kind> kSingleWord{
        {"boolean", Kind::kBool},   {"octet", Kind::kOctet},   {"char", Kind::kChar},
        {"int8", Kind::kInt8},      {"uint8", Kind::kUInt8},   {"int16", Kind::kInt16},
        {"uint16", Kind::kUInt16},  {"int32", Kind::kInt32},   {"uint32", Kind::kUInt32},
        {"int64", Kind::kInt64},    {"uint64", Kind::kUInt64}, {"float", Kind::kFloat32},
        {"double", Kind::kFloat64}, {"short", Kind::kInt16}};
    if (peek().kind != IdlToken::Kind::kWord) {
      return std::nullopt;
    }
    if (const auto word = kSingleWord.find(peek().text); word != kSingleWord.end()) {
      take();
      return word->second;
    }
    const bool is_unsigned = accept("unsigned");
    if (is_unsigned && accept("short")) {
      return Kind::kUInt16;
    }
    if (accept("long")) {
      if (at("double")) {
        fail(peek(), "'long double' is not supported");
      }
      if (accept("long")) {
        return is_unsigned ? Kind::kUInt64 : Kind::kInt64;
      }
      return is_unsigned ? Kind::kUInt32 : Kind::kInt32;
    }
    if (is_unsigned) {
      fail(peek(), "expected 'short' or 'long' after 'unsigned'");
    }
    return std::nullopt;
  }

  Type named_type(const Scope& scope) {
    const auto& first = peek();
    const bool absolute = accept("::");
    Scope name{identifier()};
    while (accept("::")) {
      name.push_back(identifier());
    }
    const auto relative = join({name.begin(), name.end() - 1}, name.back());
    // The name is looked for in the innermost scope first.
    for (auto outer = absolute ? Scope{} : scope;; outer.pop_back()) {
      const auto scoped = join(outer, relative);
      if (const auto alias = typedefs_.find(scoped); alias != typedefs_.end()) {
        return alias->second;
      }
      if (outer.empty()) {
        break;
      }
    }
    Type type;
    type.kind = Kind::kMessage;
    // Whether there is such a message is seen when all files are known.
    if (name.size() == 3) {
      type.message = relative;
    } else if (name.size() == 1 && !absolute && scope.size() == 2) {
      type.message = join(scope, relative);
    } else {
      fail(first, "unknown type; a message is named package::msg::Type", scoped_name(relative));
    }
    return type;
  }

  void constant(const Scope& scope, const std::vector<Annotation>& notes, int first_line) {
    const auto& at_type = peek();
    Constant result;
    result.type = type_spec(scope);
    if (result.type.shape != Shape::kSingle || result.type.kind == Kind::kMessage) {
      fail(at_type, "a constant is a number, a truth value or a string");
    }
    const auto at_name = peek();
    result.name = identifier();
    result.location = {path_.file, at_name.line};
    expect("=");
    std::vector<IdlToken> tokens;
    while (!at(";") && peek().kind != IdlToken::Kind::kEnd) {
      tokens.push_back(take());
    }
    result.value = literal(result.type.kind, tokens, result.location, result.name);
    const int last_line = peek().line;
    expect(";");
    result.comments = {all_comments(notes, first_line), comment_on(last_line)};
    constexpr std::string_view kSuffix = "_Constants";
    if (scope.size() != 3 || !scope.back().ends_with(kSuffix)) {
      fail(at_name, "a constant stands in the module Type_Constants of its type", result.name);
    }
    auto owner = join({scope.begin(), scope.end() - 1}, scope.back());
    owner.resize(owner.size() - kSuffix.size());
    constants_.emplace_back(std::move(owner), std::move(result));
  }

  Interface assemble() {
    Interface interface = empty_interface(path_);
    for (auto& part : interface.structures) {
      const auto found = std::ranges::find(structures_, part.name, &Structure::name);
      if (found == structures_.end()) {
        throw DefinitionError({path_.file, 1}, scoped_name(part.name),
                              "the file does not define this structure, which its path promises");
      }
      part = std::move(*found);
      structures_.erase(found);
    }
    if (!structures_.empty()) {
      throw DefinitionError(structures_.front().location, scoped_name(structures_.front().name),
                            "a file defines only the type that its path names");
    }
    for (auto& [owner, value] : constants_) {
      const auto part = std::ranges::find(interface.structures, owner, &Structure::name);
      if (part == interface.structures.end()) {
        throw DefinitionError(value.location, value.name,
                              "there is no structure " + scoped_name(owner));
      }
      part->constants.push_back(std::move(value));
    }
    return interface;
  }

  const DefinitionPath& path_;
  std::vector<IdlToken> tokens_;
  std::vector<IdlComment> comments_;
  std::size_t position_ = 0;
  std::vector<Structure> structures_;
  std::map<std::string, Type> typedefs_;
  std::vector<std::pair<std::string, Constant>> constants_;
};

}  // namespace

Interface parse_idl(std::string_view text, const DefinitionPath& path) {
  auto interface = Parser(tokenize_idl(text, path.file), path).run();
  check_interface(interface);
  return interface;
}

}  // namespace pipescout::generator
