// SPDX-License-Identifier: Apache-2.0
#include <dlfcn.h>

#include <algorithm>
#include <charconv>
#include <fstream>
#include <iterator>
#include <limits>
#include <optional>
#include <set>
#include <utility>

#include "idl_lexer.hpp"
#include "pipescout/idl/message_type.hpp"
#include "pipescout/runtime/introspection.hpp"

namespace pipescout {
namespace {

using Known = std::map<std::string, std::shared_ptr<const MessageDescription>, std::less<>>;

/// What is written before a member's name.
struct TypeSpec {
  FieldKind kind = FieldKind::kBool;
  FieldShape shape = FieldShape::kSingle;
  std::size_t length = 0;
  std::size_t string_length = 0;
  std::shared_ptr<const MessageDescription> message;
};

std::string ros_name(const std::string& scoped) {
  std::string name;
  for (std::size_t i = 0; i < scoped.size(); ++i) {
    if (scoped.compare(i, 2, "::") == 0) {
      name += '/';
      ++i;
    } else {
      name += scoped[i];
    }
  }
  return name;
}

/// A word may be written with a leading '_' so that it is no keyword; it is no part of the name.
std::string unescaped(const std::string& word) {
  return word.front() == '_' && word.size() > 1 ? word.substr(1) : word;
}

/// Reads one file, and through `Loader` those that it includes.
class Loader {
 public:
  Loader(const std::filesystem::path& root, Known& known) : root_(root), known_(known) {}

  void load(const std::string& relative);

 private:
  const std::filesystem::path& root_;
  Known& known_;
  std::set<std::string> done_;
  std::vector<std::string> in_progress_;
};

class Parser {
 public:
  Parser(std::string file, std::vector<IdlToken> tokens, Known& known, Loader& loader)
      : file_(std::move(file)), tokens_(std::move(tokens)), known_(known), loader_(loader) {}

  void run() {
    while (peek().kind != IdlToken::Kind::kEnd) {
      definition("");
    }
    for (auto& [scoped, description] : structs_) {
      if (const auto constants = constants_.find(scoped + "_Constants");
          constants != constants_.end()) {
        description->constants = std::move(constants->second);
      }
      known_.emplace(description->name, std::move(description));
    }
  }

 private:
  [[nodiscard]] const IdlToken& peek() const { return tokens_[position_]; }
  const IdlToken& take() {
    const auto& token = tokens_[position_];
    if (token.kind != IdlToken::Kind::kEnd) {
      ++position_;
    }
    return token;
  }

  [[noreturn]] void fail(const IdlToken& at, const std::string& message) const {
    fail_idl(file_, at.line, at.column, message);
  }

