// SPDX-License-Identifier: Apache-2.0
#include "further_inputs.hpp"

#include <algorithm>
#include <geometry_msgs/msg/pose_with_covariance_stamped.hpp>
#include <stdexcept>
#include <variant>

#include "pipescout/estimation/camera_calibration.hpp"
#include "pipescout/message_conversions/geometry.hpp"

namespace pipescout::estimate {
namespace {

/// m, per axis: no receiver is better, whatever it states.
constexpr double kLeastGpsDeviation = 0.01;

std::string plain(const std::string& frame) {
  return frame.starts_with('/') ? frame.substr(1) : frame;
}

const Stream& stream_of(const Recording& recording, const NamedSource& source) {
  const std::string key = "further_sources." + source.name;
  const Stream* stream = recording.find_further(source.topic);
  const auto named = [&](const Stream& s) { return s.name == source.topic; };
  if (stream == nullptr) {
    const bool there = std::ranges::any_of(recording.streams, named);
    throw std::invalid_argument(key + ".topic: the recording has no " +
                                (there ? "usable message on '" : "source '") + source.topic + "'");
  }
  if (stream->message_type != message_type_of(source.kind)) {
    throw std::invalid_argument(key + ": '" + source.topic + "' is of type " +
                                stream->message_type + ", and kind " +
                                std::string(to_string(source.kind)) + " is measured by " +
                                std::string(message_type_of(source.kind)));
  }
  return *stream;
}

}  // namespace

FurtherInputs::FurtherInputs(const Recording& recording, const Configuration& configuration,
                             const geometry::LocalFrame* map,
                             estimation::StateEstimatorParameters& parameters,
                             std::vector<std::string>& said)
    : recording_(&recording),
      map_(map),
      base_frame_(configuration.base_frame),
      sources_(configuration.further),
      places_(sources_.size()),
      faults_(sources_.size()) {
  place_sources(sources_, parameters);
  for (std::size_t i = 0; i < sources_.size(); ++i) {
    const NamedSource& source = sources_[i];
    if (source.kind == NamedSourceKind::kGpsFix && map == nullptr) {
      throw std::invalid_argument("further_sources." + source.name +
                                  ": another antenna needs gps.source, which places the map");
    }
    const Stream& stream = stream_of(recording, source);
    streams_.push_back(&stream);
    inputs_.emplace_back(source, i, parameters.odometer.largest_speed);
    said.push_back(stream.name + " (" + stream.type + ", " + std::to_string(stream.further.size()) +
                   " messages) is taken as " + source.name + ", of kind " +
                   std::string(to_string(source.kind)) + ".");
  }
}

std::optional<geometry::SE3> FurtherInputs::place_of(std::size_t source, const std::string& frame) {
  const NamedSource& named = sources_[source];
  if (named.position) {
    return geometry::SE3(named.R_base_sensor, *named.position);
  }
  if (frame.empty() || frame == base_frame_) {
    return geometry::SE3();
  }
  auto& places = places_[source];
  if (const auto known = places.find(frame); known != places.end()) {
    return known->second;
  }
  const auto pose = recording_->mounting(base_frame_, frame);
  if (!pose) {
    ++faults_[source]["frame '" + frame + "' is not connected to the base frame '" + base_frame_ +
                      "' by fixed transforms; not used (give further_sources." + named.name +
                      ".position)"];
    return std::nullopt;
  }
  return places.emplace(frame, *pose).first->second;
}

void FurtherInputs::take(const FurtherReading& reading, const Eigen::Vector3d& angular_rate,
                         estimation::StateEstimator& estimator) {
  const std::size_t i = reading.source;
  try {
    std::visit(
        [&](const auto& message) {
          const auto T_body_sensor = place_of(i, plain(sensor_frame(message)));
          if (!T_body_sensor) {
            return;
          }
          const SourceNews news = inputs_[i].take(message, reading.row->time,
                                                  {.T_body_sensor = *T_body_sensor,
                                                   .angular_rate = angular_rate,
                                                   .map = map_,
                                                   .least_gps_deviation = kLeastGpsDeviation});
          if (news.jumped > 0) {
            ++faults_[i]["its pose jumped"];
          }
          if (news.factor) {
            (void)estimator.add(*news.factor);
          }
        },
        reading.row->message);
  } catch (const std::invalid_argument& error) {
    // The numbers differ from message to message: the first one stands for all.
    const auto [first, is_new] = refused_.try_emplace(i, error.what());
    ++faults_[i]["refused, first because " + first->second];
  }
}

std::optional<estimation::GivenPose> FurtherInputs::first_pose() {
  using geometry_msgs::msg::PoseWithCovarianceStamped;
  constexpr double kCovers = 3;  // standard deviations
  for (std::size_t i = 0; i < sources_.size(); ++i) {
    const NamedSource& source = sources_[i];
    if (source.kind != NamedSourceKind::kPose) {
      continue;
    }
    for (const FurtherRow& row : rows(i)) {
      const auto* const message = std::get_if<PoseWithCovarianceStamped>(&row.message);
      const auto T_base_sensor = place_of(i, {});
      if (message == nullptr || !T_base_sensor) {
        continue;
      }
      try {
        const geometry::SE3 base = from_message(message->pose.pose) * T_base_sensor->inverse();
        const double arm = T_base_sensor->translation().norm();
        return estimation::GivenPose{
            .time = row.time,
            .position = base.translation(),
            .position_deviation =
                std::clamp(kCovers * (source.deviation + source.mounting_position_deviation +
                                      arm * source.mounting_rotation_deviation),
                           1e-3, 1e4),
            .heading = base.rotation().roll_pitch_yaw().z(),
            .heading_deviation = std::clamp(
                kCovers * (source.rotation_deviation + source.mounting_rotation_deviation), 1e-4,
                1.0)};
      } catch (const std::invalid_argument&) {
        continue;  // it is counted when it is taken
      }
    }
  }
  return std::nullopt;
}

std::vector<FurtherOutcome> FurtherInputs::outcomes(
    const estimation::StateEstimator& estimator,
    const estimation::StateEstimatorParameters& parameters) const {
  const estimation::EstimatorStatus status = estimator.status();
  std::vector<FurtherOutcome> result;
  for (std::size_t i = 0; i < sources_.size(); ++i) {
    const NamedSource& source = sources_[i];
    FurtherOutcome& outcome =
        result.emplace_back(FurtherOutcome{.name = source.name,
                                           .messages = streams_[i]->further.size(),
                                           .status = status.own_sources[i],
                                           .faults = faults_[i]});
    if (outcome.status.accepted > 0 && (source.mounting >= 0 || source.clock >= 0)) {
      outcome.calibration = camera_calibration_text(estimator.smoother(), parameters.smoother,
                                                    source.mounting, source.clock);
    }
  }
  return result;
}

}  // namespace pipescout::estimate
