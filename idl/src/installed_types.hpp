// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <map>
#include <mutex>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "model.hpp"
#include "pipescout/idl/message_type.hpp"
#include "pipescout/idl/support/object_type.hpp"

namespace pipescout::idl {

/// The types of installed packages: generated ones from libraries, all others from their
/// definitions.
class InstalledTypes {
 public:
  /// Never destroyed, as the libraries are never unloaded: their types may be in use.
  static InstalledTypes& instance();

  /// As pipescout::load_message_type, but for built-in types.
  const MessageType& load(std::string_view name);

  /// The names in all lists.
  static std::vector<std::string> list();

 private:
  InstalledTypes();

  /// All with the lock held. Each throws MessageTypeError.
  const ObjectType& find(std::string_view name);
  const ObjectType& from_library(const std::filesystem::path& prefix, const std::string& package,
                                 std::string_view name);
  const ObjectType& from_definition(const std::filesystem::path& prefix, const std::string& package,
                                    std::string_view name);
  /// What an interface file defines, read when it is first needed.
  const generator::Interface& interface(const std::filesystem::path& prefix,
                                        const std::string& interface_name);
  const ObjectType& nested(const generator::Field& field);

  std::mutex mutex_;
  std::map<std::string, const ObjectType*, std::less<>> known_;
  std::map<std::string, generator::Interface, std::less<>> interfaces_;
  std::vector<std::string> being_made_;  ///< each uses the next one
};

}  // namespace pipescout::idl
