// SPDX-License-Identifier: Apache-2.0
#include "all_types.hpp"

#include "pipescout/idl/support/type_support.hpp"

extern "C" pipescout::idl::PackageTypes pipescout_message_types_of_test_msgs();

namespace pipescout::testing {

const std::vector<const MessageType*>& all_types() {
  static const auto types = [] {
    std::vector<const MessageType*> all(message_types().begin(), message_types().end());
    const auto own = pipescout_message_types_of_test_msgs();
    all.insert(all.end(), own.types, own.types + own.count);
    return all;
  }();
  return types;
}

}  // namespace pipescout::testing
