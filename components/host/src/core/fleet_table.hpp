// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <diagnostic_msgs/msg/diagnostic_array.hpp>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "pipescout/runtime/diagnostics.hpp"
#include "pipescout/runtime/names.hpp"
#include "pipescout/runtime/time.hpp"
#include "pipescout/runtime/transport.hpp"

/// What an operator wants to know of the robots of a fleet, from what they publish. A robot is what
/// is below the first part of a namespace: "robot_1"; "/" for all without a namespace.
namespace pipescout::host {

struct RobotState {
  std::string name;
  std::size_t nodes = 0;               ///< in the graph now; 0: it has left, or cannot be reached
  std::optional<Time> started;         ///< of its first process, by the clock of the robot
  std::optional<Duration> last_heard;  ///< ago; nothing: never
  /// The clock of the robot minus that of this machine, with the sign that it is ahead; less than
  /// that by the shortest time that a message took.
  std::optional<Duration> clock_offset;
  std::uint64_t drops = 0;  ///< messages that its components lost since they began
  std::optional<double> cpu_percent;
  std::optional<double> battery_percent;
  DiagnosticLevel level = DiagnosticLevel::kOk;  ///< the worst of its statuses
  std::string message;                           ///< that of the worst; empty: all is well
};

/// Keeps what it is told of each robot. Not thread-safe.
class FleetTable {
 public:
  /// The nodes that are in the graph now, without hidden ones.
  void nodes(const std::vector<NodeName>& nodes);
  /// A message on /diagnostics.
  void diagnostics(const diagnostic_msgs::msg::DiagnosticArray& message, const MessageInfo& info,
                   SteadyTime now);
  /// `percentage` in [0, 1]; not finite: unknown.
  void battery(const std::string& topic, double percentage, const MessageInfo& info,
               SteadyTime now);

  /// By name.
  [[nodiscard]] std::vector<RobotState> robots(SteadyTime now) const;

 private:
  struct Status {
    DiagnosticLevel level = DiagnosticLevel::kOk;
    std::string message;
    std::uint64_t drops = 0;
    std::optional<Time> started;
    std::optional<double> cpu_percent;
    SteadyTime heard{};
  };
  struct Robot {
    std::size_t nodes = 0;
    std::optional<SteadyTime> heard;
    std::vector<Duration> clock_offsets;  ///< the newest, a ring
    std::size_t next_offset = 0;
    std::optional<double> battery_percent;
    std::map<std::string, Status> statuses;
  };

  void hear(Robot& robot, const MessageInfo& info, SteadyTime now);

  std::map<std::string, Robot> robots_;
};

/// "robot_1" for "/robot_1/arm/joints" and for "robot_1/fusion: status"; "/" without a namespace.
[[nodiscard]] std::string robot_of(std::string_view name);

/// As a table for people, with a line for each thing that an operator should look at.
[[nodiscard]] std::string to_text(const std::vector<RobotState>& robots);
/// One line of JSON, `time` is that of this machine.
[[nodiscard]] std::string to_json(const std::vector<RobotState>& robots, Time time);

}  // namespace pipescout::host
