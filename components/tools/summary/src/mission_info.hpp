// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <map>
#include <string>
#include <vector>

#include "tables/table_options.hpp"

namespace pipescout::summary {

/// What the composition of a mission, as it was run, says of its tables.
struct MissionInfo {
  /// Node whose completion ends the recording, of the bag recorder; empty: not known.
  std::string source;
  /// Names of its components, fully qualified; empty: not known.
  std::vector<std::string> nodes;
  /// Nodes whose completion makes the mission complete; empty: all that report.
  std::vector<std::string> complete_when;
  /// m, what the consensus fusion of a namespace adds to the readings of its odometers: empty for
  /// nothing. A namespace that is missing: not known.
  std::map<std::string, std::vector<double>> odometer_offsets;
  TableOptions options;
};

/// Of mission.yaml in a mission folder; nothing of it when there is no such file. Throws YamlError,
/// std::invalid_argument.
[[nodiscard]] MissionInfo read_mission_info(const std::filesystem::path& mission_folder);

/// The bags of a mission folder, in the order in which they were recorded: `bag`, and `bag_2`, ...
/// of a recorder that was restarted.
[[nodiscard]] std::vector<std::filesystem::path> bags_of(
    const std::filesystem::path& mission_folder);

}  // namespace pipescout::summary
