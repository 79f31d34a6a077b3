// SPDX-License-Identifier: Apache-2.0
#include <array>
#include <set>

#include "cpp_emitter.hpp"
#include "msg_emitter.hpp"
#include "names.hpp"
#include "type_text.hpp"

namespace pipescout::generator {
namespace {

/// The enumerators of pipescout::FieldKind, in the order of Kind.
constexpr std::array<std::string_view, 16> kKinds{
    "kBool",   "kOctet", "kChar",   "kInt8",    "kUInt8",   "kInt16",  "kUInt16",  "kInt32",
    "kUInt32", "kInt64", "kUInt64", "kFloat32", "kFloat64", "kString", "kWString", "kMessage"};

std::string field_kind(Kind kind) {
  return "FieldKind::" + std::string(kKinds[static_cast<std::size_t>(kind)]);
}

std::string header_of(const Interface& interface) {
  return interface.package + "/" + interface.folder + "/" + snake_case(interface.name) + ".hpp";
}

class TypeSupportWriter {
 public:
  TypeSupportWriter(const std::string& package, const std::vector<const Interface*>& interfaces,
                    const Definitions& definitions)
      : package_(package), interfaces_(interfaces), definitions_(definitions) {}

  std::string run() {
    out_ += "// SPDX-License-Identifier: Apache-2.0\n// Generated from the definitions of " +
            package_ +
            ".\n#include <array>\n#include <cstddef>\n"
            "#include <pipescout/idl/support/object_type.hpp>\n"
            "#include <pipescout/idl/support/type_support.hpp>\n\n";
    std::set<std::string> headers;
    for (const auto* const interface : interfaces_) {
      headers.insert(header_of(*interface));
    }
    for (const auto& header : headers) {
      out_ += "#include <" + header + ">\n";
    }
    out_ += '\n';
    text_constants();
    out_ += "namespace pipescout {\nnamespace idl {\n\n";
    for (const auto* const interface : interfaces_) {
      for (const auto& structure : interface->structures) {
        cdr_functions(structure);
      }
    }
    out_ += "}  // namespace idl\n\n";
    for (const auto* const interface : interfaces_) {
      for (const auto& structure : interface->structures) {
        type(structure);
      }
    }
    out_ += "}  // namespace pipescout\n\n";
    list();
    return std::move(out_);
  }

 private:
  void text_constants() {
    for (const auto* const interface : interfaces_) {
      for (const auto& structure : interface->structures) {
        for (const auto& constant : structure.constants) {
          if (is_text(constant.type.kind)) {
            out_ += "const " + std::string(cpp_name(constant.type.kind)) + " " +
                    scoped_name(structure.name) + "::" + constant.name + " = " +
                    cpp_literal(constant.type.kind, constant.value) + ";\n\n";
          }
        }
      }
    }
  }

  /// Fields one behind the other whose numbers have the same size lie without a gap in memory as on
  /// the wire, and are copied at once.
  struct Step {
    const Field* first;
    UniformLayout layout;  ///< none: `first` alone, by its type
  };

  [[nodiscard]] std::vector<Step> steps(const Structure& structure) const {
    std::vector<Step> result;
    for (const auto& field : structure.fields) {
      const auto layout = definitions_.uniform_layout(field);
      if (layout && !result.empty() && result.back().layout.number_size == layout->number_size) {
        result.back().layout.count += layout->count;
      } else {
        result.push_back({&field, layout.value_or(UniformLayout{})});
      }
    }
    return result;
  }

  static std::string numbers(const UniformLayout& layout) {
    return "<" + std::to_string(layout.number_size) + ">";
  }

  /// What stands behind the value in a call: the bounds, for types that have them.
  static std::string bounds(const Type& type) {
    return type.text_length != 0 ? ", " + std::to_string(type.text_length) : "";
  }

