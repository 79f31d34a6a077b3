// SPDX-License-Identifier: Apache-2.0
#include "idl_emitter.hpp"

#include <algorithm>
#include <cctype>
#include <set>
#include <string_view>
#include <utility>

#include "names.hpp"
#include "type_text.hpp"

namespace pipescout::generator {
namespace {

/// `std_msgs/msg/String` too is a word of IDL, which does not distinguish the cases of letters.
std::string escaped(std::string_view name) {
  return (is_idl_keyword(name) ? "_" : "") + std::string(name);
}

std::string type_name(std::string_view ros_name) {
  const auto parts = split_name(ros_name);
  return parts.package + "::" + parts.folder + "::" + escaped(parts.type);
}

/// For the same reason `uuid` cannot be a member of `UUID`. The names of
/// members are not on the wire.
std::string member_name(std::string_view name, std::string_view structure) {
  const auto same = std::ranges::equal(name, structure, [](char a, char b) {
    return std::tolower(static_cast<unsigned char>(a)) ==
           std::tolower(static_cast<unsigned char>(b));
  });
  return escaped(name) + (same ? "_" : "");
}

class MergedIdlWriter {
 public:
  explicit MergedIdlWriter(const Definitions& definitions) : definitions_(definitions) {}

  void add(const Structure& structure) {
    if (!written_.insert(structure.name).second) {
      return;
    }
    for (const auto& field : structure.fields) {
      if (field.type.kind == Kind::kMessage) {
        add(definitions_.structure(field.type.message));
      }
    }
    const auto parts = split_name(structure.name);
    out_ += "module " + parts.package + " { module " + parts.folder + " {\nstruct " +
            escaped(parts.type) + " {\n";
    for (const auto& field : structure.fields) {
      out_ += "  " + type_text(field.type) + " " + member_name(field.name, parts.type);
      if (field.type.shape == Shape::kArray) {
        out_ += "[" + std::to_string(field.type.length) + "]";
      }
      out_ += ";\n";
    }
    out_ += "};\n}; };\n\n";
  }

  [[nodiscard]] std::string take() { return std::move(out_); }

 private:
  /// But for the length of an array, which stands behind the name.
  static std::string type_text(const Type& type) {
    auto text =
        type.kind == Kind::kMessage ? type_name(type.message) : std::string(idl_name(type.kind));
    if (type.text_length != 0) {
      text += "<" + std::to_string(type.text_length) + ">";
    }
    if (type.shape == Shape::kSequence) {
      text = "sequence<" + text +
             (type.length != 0 ? ", " + std::to_string(type.length) : std::string()) + ">";
    }
    return text;
  }

  const Definitions& definitions_;
  std::set<std::string_view> written_;
  std::string out_;
};

}  // namespace

std::string merged_idl(const std::vector<const Interface*>& interfaces,
                       const Definitions& definitions) {
  MergedIdlWriter writer(definitions);
  for (const auto* const interface : interfaces) {
    for (const auto& structure : interface->structures) {
      writer.add(structure);
    }
  }
  return "// SPDX-License-Identifier: Apache-2.0\n// Generated from the definitions of "
         "messages.\n\n" +
         writer.take();
}

}  // namespace pipescout::generator
