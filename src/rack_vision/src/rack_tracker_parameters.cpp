// SPDX-License-Identifier: Apache-2.0
#include "pipescout/rack_vision/rack_tracker.hpp"
#include "pipescout/validation/check.hpp"

namespace pipescout::rack_vision {

void RackTrackerParameters::validate() const {
  validation::check_within("samples_per_edge", samples_per_edge, 2, 100);
  validation::check_within("points_per_frame", points_per_frame, 0, 200);
  validation::check_within("map_capacity", map_capacity, 0, 20000);
  validation::check_above("acceleration_sigma", acceleration_sigma, 0, 100);
  validation::check_above("angular_acceleration_sigma", angular_acceleration_sigma, 0, 1000);
  validation::check_above("edge_sigma", edge_sigma, 0, 20);
  validation::check_within("edge_bias_sigma", edge_bias_sigma, 0, 20);
  validation::check_above("point_sigma", point_sigma, 0, 10);
  validation::check_above("offset_sigma", offset_sigma, 0, 1);
  validation::check_above("focal_sigma", focal_sigma, 0, 1000);
  validation::check_above("centre_sigma", centre_sigma, 0, 1000);
  validation::check_within("row_time", row_time, 0, 1e-3);
  validation::check_above("longest_gap", longest_gap, 0, 60);
  validation::check_within("lost_below", lost_below, 0, 1);
  validation::check_above("start_range_m", start_range_m, 0, 1);
  validation::check_above("start_range_rad", start_range_rad, 0, 0.5);
}

std::string_view to_string(TrackStatus status) noexcept {
  switch (status) {
    case TrackStatus::kNotStarted:
      return "not started";
    case TrackStatus::kTracking:
      return "tracking";
    case TrackStatus::kCoasting:
      return "coasting";
    case TrackStatus::kLost:
      return "lost";
    case TrackStatus::kBadImage:
      return "bad image";
    case TrackStatus::kBadStamp:
      return "bad stamp";
  }
  return "unknown";
}

}  // namespace pipescout::rack_vision