  /// A sequence of structures whose bytes are copied at once.
  [[nodiscard]] std::optional<UniformLayout> uniform_elements(const Field& field) const {
    if (field.type.shape != Shape::kSequence || field.type.kind != Kind::kMessage) {
      return std::nullopt;
    }
    return definitions_.uniform_layout(definitions_.structure(field.type.message));
  }

  void cdr_functions(const Structure& structure) {
    const auto type = scoped_name(structure.name);
    if (const auto layout = definitions_.uniform_layout(structure)) {
      out_ += "static_assert(sizeof(" + type +
              ") == " + std::to_string(layout->number_size * layout->count) + ");\n\n";
    }
    const auto all = steps(structure);
    write_function(type, all);
    read_function(type, all);
    size_function(type, all);
  }

  void write_function(const std::string& type, const std::vector<Step>& all) {
    out_ += "void write_fields(CdrWriter& cdr, const " + type + "& message) {\n";
    for (const auto& [field, layout] : all) {
      const auto value = "message." + field->name;
      if (layout.count != 0) {
        out_ += "  cdr.numbers" + numbers(layout) + "(bytes_of(message) + offsetof(" + type + ", " +
                field->name + "), " + std::to_string(layout.count) + ");\n";
      } else if (const auto elements = uniform_elements(*field)) {
        out_ += "  cdr.put_uniform" + numbers(*elements) + "(" + value + ", " +
                std::to_string(elements->count) + ");\n";
      } else {
        out_ += "  cdr.put(" + value + bounds(field->type) + ");\n";
      }
    }
    out_ += "}\n\n";
  }

  void read_function(const std::string& type, const std::vector<Step>& all) {
    out_ += "void read_fields(CdrReader& cdr, " + type + "& message) {\n";
    for (const auto& [field, layout] : all) {
      const auto value = "message." + field->name;
      if (layout.count != 0) {
        out_ += "  cdr.numbers" + numbers(layout) + "(bytes_of(message) + offsetof(" + type + ", " +
                field->name + "), " + std::to_string(layout.count) + ");\n";
      } else if (const auto elements = uniform_elements(*field)) {
        out_ += "  cdr.get_uniform" + numbers(*elements) + "(" + value + ", " +
                std::to_string(elements->count) + ");\n";
      } else {
        out_ += "  cdr.get(" + value + bounds(field->type) + ");\n";
      }
    }
    out_ += "}\n\n";
  }

  void size_function(const std::string& type, const std::vector<Step>& all) {
    bool used = false;
    std::string body;
    for (const auto& [field, layout] : all) {
      const auto value = "message." + field->name;
      if (layout.count != 0) {
        body += "  cdr.numbers" + numbers(layout) + "(" + std::to_string(layout.count) + ");\n";
        continue;
      }
      used = true;
      if (const auto elements = uniform_elements(*field)) {
        body += "  cdr.add_uniform" + numbers(*elements) + "(" + value + ".size(), " +
                std::to_string(elements->count) + ");\n";
      } else {
        body += "  cdr.add(" + value + ");\n";
      }
    }
    out_ += "void measure_fields(CdrSize& cdr, const " + type + "& " + (used ? "message" : "") +
            ") {\n" + body + "}\n\n";
  }

  void type(const Structure& structure) {
    const auto type = scoped_name(structure.name);
    out_ += "template <>\nconst MessageType& message_type<" + type + ">() {\n  using T = " + type +
            ";\n";
    out_ += "  static constexpr auto kFields = std::to_array<MessageField>({\n";
    for (const auto& field : structure.fields) {
      out_ += "      " + field_entry(field) + ",\n";
    }
    out_ += "  });\n";
    if (!structure.constants.empty()) {
      out_ += "  static constexpr auto kConstants = std::to_array<MessageConstant>({\n";
      for (const auto& constant : structure.constants) {
        out_ += "      {" + cpp_string(constant.name) + ", " + field_kind(constant.type.kind) +
                ", " + cpp_string(msg_value(constant.value)) + "},\n";
      }
      out_ += "  });\n";
    }
    out_ += "  static constexpr MessageType kType = idl::message_type_of<T>(\n      " +
            cpp_string(structure.name) + ", " + cpp_string(dds_name(structure.name)) +
            ",\n      kFields, " + (structure.constants.empty() ? "{}" : "kConstants") +
            ",\n      " + definition_text(structure) + ");\n  return kType;\n}\n\n";
  }

