// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "pipescout/geometry/se3.hpp"
#include "pipescout/leak_findings/leak_findings.hpp"
#include "pipescout/message_conversions/camera_mount.hpp"
#include "pipescout/runtime/bound_parameters.hpp"
#include "pipescout/runtime/parameters.hpp"
#include "pipescout/runtime/stamp_limits.hpp"
#include "pipescout/thermal_parameters/detection_parameters.hpp"
#include "pipescout/tracking/hot_regions.hpp"
#include "pipescout/tracking/shape_tracker.hpp"
#include "pipescout/tracking/shapes.hpp"

namespace pipescout {

/// What is tracked.
enum class FollowedShape : std::uint8_t { kPipe, kValve, kVessel };

/// Configuration of the component.
struct TrackerSettings {
  std::string map_frame;
  StampLimits stamp_limits;
  double silent_after = 0;  ///< s
  DetectionSettings detection;
  CameraMount mount{geometry::SE3()};
  FollowedShape followed = FollowedShape::kPipe;
  tracking::HotRegionParameters regions;       ///< valid; of valves and vessels
  tracking::PipeShape shape;                   ///< valid
  tracking::PipeTrackerParameters tracker;     ///< valid
  std::uint64_t seed = 0;                      ///< of the particles
  double distance = 0;                         ///< m, range of the pipes without other information
  std::vector<leak_findings::PipeLine> lines;  ///< of pipes in the map
  double line_deviation = 0;                   ///< m, standard, of pipes from these lines
  std::size_t published_particles = 0;
};

/// The parameters of the component: docs/components/thermal_tracker.md.
class TrackerParameters {
 public:
  /// Declares them. Throws as DetectionParameters.
  explicit TrackerParameters(Parameters& parameters);

  /// Throws std::invalid_argument naming the parameter.
  [[nodiscard]] TrackerSettings read(Node& node) const;

 private:
  void declare_followed(Parameters& parameters);
  void declare_shape();
  void declare_filter(Parameters& parameters);
  void declare_life();
  void declare_range(Parameters& parameters);
  void declare_messages(Parameters& parameters);
  [[nodiscard]] tracking::PipeTrackerParameters tracker() const;

  DetectionParameters detection_;
  CameraMountParameters mount_;
  Parameter<std::string> followed_;
  BoundParameters<tracking::HotRegionParameters> regions_;
  BoundParameters<tracking::PipeShape> shape_;
  BoundParameters<tracking::PipeTrackerParameters> tracker_;
  Parameter<std::string> resampling_;
  Parameter<std::vector<double>> start_deviation_;
  Parameter<std::vector<double>> process_deviation_;
  Parameter<std::vector<double>> rate_walk_;
  Parameter<std::int64_t> seed_;
  Parameter<double> distance_;
  Parameter<std::vector<double>> lines_;
  Parameter<double> line_deviation_;
  Parameter<std::size_t> published_particles_;
  Parameter<std::string> map_frame_;
  Parameter<double> maximum_age_;
  Parameter<double> maximum_lead_;
  Parameter<double> silent_after_;
};

}  // namespace pipescout
