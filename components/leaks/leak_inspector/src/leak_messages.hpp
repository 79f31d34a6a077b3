// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <pipescout_msgs/msg/leak_detections.hpp>
#include <pipescout_msgs/msg/leak_finding.hpp>
#include <span>

#include "pipescout/leak_findings/finding.hpp"
#include "pipescout/thermal/leak_detector.hpp"

/// From detections and findings to messages. All functions are pure.
namespace pipescout {

/// All but the header. `finding_of`: of each leak, the id of its finding; empty: of none.
[[nodiscard]] pipescout_msgs::msg::LeakDetections detections_message(
    const thermal::Detections& detections, std::span<const std::uint64_t> finding_of);

/// `kind` of a LeakEvent.
[[nodiscard]] std::uint8_t event_kind(leak_findings::EventKind kind);

/// All but the thumbnail. Times of findings are s since the epoch of `Time`.
[[nodiscard]] pipescout_msgs::msg::LeakFinding finding_message(
    const leak_findings::Finding& finding);

}  // namespace pipescout
