// SPDX-License-Identifier: Apache-2.0
#include "further_inputs.hpp"

#include <algorithm>
#include <stdexcept>
#include <variant>

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

std::vector<FurtherOutcome> FurtherInputs::outcomes(
    const estimation::EstimatorStatus& status) const {
  std::vector<FurtherOutcome> result;
  for (std::size_t i = 0; i < sources_.size(); ++i) {
    result.push_back({.name = sources_[i].name,
                      .messages = streams_[i]->further.size(),
                      .status = status.own_sources[i],
                      .faults = faults_[i]});
  }
  return result;
}

}  // namespace pipescout::estimate