  [[nodiscard]] bool at(std::string_view text) const {
    const auto& token = peek();
    return token.text == text &&
           (token.kind == IdlToken::Kind::kPunctuation || token.kind == IdlToken::Kind::kWord);
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

  std::string identifier() {
    if (peek().kind != IdlToken::Kind::kWord) {
      fail(peek(), "expected a name, found '" + peek().text + "'");
    }
    return unescaped(take().text);
  }

  /// `@default(value=0.0)`, `@verbatim (language="comment", text="...")`.
  void skip_annotations() {
    while (accept("@")) {
      identifier();
      if (!accept("(")) {
        continue;
      }
      for (int depth = 1; depth > 0;) {
        if (peek().kind == IdlToken::Kind::kEnd) {
          fail(peek(), "annotation is not closed");
        }
        depth += at("(") ? 1 : (at(")") ? -1 : 0);
        take();
      }
    }
  }

  void definition(const std::string& scope) {
    skip_annotations();
    if (peek().kind == IdlToken::Kind::kInclude) {
      loader_.load(take().text);
    } else if (accept("module")) {
      const auto name = scope + identifier();
      expect("{");
      while (!at("}")) {
        definition(name + "::");
      }
      take();
      expect(";");
    } else if (accept("struct")) {
      structure(scope);
    } else if (accept("const")) {
      constant(scope);
    } else if (accept("typedef")) {
      auto type = type_spec(scope);
      const auto name = identifier();
      dimension(type);
      typedefs_[scope + name] = std::move(type);
      expect(";");
    } else {
      fail(peek(),
           "expected 'module', 'struct', 'const' or 'typedef', found '" + peek().text + "'");
    }
  }

  void structure(const std::string& scope) {
    const auto at_name = peek();
    const auto scoped = scope + identifier();
    auto description = std::make_shared<MessageDescription>();
    description->name = ros_name(scoped);
    expect("{");
    while (!at("}")) {
      skip_annotations();
      auto type = type_spec(scope);
      const auto at_member = peek();
      FieldDescription field;
      field.name = identifier();
      dimension(type);
      expect(";");
      if (std::any_of(description->fields.begin(), description->fields.end(),
                      [&](const auto& other) { return other.name == field.name; })) {
        fail(at_member, "a second member '" + field.name + "'");
      }
      field.kind = type.kind;
      field.shape = type.shape;
      field.length = type.length;
      field.string_length = type.string_length;
      field.message = std::move(type.message);
      description->fields.push_back(std::move(field));
    }
    if (description->fields.empty()) {
      fail(at_name, "struct '" + scoped + "' has no member");
    }
    take();
    expect(";");
    if (known_.contains(description->name) ||
        !structs_.emplace(scoped, std::move(description)).second) {
      fail(at_name, "a second struct '" + scoped + "'");
    }
  }

  /// `x[9]`; nothing for `x`.
  void dimension(TypeSpec& type) {
    const auto& bracket = peek();
    if (!accept("[")) {
      return;
    }
    if (type.shape != FieldShape::kSingle) {
      fail(bracket, "arrays of arrays or sequences are not supported");
    }
    type.shape = FieldShape::kArray;
    type.length = size();
    expect("]");
    if (at("[")) {
      fail(peek(), "arrays of more than one dimension are not supported");
    }
  }

  std::size_t size() {
    const auto& token = take();
    std::size_t value = 0;
    const auto* last = token.text.data() + token.text.size();
    if (token.kind != IdlToken::Kind::kNumber ||
        std::from_chars(token.text.data(), last, value).ptr != last || value == 0) {
      fail(token, "expected a size of at least 1, found '" + token.text + "'");
    }
    return value;
  }

  TypeSpec type_spec(const std::string& scope) {
    const auto& first = peek();
    if (accept("sequence")) {
      expect("<");
      auto type = type_spec(scope);
      if (type.shape != FieldShape::kSingle) {
        fail(first, "sequences of arrays or sequences are not supported");
      }
      type.shape = FieldShape::kSequence;
      if (accept(",")) {
        type.length = size();
      }
      expect(">");
      return type;
    }
    TypeSpec type;
    if (accept("string")) {
      type.kind = FieldKind::kString;
      if (accept("<")) {
        type.string_length = size();
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
  std::optional<FieldKind> primitive_kind() {
    static const std::map<std::string_view, FieldKind> kSingleWord{
        {"boolean", FieldKind::kBool},   {"octet", FieldKind::kOctet},
        {"char", FieldKind::kChar},      {"int8", FieldKind::kInt8},
        {"uint8", FieldKind::kUInt8},    {"int16", FieldKind::kInt16},
        {"uint16", FieldKind::kUInt16},  {"int32", FieldKind::kInt32},
        {"uint32", FieldKind::kUInt32},  {"int64", FieldKind::kInt64},
        {"uint64", FieldKind::kUInt64},  {"float", FieldKind::kFloat32},
        {"double", FieldKind::kFloat64}, {"short", FieldKind::kInt16}};
    if (peek().kind != IdlToken::Kind::kWord) {
      return std::nullopt;
    }
    if (const auto word = kSingleWord.find(peek().text); word != kSingleWord.end()) {
      take();
      return word->second;
    }
    const bool is_unsigned = accept("unsigned");
    if (is_unsigned && accept("short")) {
      return FieldKind::kUInt16;
    }
    if (accept("long")) {
      if (at("double")) {
        fail(peek(), "'long double' is not supported");
      }
      if (accept("long")) {
        return is_unsigned ? FieldKind::kUInt64 : FieldKind::kInt64;
      }
      return is_unsigned ? FieldKind::kUInt32 : FieldKind::kInt32;
    }
    if (is_unsigned) {
      fail(peek(), "expected 'short' or 'long' after 'unsigned'");
    }
    return std::nullopt;
  }

  [[nodiscard]] std::shared_ptr<const MessageDescription> find_struct(
      const std::string& scoped) const {
    if (const auto own = structs_.find(scoped); own != structs_.end()) {
      return own->second;
    }
    const auto included = known_.find(ros_name(scoped));
    return included != known_.end() ? included->second : nullptr;
  }

  TypeSpec named_type(const std::string& scope) {
    const auto& first = peek();
    const bool absolute = accept("::");
    auto name = identifier();
    while (accept("::")) {
      name += "::" + identifier();
    }
    // The name is looked for in the innermost scope first. `outer` ends with "::" or is empty.
    for (std::string outer = absolute ? "" : scope;;) {
      const auto scoped = outer + name;
      if (const auto alias = typedefs_.find(scoped); alias != typedefs_.end()) {
        return alias->second;
      }
      if (auto message = find_struct(scoped)) {
        TypeSpec type;
        type.kind = FieldKind::kMessage;
        type.message = std::move(message);
        return type;
      }
      if (outer.empty()) {
        fail(first, "unknown type '" + name + "'");
      }
      const auto separator =
          outer.size() > 2 ? outer.rfind("::", outer.size() - 3) : std::string::npos;
      outer.resize(separator == std::string::npos ? 0 : separator + 2);
    }
  }

  void constant(const std::string& scope) {
    const auto& at_type = peek();
    const auto type = type_spec(scope);
    if (type.shape != FieldShape::kSingle || type.kind == FieldKind::kMessage) {
      fail(at_type, "a constant is a number, a truth value or a string");
    }
    ConstantDescription result;
    result.name = identifier();
    result.kind = type.kind;
    expect("=");
    if (type.kind == FieldKind::kString) {
      std::string text;
      if (peek().kind != IdlToken::Kind::kString) {
        fail(peek(), "expected a string, found '" + peek().text + "'");
      }
      while (peek().kind == IdlToken::Kind::kString) {
        text += take().text;
      }
      result.value = std::move(text);
    } else {
      result.value = scalar(type.kind);
    }
    expect(";");
    // `scope` ends with "::": constants of Type are in the module Type_Constants.
    if (scope.size() > 2) {
      constants_[scope.substr(0, scope.size() - 2)].push_back(std::move(result));
    }
  }

  ScalarValue scalar(FieldKind kind) {
    if (kind == FieldKind::kBool) {
      if (accept("TRUE") || accept("true")) {
        return true;
      }
      if (accept("FALSE") || accept("false")) {
        return false;
      }
      fail(peek(), "expected TRUE or FALSE, found '" + peek().text + "'");
    }
    const bool negative = accept("-");
    if (!negative) {
      accept("+");
    }
    const auto& token = take();
    if (token.kind != IdlToken::Kind::kNumber) {
      fail(token, "expected a number, found '" + token.text + "'");
    }
    if (kind == FieldKind::kFloat32 || kind == FieldKind::kFloat64) {
      double value = 0.0;
      const auto* last = token.text.data() + token.text.size();
      const auto [end, error] = std::from_chars(token.text.data(), last, value);
      if (end != last || error != std::errc{}) {
        fail(token, "'" + token.text + "' is no number");
      }
      return negative ? -value : value;
    }
    return integer(kind, token, negative);
  }

  ScalarValue integer(FieldKind kind, const IdlToken& token, bool negative) const {
    std::string_view digits = token.text;
    int base = 10;
    if (digits.size() > 2 && (digits.substr(0, 2) == "0x" || digits.substr(0, 2) == "0X")) {
      digits.remove_prefix(2);
      base = 16;
    } else if (digits.size() > 1 && digits[0] == '0') {
      base = 8;
    }
    std::uint64_t magnitude = 0;
    const auto* last = digits.data() + digits.size();
    const auto [end, error] = std::from_chars(digits.data(), last, magnitude, base);
    if (end != last || error != std::errc{}) {
      fail(token, "'" + token.text + "' is no whole number of 64 bits");
    }
    const auto bits = static_cast<unsigned>(8 * size_of(kind));
    const bool is_signed = kind == FieldKind::kInt8 || kind == FieldKind::kInt16 ||
                           kind == FieldKind::kInt32 || kind == FieldKind::kInt64;
    const std::uint64_t largest =
        std::numeric_limits<std::uint64_t>::max() >> (64U - bits + (is_signed ? 1U : 0U));
    const std::uint64_t limit = negative ? (is_signed ? largest + 1 : 0) : largest;
    if (magnitude > limit) {
      fail(token, std::string(negative ? "-" : "") + token.text + " does not fit into " +
                      std::string(to_string(kind)));
    }
    if (is_signed) {
      return static_cast<std::int64_t>(negative ? ~magnitude + 1 : magnitude);
    }
    return magnitude;
  }

  std::string file_;
  std::vector<IdlToken> tokens_;
  std::size_t position_ = 0;
  Known& known_;
  Loader& loader_;
  /// By scoped name, of this file only; the structs are made known when all of it was read.
  std::map<std::string, std::shared_ptr<MessageDescription>> structs_;
  std::map<std::string, TypeSpec> typedefs_;
  std::map<std::string, std::vector<ConstantDescription>> constants_;
};

void Loader::load(const std::string& relative) {
  if (std::find(in_progress_.begin(), in_progress_.end(), relative) != in_progress_.end()) {
    throw IdlError((root_ / relative).string() + ": includes itself");
  }
  // A file whose types are known was read on behalf of an earlier question.
  const auto type = std::filesystem::path(relative).replace_extension().generic_string();
  if (!done_.insert(relative).second || known_.contains(type) ||
      known_.contains(type + "_Request")) {
    return;
  }
  const auto path = root_ / relative;
  std::ifstream stream(path, std::ios::binary);
  if (!stream) {
    throw IdlError(path.string() + ": cannot be read");
  }
  const std::string text{std::istreambuf_iterator<char>(stream), std::istreambuf_iterator<char>()};
  in_progress_.push_back(relative);
  Parser(path.string(), tokenize_idl(text, path.string()), known_, *this).run();
  in_progress_.pop_back();
}

std::filesystem::path installed_root() {
  // The tree is installed with the library that holds the wire types, so they always agree.
  Dl_info library{};
  const auto* symbol = reinterpret_cast<const void*>(&find_message_type);
  if (dladdr(symbol, &library) == 0 || library.dli_fname == nullptr) {
    throw IdlError("the library of wire types cannot be found");
  }
  std::error_code error;
  const auto file = std::filesystem::canonical(library.dli_fname, error);
  // <prefix>/lib[/<architecture>]/libpipescout_idl.so
  for (auto prefix = file.parent_path().parent_path(); prefix != prefix.root_path();
       prefix = prefix.parent_path()) {
    const auto root = prefix / "share" / "pipescout_idl" / "idl";
    if (std::filesystem::is_directory(root, error)) {
      return root;
    }
  }
  throw IdlError("no share/pipescout_idl/idl beside " + file.string());
}

}  // namespace

MessageDescriptions::MessageDescriptions(std::filesystem::path root) : root_(std::move(root)) {}

MessageDescriptions& MessageDescriptions::installed() {
  static MessageDescriptions descriptions(installed_root());
  return descriptions;
}

std::shared_ptr<const MessageDescription> MessageDescriptions::find(std::string_view type) {
  const std::lock_guard lock(mutex_);
  if (const auto known = known_.find(type); known != known_.end()) {
    return known->second;
  }
  // The name becomes part of a path: nothing but package/kind/Type may pass.
  const bool plain = std::count(type.begin(), type.end(), '/') == 2 && type.front() != '/' &&
                     std::all_of(type.begin(), type.end(), [](char c) {
                       return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') ||
                              (c >= '0' && c <= '9') || c == '_' || c == '/';
                     });
  if (!plain) {
    throw IdlError("'" + std::string(type) + "' is no type name: package/msg/Type");
  }
  std::string file(type);
  for (const std::string_view half : {"_Request", "_Response"}) {
    if (type.find("/srv/") != std::string_view::npos && type.ends_with(half)) {
      file.resize(file.size() - half.size());
    }
  }
  file += ".idl";
  if (!std::filesystem::is_regular_file(root_ / file)) {
    throw IdlError("unknown type '" + std::string(type) + "': there is no " +
                   (root_ / file).string());
  }
  Loader(root_, known_).load(file);
  if (const auto known = known_.find(type); known != known_.end()) {
    return known->second;
  }
  throw IdlError((root_ / file).string() + ": has no struct '" + std::string(type) + "'");
}

}  // namespace pipescout
