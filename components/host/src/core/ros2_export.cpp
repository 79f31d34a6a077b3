// SPDX-License-Identifier: Apache-2.0
#include "core/ros2_export.hpp"

#include <array>
#include <fstream>
#include <set>
#include <string_view>
#include <system_error>
#include <utility>

#include "core/interfaces.hpp"
#include "pipescout/idl/field_access.hpp"

namespace pipescout::host {
namespace {

namespace fs = std::filesystem;

/// What rosidl's generators cannot carry in a comment: the bytes of UTF-8, which its adapter takes
/// for escapes, and what would end a comment of C.
std::string plain_comment(std::string_view text) {
  constexpr std::array<std::pair<std::string_view, std::string_view>, 17> kReplacements{
      {{"°", "deg"},
       {"µ", "u"},
       {"μ", "u"},
       {"²", "^2"},
       {"³", "^3"},
       {"×", "x"},
       {"·", "*"},
       {"±", "+-"},
       {"≤", "<="},
       {"≥", ">="},
       {"≠", "!="},
       {"–", "-"},
       {"—", "-"},
       {"’", "'"},
       {"…", "..."},
       {"*/", "* /"},
       {"\\", "/"}}};
  std::string plain;
  while (!text.empty()) {
    bool replaced = false;
    for (const auto& [from, to] : kReplacements) {
      if (text.starts_with(from)) {
        plain += to;
        text.remove_prefix(from.size());
        replaced = true;
        break;
      }
    }
    if (replaced) {
      continue;
    }
    const auto byte = static_cast<unsigned char>(text.front());
    if (byte < 0x80) {
      plain += text.front();
    } else if (byte >= 0xC0) {  // the first byte of a character stands for all of it
      plain += '?';
    }
    text.remove_prefix(1);
  }
  return plain;
}

/// The definition with plain comments. rosidl sees a comment at the first '#' of a line.
std::string plain_definition(std::string_view definition) {
  std::string plain;
  for (std::size_t begin = 0; begin < definition.size();) {
    const auto end = std::min(definition.find('\n', begin), definition.size());
    const auto line = definition.substr(begin, end - begin);
    const auto comment = std::min(line.find('#'), line.size());
    plain.append(line.substr(0, comment)).append(plain_comment(line.substr(comment))) += '\n';
    begin = end + 1;
  }
  return plain;
}

/// Throws ExportError for texts that rosidl's .msg files have no way to write.
void check_texts(const MessageType& type) {
  const auto refuse = [&](std::string_view name, const char* why) {
    throw ExportError(std::string(type.name) + ": " + std::string(name) + ": " + why);
  };
  for (const auto& constant : type.constants) {
    if (constant.value.find_first_of("#\n") != std::string_view::npos) {
      refuse(constant.name,
             "in a .msg file a # begins a comment, even in quotes, and each constant has one line");
    }
  }
  for (const auto& field : type.fields) {
    if (field.default_value.find_first_of("#\n=") != std::string_view::npos) {
      refuse(field.name,
             "in a .msg file a # begins a comment and a = defines a constant, even in quotes");
    }
  }
}

void write_file(const fs::path& file, const std::string& text) {
  std::error_code error;
  fs::create_directories(file.parent_path(), error);
  std::ofstream stream(file, std::ios::binary);
  stream << text;
  stream.close();
  if (!stream) {
    throw ExportError(file.string() + ": cannot be written");
  }
}

std::string package_of(std::string_view type_name) {
  return std::string(type_name.substr(0, type_name.find('/')));
}

std::string package_xml(const std::string& package, const std::set<std::string>& dependencies) {
  std::string depends;
  for (const auto& name : dependencies) {
    depends += "  <depend>" + name + "</depend>\n";
  }
  return "<?xml version=\"1.0\"?>\n"
         "<?xml-model href=\"http://download.ros.org/schema/package_format3.xsd\" "
         "schematypens=\"http://www.w3.org/2001/XMLSchema\"?>\n"
         "<package format=\"3\">\n"
         "  <name>" +
         package +
         "</name>\n"
         "  <version>0.1.0</version>\n"
         "  <description>Messages, services and actions of " +
         package +
         ", exported from Pipescout</description>\n"
         "  <maintainer email=\"developers@pipescout.org\">Pipescout developers</maintainer>\n"
         "  <license>Apache-2.0</license>\n\n"
         "  <buildtool_depend>ament_cmake</buildtool_depend>\n"
         "  <buildtool_depend>rosidl_default_generators</buildtool_depend>\n\n" +
         depends + (depends.empty() ? "" : "\n") +
         "  <exec_depend>rosidl_default_runtime</exec_depend>\n\n"
         "  <member_of_group>rosidl_interface_packages</member_of_group>\n\n"
         "  <export>\n"
         "    <build_type>ament_cmake</build_type>\n"
         "  </export>\n"
         "</package>\n";
}

std::string cmake_lists(const std::string& package, const std::vector<std::string>& files,
                        const std::set<std::string>& dependencies) {
  std::string find;
  std::string names;
  for (const auto& name : dependencies) {
    find += "find_package(" + name + " REQUIRED)\n";
    names += " " + name;
  }
  std::string list;
  for (const auto& file : files) {
    list += "  \"" + file + "\"\n";
  }
  return "cmake_minimum_required(VERSION 3.8)\n"
         "project(" +
         package +
         ")\n\n"
         "find_package(ament_cmake REQUIRED)\n"
         "find_package(rosidl_default_generators REQUIRED)\n" +
         find + "\nrosidl_generate_interfaces(${PROJECT_NAME}\n" + list +
         (names.empty() ? "" : "  DEPENDENCIES" + names + "\n") +
         ")\n\n"
         "ament_export_dependencies(rosidl_default_runtime" +
         names + ")\nament_package()\n";
}

}  // namespace

ExportedPackage export_to_ros2(const std::string& package, const fs::path& folder) {
  ExportedPackage result;
  auto named = folder.lexically_normal();
  if (!named.has_filename()) {
    named = named.parent_path();
  }
  result.folder = named.filename() == package ? named : folder / package;
  std::set<std::string> dependencies;
  std::vector<std::string> files;
  std::vector<std::pair<fs::path, std::string>> contents;
  for (const auto& name : known_interfaces()) {
    if (name.package != package) {
      continue;
    }
    std::string text;
    const char* separator = "";
    for (const auto* const part : parts_of(name)) {
      check_texts(*part);
      text += separator + plain_definition(part->definition);
      separator = "---\n";
      for (const auto& field : part->fields) {
        if (field.kind == FieldKind::kMessage) {
          dependencies.insert(package_of(field.message().name));
        }
      }
    }
    if (name.kind == InterfaceKind::kAction) {
      // Its services and topics are made of these.
      dependencies.insert({"action_msgs", "builtin_interfaces", "unique_identifier_msgs"});
    }
    const std::string kind(folder_of(name.kind));
    files.push_back(kind + "/" + name.type + "." + kind);
    contents.emplace_back(result.folder / files.back(), std::move(text));
  }
  if (files.empty()) {
    throw ExportError("unknown package '" + package + "' with messages");
  }
  dependencies.erase(package);
  for (const auto& [file, text] : contents) {
    write_file(file, text);
  }
  write_file(result.folder / "package.xml", package_xml(package, dependencies));
  write_file(result.folder / "CMakeLists.txt", cmake_lists(package, files, dependencies));
  result.interfaces = files.size();
  result.dependencies.assign(dependencies.begin(), dependencies.end());
  return result;
}

}  // namespace pipescout::host
