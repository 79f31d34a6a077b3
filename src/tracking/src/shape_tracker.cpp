// SPDX-License-Identifier: Apache-2.0
#include "pipescout/tracking/shape_tracker.hpp"

namespace pipescout::tracking {

std::string_view to_string(TrackState state) noexcept {
  switch (state) {
    case TrackState::kDetecting:
      return "detecting";
    case TrackState::kLocked:
      return "locked";
    case TrackState::kCoasting:
      return "coasting";
    case TrackState::kLost:
      return "lost";
  }
  return "unknown";
}

std::string_view to_string(TrackFault fault) noexcept {
  switch (fault) {
    case TrackFault::kNone:
      return "none";
    case TrackFault::kBadStamp:
      return "bad_stamp";
    case TrackFault::kTimeWentBack:
      return "time_went_back";
    case TrackFault::kBadImageSize:
      return "bad_image_size";
    case TrackFault::kTooManyRegions:
      return "too_many_regions";
    case TrackFault::kBadRegion:
      return "bad_region";
    case TrackFault::kBadMotion:
      return "bad_motion";
    case TrackFault::kBadHint:
      return "bad_hint";
  }
  return "unknown";
}

}  // namespace pipescout::tracking
