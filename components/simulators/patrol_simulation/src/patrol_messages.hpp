// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <pipescout_msgs/msg/leak_event.hpp>
#include <pipescout_msgs/msg/pipe_track.hpp>
#include <sensor_msgs/msg/nav_sat_fix.hpp>
#include <vector>

#include "pipescout/geometry/camera.hpp"
#include "pipescout/geometry/geodesy.hpp"
#include "pipescout/simulation/gps_receiver.hpp"
#include "pipescout/simulation/pipe_view.hpp"
#include "pipescout/simulation/thermal_scene.hpp"

/// From the simulation to messages: all but their headers. All functions are pure.
namespace pipescout {

[[nodiscard]] sensor_msgs::msg::NavSatFix fix_message(const simulation::GpsFix& fix,
                                                      const geometry::LocalFrame& frame);

/// One for each leak of the rows, row by row.
[[nodiscard]] std::vector<pipescout_msgs::msg::LeakEvent> true_leak_messages(
    const std::vector<simulation::ThermalScene>& rows);

/// Locked while the tube, of `radius` m, is in view, else lost. The track is number 1 while the
/// robot is beside a tube, else 0.
[[nodiscard]] pipescout_msgs::msg::PipeTrack true_track_message(
    const std::optional<simulation::PipeView>& view, const geometry::CameraParameters& camera,
    double radius, bool beside);

}  // namespace pipescout
