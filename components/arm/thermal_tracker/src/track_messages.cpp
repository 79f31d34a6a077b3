// SPDX-License-Identifier: Apache-2.0
#include "track_messages.hpp"

#include <Eigen/Core>
#include <algorithm>
#include <concepts>
#include <string>

#include "pipescout/message_conversions/tracked_section.hpp"

namespace pipescout {
namespace {

using pipescout_msgs::msg::PipeTrack;
using pipescout_msgs::msg::PipeTrackParticles;
using tracking::PipeShape;
using tracking::TrackState;
using tracking::ValveShape;
using tracking::VesselShape;

/// The section that a shape is in the message is linear in its numbers.
template <class Model>
using SectionOf = Eigen::Matrix<double, 4, static_cast<int>(Model::kSize)>;

template <class Model>
SectionOf<Model> section_of() {
  SectionOf<Model> result = SectionOf<Model>::Zero();
  result(PipeShape::kX, Model::kX) = 1;
  result(PipeShape::kY, Model::kY) = 1;
  if constexpr (std::same_as<Model, ValveShape>) {
    result(PipeShape::kLength, Model::kRadius) = 2;
  } else {
    result(PipeShape::kLength, Model::kLength) = 1;
    result(PipeShape::kAngle, Model::kAngle) = 1;
  }
  return result;
}

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

template <class Model>
std::string reason(const tracking::Track<Model>& track) {
  if (track.state == TrackState::kLocked) {
    return "";
  }
  if (track.regions == 0) {
    return "no region in the image";
  }
  if (track.state == TrackState::kDetecting) {
    return track.region ? "not confirmed by enough images yet"
                        : "no region is associated with the track";
  }
  return track.in_view ? "no region fits the prediction" : "predicted outside the image";
}

}  // namespace

template <tracking::TrackableShape Model>
pipescout_msgs::msg::PipeTrack track_message(const tracking::Track<Model>& track) {
  const SectionOf<Model> section = section_of<Model>();
  pipescout_msgs::msg::PipeTrack message;
  message.state = to_message(track.state);
  message.reason = reason(track);
  message.width = static_cast<std::uint32_t>(track.image.width);
  message.height = static_cast<std::uint32_t>(track.image.height);
  message.track = track.number;
  message.confidence = track.confidence;
  message.since_seen = track.since_seen;
  message.estimate = section_message(section * track.estimate);
  const Eigen::Matrix4d covariance = section * track.covariance * section.transpose();
  std::copy_n(covariance.data(), covariance.size(), message.covariance.begin());
  message.rate = section_message(section * track.rate);
  message.start_censored = track.start_censored;
  message.end_censored = track.end_censored;
  message.best_particle = section_message(section * track.best_particle);
  message.robust_mean = section_message(section * track.robust_mean);
  message.weighted_mean = section_message(section * track.weighted_mean);
  message.effective_samples = track.effective_samples;
  message.regions = static_cast<std::uint32_t>(track.regions);
  return message;
}

template <tracking::TrackableShape Model>
PipeTrackParticles particles_message(const tracking::ParticleFilter<Model>& filter,
                                     std::span<const typename Model::Region> regions,
                                     std::size_t most) {
  const SectionOf<Model> section = section_of<Model>();
  PipeTrackParticles message;
  for (const typename Model::Region& region : regions) {
    message.regions.push_back(section_message(section * Model::state_of(region)));
  }
  if (!filter.started() || most == 0) {
    return message;
  }
  const std::size_t count = filter.weights().size();
  const std::size_t step = (count + most - 1) / most;
  float sum = 0;
  for (std::size_t i = 0; i < count; i += step) {
    tracking::ShapeState<Model> particle;
    for (std::size_t number = 0; number < Model::kSize; ++number) {
      particle[static_cast<Eigen::Index>(number)] = filter.numbers(number)[i];
    }
    const Eigen::Vector4d shown = section * particle;
    message.u.push_back(static_cast<float>(shown[PipeShape::kX]));
    message.v.push_back(static_cast<float>(shown[PipeShape::kY]));
    message.length.push_back(static_cast<float>(shown[PipeShape::kLength]));
    message.angle.push_back(static_cast<float>(shown[PipeShape::kAngle]));
    message.weight.push_back(filter.weights()[i]);
    sum += filter.weights()[i];
  }
  for (float& weight : message.weight) {
    weight = sum > 0 ? weight / sum : 1.0F / static_cast<float>(message.weight.size());
  }
  return message;
}

double half_width_of(const ValveShape::State& valve) {
  return valve[ValveShape::kRadius];
}

double half_width_of(const VesselShape::State& vessel) {
  return vessel[VesselShape::kWidth] / 2;
}

template PipeTrack track_message(const tracking::Track<PipeShape>& track);
template PipeTrack track_message(const tracking::Track<ValveShape>& track);
template PipeTrack track_message(const tracking::Track<VesselShape>& track);
template PipeTrackParticles particles_message(const tracking::ParticleFilter<PipeShape>& filter,
                                              std::span<const PipeShape::Region> regions,
                                              std::size_t most);
template PipeTrackParticles particles_message(const tracking::ParticleFilter<ValveShape>& filter,
                                              std::span<const ValveShape::Region> regions,
                                              std::size_t most);
template PipeTrackParticles particles_message(const tracking::ParticleFilter<VesselShape>& filter,
                                              std::span<const VesselShape::Region> regions,
                                              std::size_t most);

}  // namespace pipescout
