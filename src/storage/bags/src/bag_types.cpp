// SPDX-License-Identifier: Apache-2.0
#include "pipescout/bags/bag_types.hpp"

namespace pipescout::bags {

std::string_view storage_identifier(Storage storage) noexcept {
  switch (storage) {
    case Storage::kSqlite:
      return "sqlite3";
    case Storage::kMcap:
      return "mcap";
    case Storage::kRos1:
      return "rosbag_v2";
  }
  return "";
}

std::optional<Storage> storage_of(std::string_view identifier) noexcept {
  for (const Storage storage : {Storage::kSqlite, Storage::kMcap, Storage::kRos1}) {
    if (identifier == storage_identifier(storage)) {
      return storage;
    }
  }
  return std::nullopt;
}

}  // namespace pipescout::bags
