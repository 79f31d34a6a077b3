// SPDX-License-Identifier: Apache-2.0
#include "leak_messages.hpp"

#include <pipescout_msgs/msg/leak_event.hpp>
#include <string>

#include "pipescout/runtime/conversions.hpp"

namespace pipescout {

namespace {

using leak_findings::Finding;
using thermal::LeakDetection;
using thermal::PipeSection;

builtin_interfaces::msg::Time stamp(double seconds) {
  return to_message(Time(from_seconds(seconds)));
}

pipescout_msgs::msg::PipeSection to_message(const PipeSection& pipe) {
  pipescout_msgs::msg::PipeSection message;
  message.start_u = pipe.start.x();
  message.start_v = pipe.start.y();
  message.end_u = pipe.end.x();
  message.end_v = pipe.end.y();
  message.half_width = pipe.half_width;
  message.visible = pipe.visible;
  message.cut_along = pipe.cut_along;
  message.metres_per_pixel = pipe.metres_per_pixel;
  message.reference_temperature = pipe.reference_temperature;
  return message;
}

pipescout_msgs::msg::LeakDetection to_message(const LeakDetection& leak, std::uint64_t finding) {
  pipescout_msgs::msg::LeakDetection message;
  message.pipe = static_cast<std::uint32_t>(leak.pipe);
  message.start_u = leak.start.x();
  message.start_v = leak.start.y();
  message.end_u = leak.end.x();
  message.end_v = leak.end.y();
  message.temperature = leak.stretch.mean;
  message.peak_temperature = leak.stretch.peak;
  message.delta = leak.delta;
  message.peak_delta = leak.peak_delta;
  message.length = leak.length;
  message.severity = std::string(to_string(leak.severity));
  message.finding = finding;
  return message;
}

}  // namespace

pipescout_msgs::msg::LeakDetections detections_message(const thermal::Detections& detections,
                                                       std::span<const std::uint64_t> finding_of) {
  pipescout_msgs::msg::LeakDetections message;
  if (detections.fault != thermal::FrameFault::kNone) {
    message.fault = std::string(to_string(detections.fault));
  }
  message.width = static_cast<std::uint32_t>(detections.width);
  message.height = static_cast<std::uint32_t>(detections.height);
  message.threshold = detections.threshold;
  for (const PipeSection& pipe : detections.pipes) {
    message.pipes.push_back(to_message(pipe));
  }
  for (std::size_t i = 0; i < detections.leaks.size(); ++i) {
    message.leaks.push_back(
        to_message(detections.leaks[i], i < finding_of.size() ? finding_of[i] : 0));
  }
  return message;
}

std::uint8_t event_kind(leak_findings::EventKind kind) {
  using leak_findings::EventKind;
  using pipescout_msgs::msg::LeakEvent;
  switch (kind) {
    case EventKind::kRaised:
      return LeakEvent::RAISED;
    case EventKind::kUpdated:
      return LeakEvent::UPDATED;
    case EventKind::kCleared:
      return LeakEvent::CLEARED;
  }
  return LeakEvent::UPDATED;
}

pipescout_msgs::msg::LeakFinding finding_message(const Finding& finding) {
  pipescout_msgs::msg::LeakFinding message;
  message.id = finding.id;
  message.state = std::string(to_string(finding.state));
  message.probability = finding.probability;
  message.severity = std::string(to_string(finding.severity));
  message.position_known = finding.position.has_value();
  if (finding.position) {
    message.position.x = finding.position->point.x();
    message.position.y = finding.position->point.y();
    message.position.z = finding.position->point.z();
    for (Eigen::Index i = 0; i < 9; ++i) {
      message.position_covariance[static_cast<std::size_t>(i)] =
          finding.position->covariance(i / 3, i % 3);
    }
  }
  message.length = finding.length;
  message.length_deviation = finding.length_deviation;
  message.delta = finding.mean_delta;
  message.delta_low = finding.mean_delta_interval.low;
  message.delta_high = finding.mean_delta_interval.high;
  message.peak_delta = finding.peak_delta;
  message.peak_delta_low = finding.peak_delta_interval.low;
  message.peak_delta_high = finding.peak_delta_interval.high;
  message.delta_growth = finding.delta_growth;
  message.length_growth = finding.length_growth;
  message.first_seen = stamp(finding.first_time);
  message.last_seen = stamp(finding.last_time);
  message.frames = finding.frames;
  message.passes = finding.pass_count;
  return message;
}

}  // namespace pipescout