  /// One string literal a line.
  static std::string definition_text(const Structure& structure) {
    const auto text = msg_text(structure);
    std::string literal;
    for (std::size_t begin = 0; begin < text.size();) {
      const auto end = std::min(text.find('\n', begin), text.size() - 1) + 1;
      literal += (literal.empty() ? "" : "\n      ") + cpp_string(text.substr(begin, end - begin));
      begin = end;
    }
    return literal.empty() ? "\"\"" : literal;
  }

  static std::string field_entry(const Field& field) {
    const auto& type = field.type;
    std::string entry = "{.name = " + cpp_string(field.name) + ", .kind = " + field_kind(type.kind);
    const auto member = "decltype(T::" + field.name + ")";
    switch (type.shape) {
      case Shape::kSingle:
        entry += ", .element_size = sizeof(" + member + ")";
        break;
      case Shape::kArray:
        entry +=
            ", .shape = FieldShape::kArray, .element_size = sizeof(" + member + "::value_type)";
        break;
      case Shape::kSequence:
        entry +=
            ", .shape = FieldShape::kSequence, .element_size = sizeof(" + member + "::value_type)";
        break;
    }
    if (type.length != 0) {
      entry += ", .length = " + std::to_string(type.length);
    }
    if (type.text_length != 0) {
      entry += ", .string_length = " + std::to_string(type.text_length);
    }
    entry += ", .offset = offsetof(T, " + field.name + ")";
    if (type.kind == Kind::kMessage) {
      entry += ", .message = message_type<" + scoped_name(type.message) + ">";
    }
    if (type.shape == Shape::kSequence) {
      entry += ", .sequence = &idl::kSequenceAccess<" + member + ">";
    }
    if (field.default_value) {
      entry += ", .default_value = " + cpp_string(msg_default(field));
    }
    return entry + "}";
  }

  /// The functions by which the library is asked for its types.
  void list() {
    std::size_t count = 0;
    std::string types;
    std::string objects;
    for (const auto* const interface : interfaces_) {
      for (const auto& structure : interface->structures) {
        const auto name = scoped_name(structure.name);
        types += "      &pipescout::message_type<" + name + ">(),\n";
        objects += "      new pipescout::idl::GeneratedObjectType<" + name + ">,\n";
        ++count;
      }
    }
    const auto function = [&](std::string_view result, std::string_view symbol,
                              std::string_view element, const std::string& entries,
                              std::string_view comment) {
      out_ += "extern \"C\" pipescout::idl::" + std::string(result) + " " + std::string(symbol) +
              package_ + "() {\n" + std::string(comment) +
              "  static const std::array<const pipescout::" + std::string(element) + "*, " +
              std::to_string(count) + "> types{\n" + entries +
              "  };\n  return {types.data(), types.size()};\n}\n";
    };
    function("PackageTypes", "pipescout_message_types_of_", "MessageType", types, "");
    out_ += '\n';
    function("PackageObjects", "pipescout_message_objects_of_", "idl::ObjectType", objects,
             "  // Never destroyed, as the types are not.\n");
  }

  const std::string& package_;
  const std::vector<const Interface*>& interfaces_;
  const Definitions& definitions_;
  std::string out_;
};

}  // namespace

std::string cpp_type_support(const std::string& package,
                             const std::vector<const Interface*>& interfaces,
                             const Definitions& definitions) {
  return TypeSupportWriter(package, interfaces, definitions).run();
}

}  // namespace pipescout::generator
