// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <set>

#include "cpp_emitter.hpp"
#include "names.hpp"
#include "type_text.hpp"

namespace pipescout::generator {
namespace {

class HeaderWriter {
 public:
  explicit HeaderWriter(const Interface& interface) : interface_(interface) {}

  std::string run() {
    out_ += "// SPDX-License-Identifier: Apache-2.0\n// Generated from the definition of " +
            interface_.package + "/" + interface_.folder + "/" + interface_.name +
            ".\n#pragma once\n\n";
    includes();
    const auto space = interface_.package + "::" + interface_.folder;
    out_ += "namespace " + space + " {\n\n";
    for (const auto& structure : interface_.structures) {
      write(structure);
    }
    if (interface_.kind == InterfaceKind::kService) {
      service_tag();
    } else if (interface_.kind == InterfaceKind::kAction) {
      action_tag();
    }
    out_ += "}  // namespace " + space + "\n\nnamespace pipescout {\n\n";
    for (const auto& structure : interface_.structures) {
      out_ +=
          "template <>\nconst MessageType& message_type<" + scoped_name(structure.name) + ">();\n";
    }
    if (interface_.kind == InterfaceKind::kService) {
      service_type(scoped(""), scoped("_Request"), scoped("_Response"), ros_name());
    } else if (interface_.kind == InterfaceKind::kAction) {
      action_types();
    }
    cdr_functions();
    out_ += "\n}  // namespace pipescout\n";
    return std::move(out_);
  }

 private:
  [[nodiscard]] std::string ros_name() const {
    return interface_.package + "/" + interface_.folder + "/" + interface_.name;
  }

  [[nodiscard]] std::string scoped(std::string_view suffix) const {
    return scoped_name(ros_name()) + std::string(suffix);
  }

  void includes() {
    std::set<std::string> standard{"cstddef", "cstdint", "memory"};
    std::set<std::string> own;
    bool bounded = false;
    for (const auto& structure : interface_.structures) {
      for (const auto& constant : structure.constants) {
        if (is_text(constant.type.kind)) {
          standard.insert("string");
        } else if (is_floating_point(constant.type.kind)) {
          standard.insert("limits");
        }
      }
      for (const auto& field : structure.fields) {
        bounded |= field.type.shape == Shape::kSequence && field.type.length != 0;
        if (is_text(field.type.kind)) {
          standard.insert("string");
        } else if (field.default_value) {
          standard.insert("limits");
        }
        if (field.type.shape != Shape::kSingle) {
          standard.insert(field.type.shape == Shape::kArray ? "array" : "vector");
        }
        if (field.type.kind == Kind::kMessage) {
          const auto name = defining_interface(field.type.message);
          if (name != ros_name()) {
            const auto parts = split_name(name);
            own.insert(parts.package + "/" + parts.folder + "/" + snake_case(parts.type) + ".hpp");
          }
        }
      }
    }
    if (interface_.kind == InterfaceKind::kAction) {
      own.insert("action_msgs/msg/goal_status_array.hpp");
      own.insert("action_msgs/srv/cancel_goal.hpp");
    }
    for (const auto& name : standard) {
      out_ += "#include <" + name + ">\n";
    }
    out_ += '\n';
    if (interface_.kind == InterfaceKind::kAction) {
      out_ += "#include <pipescout/idl/action_type.hpp>\n";
    }
    if (bounded) {
      out_ += "#include <pipescout/idl/bounded_vector.hpp>\n";
    }
    out_ += "#include <pipescout/idl/message_type.hpp>\n";
    if (interface_.kind != InterfaceKind::kMessage) {
      out_ += "#include <pipescout/idl/service_type.hpp>\n";
    }
    for (const auto& name : own) {
      out_ += "#include <" + name + ">\n";
    }
    out_ += '\n';
  }

  void comments(const std::vector<std::string>& lines, std::string_view indent) {
    for (const auto& line : lines) {
      out_ += std::string(indent) + "///" + (line.empty() ? "" : " " + escaped(line)) + "\n";
    }
  }

  /// A backslash at the end would continue the comment onto the next line.
  static std::string escaped(std::string line) {
    if (line.ends_with('\\')) {
      line += '.';
    }
    return line;
  }

  [[nodiscard]] std::string trailing(const Comments& comments, std::string_view unit) const {
    auto text = comments.trailing;
    if (!unit.empty()) {
      text = text.empty() ? std::string(unit) : text + " (" + std::string(unit) + ")";
    }
    return text.empty() ? "" : "  ///< " + escaped(text);
  }

  void write(const Structure& structure) {
    const auto name = split_name(structure.name).type;
    comments(structure.comments, "");
    out_ += "struct " + name + " {\n";
    for (const auto& constant : structure.constants) {
      comments(constant.comments.above, "  ");
      const auto note = trailing(constant.comments, "") + "\n";
      if (is_text(constant.type.kind)) {
        out_ += "  static const " + std::string(cpp_name(constant.type.kind)) + " " +
                constant.name + ";" + note;
      } else {
        out_ += "  static constexpr " + std::string(cpp_name(constant.type.kind)) + " " +
                constant.name + " = " + cpp_literal(constant.type.kind, constant.value) + ";" +
                note;
      }
    }
    if (!structure.constants.empty()) {
      out_ += '\n';
    }
    for (const auto& field : structure.fields) {
      comments(field.comments.above, "  ");
      out_ += "  " + cpp_type(field.type) + " " + field.name + initialiser(field) + ";" +
              trailing(field.comments, field.unit) + "\n";
    }
    out_ += "\n  bool operator==(const " + name + "&) const = default;\n\n";
    pointers(name);
    out_ += "};\n\n";
  }

