// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "mission_info.hpp"
#include "pipescout/bags/bag_types.hpp"
#include "pipescout/idl/field_access.hpp"
#include "pipescout/mission_folder/mission_section.hpp"

/// What `pipescout summary` tells of bags: sections as those of a mission folder.
namespace pipescout::summary {

using Sections = std::map<std::string, MissionSection>;

/// One table over the messages of some types. The messages come by rising log time.
class SectionMaker {
 public:
  virtual ~SectionMaker() = default;
  [[nodiscard]] virtual bool takes(const bags::BagTopic& topic) const = 0;
  virtual void add(const bags::BagTopic& topic, MessageView message) = 0;
  /// Its section under its name; none when there was nothing to tell.
  virtual void add_to(Sections& sections) = 0;
};

/// nav_msgs/Odometry: how long the way is, how fast.
[[nodiscard]] std::unique_ptr<SectionMaker> odometry_section();
/// sensor_msgs/Imu: gravity, rates, what is dead.
[[nodiscard]] std::unique_ptr<SectionMaker> imu_section();
/// sensor_msgs/NavSatFix: fixes, their stated deviation, the area.
[[nodiscard]] std::unique_ptr<SectionMaker> gps_section();
/// diagnostic_msgs/DiagnosticArray: what queues dropped, the network lost and the recorder could
/// not take, by node and topic; what nodes warned of. What others than the nodes of the mission
/// lost is shown and not counted; none: all are of it.
[[nodiscard]] std::unique_ptr<SectionMaker> diagnostics_section(
    const std::vector<std::string>& mission);
/// pipescout_msgs/MissionStatus: how far each node came. The mission is complete when these nodes
/// are (none: all that report), and no inputs were lost, by the section of the diagnostics.
[[nodiscard]] std::unique_ptr<SectionMaker> mission_section(
    const std::vector<std::string>& complete_when);

/// Messages that were inputs and were lost, by the section of the diagnostics; none: not known.
[[nodiscard]] std::optional<std::uint64_t> inputs_lost(const Sections& sections);

struct BagSections {
  Sections sections;  ///< of the bag, whoever recorded it
  Sections tables;    ///< of the subjects whose topics are ours, by the name of the section
  /// What could not be read or decoded, and missions that failed.
  std::vector<std::string> problems;
};

/// What is known of a mission besides its bags.
struct Mission {
  MissionInfo info;
  /// Where the data files go; nothing: no files.
  std::optional<std::filesystem::path> folder;
};

/// Reads the bags once, one after the other as if they were one. `progress` is told the share of
/// the messages that were read. Throws bags::BagError when one is no bag or nothing in it can be
/// read, std::system_error naming a data file that cannot be written, std::exception for options
/// that do not fit.
[[nodiscard]] BagSections summarise(const std::vector<std::filesystem::path>& bags,
                                    const Mission& mission,
                                    const std::function<void(double)>& progress);

}  // namespace pipescout::summary
