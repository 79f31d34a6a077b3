// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <map>
#include <mutex>
#include <string>
#include <string_view>
#include <vector>

#include "pipescout/idl/message_type.hpp"

namespace pipescout::idl {

/// The types of packages that are installed, in libraries of their own.
class InstalledTypes {
 public:
  /// Never destroyed, as the libraries are never unloaded: their types may be in use.
  static InstalledTypes& instance();

  /// As pipescout::load_message_type, but for built-in types.
  const MessageType& load(std::string_view name);

  /// The names in all lists.
  static std::vector<std::string> list();

 private:
  std::mutex mutex_;
  std::map<std::string, const MessageType*, std::less<>> loaded_;
};

}  // namespace pipescout::idl