  static std::string initialiser(const Field& field) {
    const auto& type = field.type;
    if (field.default_value) {
      std::string list;
      for (const auto& value : *field.default_value) {
        list += (list.empty() ? "" : ", ") + cpp_literal(type.kind, value);
      }
      return type.shape == Shape::kSingle ? " = " + list : "{" + list + "}";
    }
    if (type.shape != Shape::kSingle || type.kind == Kind::kMessage || is_text(type.kind)) {
      return "{}";
    }
    if (type.kind == Kind::kBool) {
      return " = false";
    }
    return type.kind == Kind::kFloat32    ? " = 0.0f"
           : is_floating_point(type.kind) ? " = 0.0"
                                          : " = 0";
  }

  /// The names that rosidl declares, and code written for rclcpp uses.
  void pointers(const std::string& name) {
    out_ += "  using RawPtr = " + name + "*;\n  using ConstRawPtr = const " + name + "*;\n";
    out_ += "  using SharedPtr = std::shared_ptr<" + name + ">;\n";
    out_ += "  using ConstSharedPtr = std::shared_ptr<const " + name + ">;\n";
    out_ += "  using WeakPtr = std::weak_ptr<" + name + ">;\n";
    out_ += "  using ConstWeakPtr = std::weak_ptr<const " + name + ">;\n";
    out_ += "  template <class Deleter = std::default_delete<" + name + ">>\n";
    out_ += "  using UniquePtrWithDeleter = std::unique_ptr<" + name + ", Deleter>;\n";
    out_ += "  using UniquePtr = UniquePtrWithDeleter<>;\n";
    out_ += "  template <class Deleter = std::default_delete<" + name + ">>\n";
    out_ += "  using ConstUniquePtrWithDeleter = std::unique_ptr<const " + name + ", Deleter>;\n";
    out_ += "  using ConstUniquePtr = ConstUniquePtrWithDeleter<>;\n";
  }

  void service_tag() {
    out_ += "struct " + interface_.name + " {\n  using Request = " + interface_.name +
            "_Request;\n  using Response = " + interface_.name + "_Response;\n};\n\n";
  }

  void action_tag() {
    const auto& name = interface_.name;
    for (const std::string service : {"_SendGoal", "_GetResult"}) {
      out_ += "struct " + name + service + " {\n  using Request = " + name + service +
              "_Request;\n  using Response = " + name + service + "_Response;\n};\n\n";
    }
    out_ += "struct " + name + " {\n";
    for (const std::string part : {"Goal", "Result", "Feedback"}) {
      out_ += "  using " + part + " = " + name + "_" + part + ";\n";
    }
    out_ += "\n  struct Impl {\n";
    out_ += "    using SendGoalService = " + name + "_SendGoal;\n";
    out_ += "    using GetResultService = " + name + "_GetResult;\n";
    out_ += "    using FeedbackMessage = " + name + "_FeedbackMessage;\n";
    out_ += "    using CancelGoalService = action_msgs::srv::CancelGoal;\n";
    out_ += "    using GoalStatusMessage = action_msgs::msg::GoalStatusArray;\n";
    out_ += "  };\n};\n\n";
  }

  void service_type(const std::string& tag, const std::string& request, const std::string& response,
                    const std::string& name) {
    out_ += "\ntemplate <>\nstruct ServiceType<" + tag + "> {\n  using Request = " + request +
            ";\n  using Response = " + response +
            ";\n  static constexpr std::string_view service_name = \"" + name + "\";\n};\n";
  }

  void action_types() {
    for (const std::string service : {"_SendGoal", "_GetResult"}) {
      service_type(scoped(service), scoped(service + "_Request"), scoped(service + "_Response"),
                   ros_name() + service);
    }
    out_ += "\ntemplate <>\nstruct ActionType<" + scoped("") + "> {\n";
    for (const std::string part : {"Goal", "Result", "Feedback", "FeedbackMessage"}) {
      out_ += "  using " + part + " = " + scoped("_" + part) + ";\n";
    }
    for (const std::string service : {"SendGoal", "GetResult"}) {
      out_ += "  using " + service + " = " + scoped("_" + service) + ";\n";
    }
    out_ += "  static constexpr std::string_view action_name = \"" + ros_name() + "\";\n};\n";
  }

  void cdr_functions() {
    out_ += "\nnamespace idl {\n\n";
    for (const auto& structure : interface_.structures) {
      const auto type = scoped_name(structure.name);
      out_ += "void write_fields(CdrWriter& cdr, const " + type + "& message);\n";
      out_ += "void read_fields(CdrReader& cdr, " + type + "& message);\n";
      out_ += "void measure_fields(CdrSize& cdr, const " + type + "& message);\n";
    }
    out_ += "\n}  // namespace idl\n";
  }

  const Interface& interface_;
  std::string out_;
};

}  // namespace

std::string cpp_header(const Interface& interface) {
  return HeaderWriter(interface).run();
}

}  // namespace pipescout::generator
