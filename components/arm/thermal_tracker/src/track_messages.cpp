// SPDX-License-Identifier: Apache-2.0
#include "track_messages.hpp"

#include <algorithm>
#include <cmath>
#include <string>

#include "pipescout/message_conversions/tracked_section.hpp"

namespace pipescout {
namespace {

using pipescout_msgs::msg::PipeTrack;
using pipescout_msgs::msg::PipeTrackParticles;
using tracking::PipeShape;
using tracking::TrackState;

std::uint8_t to_message(TrackState state) {
  switch (state) {
    case TrackState::kDetecting:
      return PipeTrack::STATE_DETECTING;
    case TrackState::kLocked:
      return PipeTrack::STATE_LOCKED;
    case TrackState::kCoasting:
      return PipeTrack::STATE_COASTING;
    case TrackState::kLost:
      return PipeTrack::STATE_LOST;
  }
  return PipeTrack::STATE_LOST;
}

std::string reason(const tracking::PipeTrack& track) {
  if (track.state == TrackState::kLocked) {
    return "";
  }
  if (track.regions == 0) {
    return "no region in the image";
  }
  if (track.state == TrackState::kDetecting) {
    return track.region ? "not confirmed by enough images yet"
                        : "no region is associated with the pipe";
  }
  return track.in_view ? "no region fits the prediction" : "predicted outside the image";
}

}  // namespace

pipescout_msgs::msg::PipeTrack track_message(const tracking::PipeTrack& track) {
  pipescout_msgs::msg::PipeTrack message;
  message.state = to_message(track.state);
  message.reason = reason(track);
  message.width = static_cast<std::uint32_t>(track.image.width);
  message.height = static_cast<std::uint32_t>(track.image.height);
  message.track = track.number;
  message.confidence = track.confidence;
  message.since_seen = track.since_seen;
  message.estimate = section_message(track.estimate);
  std::copy_n(track.covariance.data(), track.covariance.size(), message.covariance.begin());
  message.rate = section_message(track.rate);
  message.start_censored = track.start_censored;
  message.end_censored = track.end_censored;
  message.best_particle = section_message(track.best_particle);
  message.robust_mean = section_message(track.robust_mean);
  message.weighted_mean = section_message(track.weighted_mean);
  message.effective_samples = track.effective_samples;
  message.regions = static_cast<std::uint32_t>(track.regions);
  return message;
}

PipeTrackParticles particles_message(const tracking::ParticleFilter<PipeShape>& filter,
                                     std::span<const tracking::PipeRegion> regions,
                                     std::size_t most) {
  PipeTrackParticles message;
  for (const tracking::PipeRegion& region : regions) {
    message.regions.push_back(section_message(PipeShape::state_of(region)));
  }
  if (!filter.started() || most == 0) {
    return message;
  }
  const std::size_t count = filter.weights().size();
  const std::size_t step = (count + most - 1) / most;
  float sum = 0;
  for (std::size_t i = 0; i < count; i += step) {
    message.u.push_back(filter.numbers(PipeShape::kX)[i]);
    message.v.push_back(filter.numbers(PipeShape::kY)[i]);
    message.length.push_back(filter.numbers(PipeShape::kLength)[i]);
    message.angle.push_back(filter.numbers(PipeShape::kAngle)[i]);
    message.weight.push_back(filter.weights()[i]);
    sum += filter.weights()[i];
  }
  for (float& weight : message.weight) {
    weight = sum > 0 ? weight / sum : 1.0F / static_cast<float>(message.weight.size());
  }
  return message;
}

}  // namespace pipescout
