// SPDX-License-Identifier: Apache-2.0
#include "pipescout/leak_findings/leak_findings.hpp"

namespace pipescout::leak_findings {

std::string_view to_string(FindingState state) noexcept {
  switch (state) {
    case FindingState::kCandidate:
      return "candidate";
    case FindingState::kRaised:
      return "raised";
    case FindingState::kCleared:
      return "cleared";
  }
  return "unknown";
}

std::string_view to_string(EventKind kind) noexcept {
  switch (kind) {
    case EventKind::kRaised:
      return "raised";
    case EventKind::kUpdated:
      return "updated";
    case EventKind::kCleared:
      return "cleared";
  }
  return "unknown";
}

std::string_view to_string(RangeSource source) noexcept {
  switch (source) {
    case RangeSource::kNone:
      return "none";
    case RangeSource::kDistance:
      return "distance";
    case RangeSource::kDiameter:
      return "diameter";
    case RangeSource::kLine:
      return "lines";
  }
  return "unknown";
}

std::optional<RangeSource> range_source(std::string_view name) noexcept {
  for (const RangeSource source : kRangeSources) {
    if (to_string(source) == name) {
      return source;
    }
  }
  return std::nullopt;
}

std::string_view to_string(InputFault fault) noexcept {
  switch (fault) {
    case InputFault::kNone:
      return "none";
    case InputFault::kBadTime:
      return "bad_time";
    case InputFault::kNoDetections:
      return "no_detections";
    case InputFault::kBadSize:
      return "bad_size";
    case InputFault::kNoPose:
      return "no_pose";
    case InputFault::kBadPose:
      return "bad_pose";
    case InputFault::kBadCovariance:
      return "bad_covariance";
  }
  return "unknown";
}

}  // namespace pipescout::leak_findings
