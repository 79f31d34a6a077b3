// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <pipescout_msgs/msg/bend_detection.hpp>
#include <pipescout_msgs/msg/eddy_current_samples.hpp>
#include <pipescout_msgs/msg/fused_odometer.hpp>
#include <pipescout_msgs/msg/pipe_position.hpp>
#include <pipescout_msgs/msg/weld_detection.hpp>
#include <string>
#include <vector>

/// The lines of a crawler's data files, docs/tables.md. Pure.
namespace pipescout::summary {

[[nodiscard]] std::string fused_csv_header(const std::vector<std::string>& columns);
/// All lists of the message are as long as `name`, or empty where they may be. Not checked.
[[nodiscard]] std::string fused_csv_line(const pipescout_msgs::msg::FusedOdometer& message);

[[nodiscard]] std::string weld_csv_header();
[[nodiscard]] std::string weld_csv_line(const pipescout_msgs::msg::WeldDetection& message);

[[nodiscard]] std::string bend_csv_header();
[[nodiscard]] std::string bend_csv_line(const pipescout_msgs::msg::BendDetection& message);

[[nodiscard]] std::string position_csv_header();
[[nodiscard]] std::string position_csv_line(const pipescout_msgs::msg::PipePosition& message);

[[nodiscard]] std::string samples_csv_header(std::size_t channels);
/// x and y are samples x channels values each. Not checked.
[[nodiscard]] std::string samples_csv_line(const pipescout_msgs::msg::EddyCurrentSamples& message,
                                           std::size_t sample);

}  // namespace pipescout::summary
