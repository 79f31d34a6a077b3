// SPDX-License-Identifier: Apache-2.0
#include "interface_parts.hpp"

#include <set>
#include <utility>

#include "definition_error.hpp"
#include "names.hpp"
#include "values.hpp"

namespace pipescout::generator {
namespace {

Type message(std::string name) {
  Type type;
  type.kind = Kind::kMessage;
  type.message = std::move(name);
  return type;
}

Type number(Kind kind) {
  Type type;
  type.kind = kind;
  return type;
}

}  // namespace

Interface empty_interface(const DefinitionPath& path) {
  Interface interface;
  interface.package = path.package;
  interface.kind = path.kind;
  interface.name = path.name;
  interface.folder = folder_of(path.kind);
  interface.file = path.file;
  const auto add = [&](std::string_view suffix) {
    Structure structure;
    structure.name = path.package + "/" + interface.folder + "/" + path.name + std::string(suffix);
    structure.location = {path.file, 1};
    interface.structures.push_back(std::move(structure));
  };
  switch (path.kind) {
    case InterfaceKind::kMessage:
      add("");
      break;
    case InterfaceKind::kService:
      add("_Request");
      add("_Response");
      break;
    case InterfaceKind::kAction:
      add("_Goal");
      add("_Result");
      add("_Feedback");
      break;
  }
  return interface;
}

void check_interface(const Interface& interface) {
  const Location location{interface.file, 1};
  check_package_name(interface.package, location);
  check_type_name(interface.name, location);
  for (const auto& structure : interface.structures) {
    std::set<std::string_view> names;
    for (const auto& constant : structure.constants) {
      check_constant_name(constant.name, constant.location);
      if (!names.insert(constant.name).second) {
        throw DefinitionError(constant.location, constant.name, "a second constant of this name");
      }
    }
    for (const auto& field : structure.fields) {
      check_field_name(field.name, field.location);
      if (!names.insert(field.name).second) {
        throw DefinitionError(field.location, field.name, "a second field of this name");
      }
      check_default(field);
    }
  }
}

void add_action_structures(Interface& action) {
  const auto base = action.package + "/" + action.folder + "/" + action.name;
  const auto location = action.structures.front().location;
  const auto add = [&](std::string_view suffix, std::vector<std::pair<std::string, Type>> fields) {
    Structure structure;
    structure.name = base + std::string(suffix);
    structure.location = location;
    for (auto& [name, type] : fields) {
      Field field;
      field.name = std::move(name);
      field.type = std::move(type);
      field.location = location;
      structure.fields.push_back(std::move(field));
    }
    action.structures.push_back(std::move(structure));
  };
  const auto goal_id = message("unique_identifier_msgs/msg/UUID");
  add("_SendGoal_Request", {{"goal_id", goal_id}, {"goal", message(base + "_Goal")}});
  add("_SendGoal_Response",
      {{"accepted", number(Kind::kBool)}, {"stamp", message("builtin_interfaces/msg/Time")}});
  add("_GetResult_Request", {{"goal_id", goal_id}});
  add("_GetResult_Response",
      {{"status", number(Kind::kInt8)}, {"result", message(base + "_Result")}});
  add("_FeedbackMessage", {{"goal_id", goal_id}, {"feedback", message(base + "_Feedback")}});
}

}  // namespace pipescout::generator
