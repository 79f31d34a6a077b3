// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <sys/types.h>

#include <cstdint>
#include <diagnostic_msgs/msg/diagnostic_status.hpp>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "core/clock_watch.hpp"
#include "pipescout/runtime/graph.hpp"
#include "pipescout/runtime/time.hpp"

namespace pipescout::host {

/// What a host says of itself on `/diagnostics`, besides its components: what its processes take of
/// the machine ("robot_1/pipescout_container: process"), and what others on the network do that
/// its robot cannot work with ("robot_1/pipescout_container: network").
class HostStatus {
 public:
  /// `host` and `components`: fully qualified.
  HostStatus(const NodeName& host, std::vector<NodeName> components);

  /// Of this process and its children; the CPU time is that since the last call.
  [[nodiscard]] diagnostic_msgs::msg::DiagnosticStatus process(const std::vector<pid_t>& children,
                                                               SteadyTime now);
  /// What the system clock of the machine says, and how it was set last. A warning when `step` is
  /// new: the stamps of all that is published go with it.
  [[nodiscard]] diagnostic_msgs::msg::DiagnosticStatus clock(const std::optional<ClockStep>& step);
  /// Nodes of the same names, and several publishers of one clock; and `error`, unless it is empty.
  [[nodiscard]] diagnostic_msgs::msg::DiagnosticStatus network(const Graph& graph,
                                                               const std::string& error = {}) const;

 private:
  std::string name_;
  std::vector<NodeName> nodes_;  ///< ours, with the host
  std::map<pid_t, double> cpu_seconds_;
  SteadyTime looked_at_{};
  std::uint64_t clock_steps_ = 0;
  std::string last_clock_step_;
  const Time started_;
};

/// User and system time of a process in seconds, from the text of /proc/PID/stat; negative when it
/// is no such text. `ticks`: per second.
[[nodiscard]] double cpu_seconds_in(const std::string& stat, double ticks);

}  // namespace pipescout::host
