// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <pipescout_msgs/msg/pipe_track.hpp>
#include <pipescout_msgs/msg/pipe_track_particles.hpp>
#include <span>

#include "pipescout/tracking/shape_tracker.hpp"

/// From tracks to messages. All functions are pure.
namespace pipescout {

/// All but header, fault, width of the pipe, range. A valve is a section as long as its diameter,
/// of no direction, a vessel one along its axis. For pipes, valves and vessels.
template <tracking::TrackableShape Model>
[[nodiscard]] pipescout_msgs::msg::PipeTrack track_message(const tracking::Track<Model>& track);

/// All but the header. At most `most` particles, evenly chosen. For the same shapes.
template <tracking::TrackableShape Model>
[[nodiscard]] pipescout_msgs::msg::PipeTrackParticles particles_message(
    const tracking::ParticleFilter<Model>& filter, std::span<const typename Model::Region> regions,
    std::size_t most);

/// px, from the middle to the edge across the section.
[[nodiscard]] double half_width_of(const tracking::ValveShape::State& valve);
[[nodiscard]] double half_width_of(const tracking::VesselShape::State& vessel);

}  // namespace pipescout
