// SPDX-License-Identifier: Apache-2.0
#include "installed_definitions.hpp"

#include <algorithm>
#include <array>
#include <fstream>
#include <system_error>

#include "names.hpp"
#include "pipescout/idl/message_type.hpp"

namespace pipescout::idl {

std::filesystem::path definition_list(const std::filesystem::path& prefix,
                                      const std::string& package) {
  return prefix / "share/ament_index/resource_index/rosidl_interfaces" / package;
}

std::vector<std::string> read_definition_list(const std::filesystem::path& list) {
  const auto package = list.filename().string();
  std::ifstream stream(list);
  std::vector<std::string> names;
  for (std::string line; std::getline(stream, line);) {
    // "msg/Header.idl". Behind a service stand the .msg files of its halves, which are no messages.
    const std::filesystem::path file(line.substr(0, line.find_last_not_of(" \t\r") + 1));
    const auto folder = file.parent_path().string();
    const auto extension = file.extension().string();
    if ((folder == "msg" || folder == "srv" || folder == "action") &&
        (extension == ".idl" || extension == "." + folder)) {
      names.push_back(package + "/" + folder + "/" + file.stem().string());
    }
  }
  if (!stream.eof()) {
    throw MessageTypeError(list.string() + ": cannot be read");
  }
  std::ranges::sort(names);
  names.erase(std::ranges::unique(names).begin(), names.end());
  return names;
}

std::filesystem::path definition_file(const std::filesystem::path& prefix,
                                      std::string_view interface_name) {
  const auto parts = generator::split_name(interface_name);
  const auto folder = prefix / "share" / parts.package / parts.folder;
  for (const auto& extension : {"." + parts.folder, std::string(".idl")}) {
    auto file = folder / (parts.type + extension);
    std::error_code error;
    if (std::filesystem::is_regular_file(file, error)) {
      return file;
    }
  }
  throw MessageTypeError((folder / parts.type).string() + "." + parts.folder +
                         " is missing, and the .idl file too, though " +
                         definition_list(prefix, parts.package).string() + " lists it");
}

std::vector<std::string> structure_names(const std::string& interface_name) {
  constexpr std::array<std::string_view, 1> kMessage{""};
  constexpr std::array<std::string_view, 2> kService{"_Request", "_Response"};
  constexpr std::array<std::string_view, 8> kAction{"_Goal",
                                                    "_Result",
                                                    "_Feedback",
                                                    "_SendGoal_Request",
                                                    "_SendGoal_Response",
                                                    "_GetResult_Request",
                                                    "_GetResult_Response",
                                                    "_FeedbackMessage"};
  const auto folder = generator::split_name(interface_name).folder;
  std::vector<std::string> names;
  const auto add = [&](const auto& suffixes) {
    for (const auto suffix : suffixes) {
      names.push_back(interface_name + std::string(suffix));
    }
  };
  if (folder == "srv") {
    add(kService);
  } else if (folder == "action") {
    add(kAction);
  } else {
    add(kMessage);
  }
  return names;
}

}  // namespace pipescout::idl
