// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <map>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "pipescout/bags/bag_types.hpp"
#include "pipescout/idl/field_access.hpp"
#include "pipescout/mission_folder/mission_section.hpp"

/// What `pipescout summary` tells of a bag: sections as those of a mission folder.
namespace pipescout::summary {

using Sections = std::map<std::string, MissionSection>;

/// One table over the messages of some types. The messages come by rising log time.
class SectionMaker {
 public:
  virtual ~SectionMaker() = default;
  [[nodiscard]] virtual bool takes(std::string_view type) const = 0;
  virtual void add(const bags::BagTopic& topic, MessageView message) = 0;
  /// Its section under its name; none when there was nothing to tell.
  virtual void add_to(Sections& sections) const = 0;
};

/// nav_msgs/Odometry: how long the way is, how fast.
[[nodiscard]] std::unique_ptr<SectionMaker> odometry_section();
/// sensor_msgs/Imu: gravity, rates, what is dead.
[[nodiscard]] std::unique_ptr<SectionMaker> imu_section();
/// sensor_msgs/NavSatFix: fixes, their stated deviation, the area.
[[nodiscard]] std::unique_ptr<SectionMaker> gps_section();
/// diagnostic_msgs/DiagnosticArray: what queues dropped and the network lost, by node and topic;
/// what nodes warned of.
[[nodiscard]] std::unique_ptr<SectionMaker> diagnostics_section();
/// pipescout_msgs/MissionStatus: how far each node came. A mission that lost inputs, by the section
/// of the diagnostics, is not called complete.
[[nodiscard]] std::unique_ptr<SectionMaker> mission_section();

struct BagSections {
  Sections sections;
  /// What could not be read or decoded.
  std::vector<std::string> problems;
};

/// Reads the bag once. `progress` is told the share of the messages that were read. Throws
/// bags::BagError when it is no bag or nothing in it can be read.
[[nodiscard]] BagSections summarise(const std::filesystem::path& bag,
                                    const std::function<void(double)>& progress);

}  // namespace pipescout::summary
