// SPDX-License-Identifier: Apache-2.0
#include "core/interfaces.hpp"

#include <algorithm>
#include <stdexcept>

#include "pipescout/idl/field_access.hpp"

namespace pipescout::host {
namespace {

std::string_view without_comment(std::string_view line) {
  line = line.substr(0, line.find('#'));
  const auto last = line.find_last_not_of(" \t");
  return line.substr(0, last == std::string_view::npos ? 0 : last + 1);
}

/// The field that a line of a definition declares, or nullptr.
const MessageField* field_of_line(std::string_view line, const MessageType& type) {
  const auto declaration = without_comment(line);
  const auto space = declaration.find(' ');
  if (space == std::string_view::npos) {
    return nullptr;
  }
  const auto name_begin = std::min(declaration.find_first_not_of(' ', space), declaration.size());
  const auto name_end = std::min(declaration.find_first_of(" =", name_begin), declaration.size());
  return find_field(type, declaration.substr(name_begin, name_end - name_begin));
}

void show(const MessageType& type, std::size_t depth, const ShowOptions& options,
          std::string& out) {
  const bool comments = !options.no_comments && (depth == 0 || options.all_comments);
  for (std::size_t begin = 0; begin < type.definition.size();) {
    const auto end = std::min(type.definition.find('\n', begin), type.definition.size());
    const auto whole = type.definition.substr(begin, end - begin);
    begin = end + 1;
    const auto line = comments ? whole : without_comment(whole);
    // Without its comments a nested definition is a list without gaps.
    if (line.empty() && (depth > 0 || !comments)) {
      continue;
    }
    out.append(depth, '\t').append(line) += '\n';
    const auto* const field = field_of_line(whole, type);
    if (field != nullptr && field->kind == FieldKind::kMessage) {
      show(field->message(), depth + 1, options, out);
    }
  }
}

/// Takes `suffix` from the end of the text.
bool remove_suffix(std::string& text, std::string_view suffix) {
  if (!text.ends_with(suffix) || text.size() == suffix.size()) {
    return false;
  }
  text.resize(text.size() - suffix.size());
  return true;
}

}  // namespace

std::string_view folder_of(InterfaceKind kind) noexcept {
  return kind == InterfaceKind::kMessage   ? "msg"
         : kind == InterfaceKind::kService ? "srv"
                                           : "action";
}

std::string InterfaceName::text() const {
  return package + "/" + std::string(folder_of(kind)) + "/" + type;
}

InterfaceName parse_interface_name(std::string_view text) {
  const auto first = text.find('/');
  const auto second = first == std::string_view::npos ? first : text.find('/', first + 1);
  if (second == std::string_view::npos || first == 0 || second == first + 1 ||
      second + 1 == text.size() || text.find('/', second + 1) != std::string_view::npos) {
    throw std::invalid_argument("'" + std::string(text) +
                                "' is not the name of an interface: package/msg/Type");
  }
  InterfaceName name{std::string(text.substr(0, first)), InterfaceKind::kMessage,
                     std::string(text.substr(second + 1))};
  const auto folder = text.substr(first + 1, second - first - 1);
  if (folder == "srv") {
    name.kind = InterfaceKind::kService;
  } else if (folder == "action") {
    name.kind = InterfaceKind::kAction;
  } else if (folder != "msg") {
    throw std::invalid_argument("'" + std::string(text) +
                                "' is not the name of an interface: neither msg, srv nor action");
  }
  return name;
}

std::vector<InterfaceName> known_interfaces() {
  std::vector<InterfaceName> names;
  for (const auto& type : known_message_types()) {
    auto name = parse_interface_name(type);
    // One of the parts stands for the whole.
    if (name.kind == InterfaceKind::kMessage ||
        (name.kind == InterfaceKind::kService && remove_suffix(name.type, "_Request")) ||
        (name.kind == InterfaceKind::kAction && remove_suffix(name.type, "_Goal"))) {
      names.push_back(std::move(name));
    }
  }
  std::ranges::sort(names, {}, &InterfaceName::text);
  return names;
}

std::vector<const MessageType*> parts_of(const InterfaceName& name) {
  std::vector<std::string_view> suffixes{""};
  if (name.kind == InterfaceKind::kService) {
    suffixes = {"_Request", "_Response"};
  } else if (name.kind == InterfaceKind::kAction) {
    suffixes = {"_Goal", "_Result", "_Feedback"};
  }
  std::vector<const MessageType*> parts;
  for (const auto suffix : suffixes) {
    parts.push_back(&load_message_type(name.text() + std::string(suffix)));
  }
  return parts;
}

std::string show_interface(const InterfaceName& name, const ShowOptions& options) {
  std::string text;
  const char* separator = "";
  for (const auto* const part : parts_of(name)) {
    text += separator;
    separator = "---\n";
    show(*part, 0, options, text);
  }
  return text;
}

}  // namespace pipescout::host
