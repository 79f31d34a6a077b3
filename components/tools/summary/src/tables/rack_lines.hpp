// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <geometry_msgs/msg/twist_stamped.hpp>
#include <pipescout_msgs/msg/mission_status.hpp>
#include <pipescout_msgs/msg/rack_state.hpp>
#include <string>

#include "pipescout/runtime/time.hpp"

/// The lines of a flight's data files other than poses, docs/tables.md. Pure.
namespace pipescout::summary {

[[nodiscard]] std::string state_csv_header();
[[nodiscard]] std::string state_csv_line(const pipescout_msgs::msg::RackState& message);

[[nodiscard]] std::string offset_csv_header();
/// The lists of the message are as long as `pipe`. Not checked.
[[nodiscard]] std::string offset_csv_line(const pipescout_msgs::msg::RackState& message,
                                          std::size_t pipe);

[[nodiscard]] std::string command_csv_header();
[[nodiscard]] std::string command_csv_line(const geometry_msgs::msg::TwistStamped& message);

[[nodiscard]] std::string way_point_csv_header();
[[nodiscard]] std::string way_point_csv_line(const pipescout_msgs::msg::MissionStatus& message);

[[nodiscard]] std::string image_csv_header();
[[nodiscard]] std::string image_csv_line(Time stamp, const std::string& file);

}  // namespace pipescout::summary
