// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <map>
#include <pipescout_msgs/msg/leak_detections.hpp>
#include <pipescout_msgs/msg/leak_event.hpp>
#include <string>

#include "pipescout/mission_folder/mission_section.hpp"

namespace pipescout::summary {

/// What there is to say of a run's leaks, for the mission's summary. Bounded by the number of
/// leaks. Pure; not thread-safe.
class LeakTally {
 public:
  /// m, from a true leak, within which a finding is taken for it.
  static constexpr double kSame = 1.5;

  void add(const pipescout_msgs::msg::LeakDetections& detections);
  void add(const pipescout_msgs::msg::LeakEvent& event);
  /// A leak that there is, from a simulation.
  void add_truth(const pipescout_msgs::msg::LeakFinding& leak);

  [[nodiscard]] std::uint64_t pictures() const noexcept { return pictures_; }
  [[nodiscard]] std::uint64_t events() const noexcept { return events_; }

  /// Names of figures begin with `figure_prefix`.
  [[nodiscard]] MissionSection section(const std::string& figure_prefix) const;

 private:
  using Finding = pipescout_msgs::msg::LeakFinding;

  void add_figures_of_truth(MissionSection& section, const std::string& prefix) const;

  std::uint64_t pictures_ = 0;
  std::uint64_t with_pipe_ = 0;
  std::uint64_t with_leak_ = 0;
  std::uint64_t failed_ = 0;
  std::uint64_t events_ = 0;
  std::map<std::uint64_t, Finding> findings_;  // as last told
  std::map<std::uint64_t, Finding> truth_;
};

}  // namespace pipescout::summary
