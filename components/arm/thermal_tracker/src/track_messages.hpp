// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <pipescout_msgs/msg/pipe_track.hpp>
#include <pipescout_msgs/msg/pipe_track_particles.hpp>
#include <span>

#include "pipescout/tracking/shape_tracker.hpp"

/// From tracks to messages. All functions are pure.
namespace pipescout {

/// All but header, fault, width of the pipe, range.
[[nodiscard]] pipescout_msgs::msg::PipeTrack track_message(const tracking::PipeTrack& track);

/// All but the header. At most `most` particles, evenly chosen.
[[nodiscard]] pipescout_msgs::msg::PipeTrackParticles particles_message(
    const tracking::ParticleFilter<tracking::PipeShape>& filter,
    std::span<const tracking::PipeRegion> regions, std::size_t most);

}  // namespace pipescout
