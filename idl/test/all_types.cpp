// SPDX-License-Identifier: Apache-2.0
#include "all_types.hpp"

#include <filesystem>
#include <string>

#include "ament_prefix.hpp"
#include "pipescout/idl/support/type_support.hpp"

extern "C" pipescout::idl::PackageTypes pipescout_message_types_of_test_msgs();

namespace pipescout::testing {
namespace {

namespace fs = std::filesystem;

std::vector<TwinTypes> load_twins() {
  const AmentPrefix prefix;
  const fs::path definitions = fs::path(TEST_DEFINITIONS_DIR) / "test_msgs";
  std::string list;
  for (const auto& file : fs::recursive_directory_iterator(definitions)) {
    if (file.is_regular_file()) {
      list += fs::relative(file.path(), definitions).string() + "\n";
    }
  }
  prefix.write_entry("rosidl_interfaces", "test_msgs", list);
  fs::create_directory_symlink(definitions, prefix.path() / "share/test_msgs");
  std::vector<TwinTypes> twins;
  const auto generated = pipescout_message_types_of_test_msgs();
  for (std::size_t i = 0; i < generated.count; ++i) {
    twins.push_back({generated.types[i], &load_message_type(generated.types[i]->name)});
  }
  return twins;
}

}  // namespace

const std::vector<TwinTypes>& twin_types() {
  static const auto types = load_twins();
  return types;
}

const std::vector<const MessageType*>& all_types() {
  static const auto types = [] {
    std::vector<const MessageType*> all(message_types().begin(), message_types().end());
    for (const auto& twins : twin_types()) {
      all.insert(all.end(), {twins.generated, twins.loaded});
    }
    return all;
  }();
  return types;
}

}  // namespace pipescout::testing
