// SPDX-License-Identifier: Apache-2.0
#include "core/fleet_table.hpp"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <nlohmann/json.hpp>
#include <sstream>

#include "pipescout/command_line/text_table.hpp"
#include "pipescout/files/utc_text.hpp"

namespace pipescout::host {
namespace {

/// The shortest way of so many messages counts for the clock offset.
constexpr std::size_t kOffsets = 20;

/// A component says how it is each second.
constexpr Duration kStale = std::chrono::seconds(5);

/// From which on transforms between robots and the order of events are no longer to be trusted.
constexpr Duration kLargeClockOffset = std::chrono::milliseconds(500);

constexpr std::array<std::string_view, 4> kDrops{": dropped_queue_full", ": lost_by_network",
                                                 ": malformed", ": send_failures"};

template <class Number>
std::optional<Number> parse_number(const std::string& text) {
  Number number{};
  const char* end = text.data() + text.size();
  const auto [parsed, error] = std::from_chars(text.data(), end, number);
  return error == std::errc{} && parsed == end ? std::optional(number) : std::nullopt;
}

DiagnosticLevel level_of(std::uint8_t level) {
  return level <= static_cast<std::uint8_t>(DiagnosticLevel::kStale)
             ? static_cast<DiagnosticLevel>(level)
             : DiagnosticLevel::kError;
}

std::string_view level_text(DiagnosticLevel level) {
  constexpr std::array<std::string_view, 4> kTexts{"ok", "warning", "error", "stale"};
  return kTexts.at(static_cast<std::size_t>(level));
}

std::string utc(Time time, UtcForm form) {
  return utc_text(std::chrono::time_point_cast<std::chrono::milliseconds>(time), form);
}

std::string in_seconds(Duration duration) {
  std::ostringstream text;
  text.setf(std::ios::fixed);
  text.precision(1);
  text << std::round(10.0 * to_seconds(duration)) / 10.0 + 0.0 << " s";  // + 0.0: never "-0.0"
  return text.str();
}

/// What of a robot is not as it should be, for people.
std::vector<std::string> concerns(const RobotState& robot) {
  std::vector<std::string> texts;
  if (robot.nodes == 0) {
    texts.push_back("has left, or cannot be reached");
  } else if (robot.last_heard && *robot.last_heard > kStale) {
    texts.push_back("is silent since " + in_seconds(*robot.last_heard));
  }
  if (robot.clock_offset && std::chrono::abs(*robot.clock_offset) >= kLargeClockOffset) {
    texts.push_back("has a clock that is " + in_seconds(std::chrono::abs(*robot.clock_offset)) +
                    (*robot.clock_offset > Duration::zero() ? " ahead" : " behind"));
  }
  if (robot.level != DiagnosticLevel::kOk) {
    texts.push_back(std::string(level_text(robot.level)) + ": " + robot.message);
  }
  return texts;
}

template <class Value>
nlohmann::json or_null(const std::optional<Value>& value) {
  return value ? nlohmann::json(*value) : nlohmann::json();
}

std::optional<double> seconds_or_nothing(const std::optional<Duration>& duration) {
  return duration ? std::optional(to_seconds(*duration)) : std::nullopt;
}

}  // namespace

std::string robot_of(std::string_view name) {
  name = name.substr(0, name.find(':'));
  if (name.starts_with('/')) {
    name.remove_prefix(1);
  }
  const auto slash = name.find('/');
  return slash == std::string_view::npos ? "/" : std::string(name.substr(0, slash));
}

void FleetTable::nodes(const std::vector<NodeName>& nodes) {
  for (auto& [name, robot] : robots_) {
    robot.nodes = 0;
  }
  for (const auto& node : nodes) {
    ++robots_[robot_of(node.fully_qualified())].nodes;
  }
}

void FleetTable::hear(Robot& robot, const MessageInfo& info, SteadyTime now) {
  robot.heard = now;
  if (info.from_this_process) {
    return;
  }
  const Duration offset = info.source_time - info.reception_time;
  if (robot.clock_offsets.size() < kOffsets) {
    robot.clock_offsets.push_back(offset);
  } else {
    robot.clock_offsets[robot.next_offset] = offset;
    robot.next_offset = (robot.next_offset + 1) % kOffsets;
  }
}

void FleetTable::diagnostics(const diagnostic_msgs::msg::DiagnosticArray& message,
                             const MessageInfo& info, SteadyTime now) {
  for (const auto& said : message.status) {
    Robot& robot = robots_[robot_of(said.name)];
    hear(robot, info, now);
    Status status{.level = level_of(said.level), .message = said.message, .heard = now};
    for (const auto& [key, value] : said.values) {
      const bool is_drop = std::any_of(kDrops.begin(), kDrops.end(), [&key = key](auto suffix) {
        return std::string_view(key).ends_with(suffix);
      });
      if (is_drop) {
        status.drops += parse_number<std::uint64_t>(value).value_or(0);
      } else if (key == "cpu_percent") {
        status.cpu_percent = parse_number<double>(value);
      } else if (key == "started") {
        if (const auto seconds = parse_number<double>(value)) {
          status.started = Time(from_seconds(*seconds));
        }
      }
    }
    robot.statuses.insert_or_assign(said.name, std::move(status));
  }
}

void FleetTable::battery(const std::string& topic, double percentage, const MessageInfo& info,
                         SteadyTime now) {
  constexpr double kPercent = 100.0;
  Robot& robot = robots_[robot_of(topic)];
  hear(robot, info, now);
  robot.battery_percent =
      std::isfinite(percentage) ? std::optional(kPercent * percentage) : std::nullopt;
}

std::vector<RobotState> FleetTable::robots(SteadyTime now) const {
  std::vector<RobotState> result;
  for (const auto& [name, robot] : robots_) {
    RobotState state;
    state.name = name;
    state.nodes = robot.nodes;
    if (robot.heard) {
      state.last_heard = now - *robot.heard;
    }
    if (!robot.clock_offsets.empty()) {
      state.clock_offset =
          *std::max_element(robot.clock_offsets.begin(), robot.clock_offsets.end());
    }
    state.battery_percent = robot.battery_percent;
    for (const auto& [what, status] : robot.statuses) {
      state.drops += status.drops;
      if (status.started) {
        state.started = std::min(state.started.value_or(*status.started), *status.started);
      }
      if (now - status.heard > kStale) {
        continue;  // of a component that has gone
      }
      if (status.cpu_percent) {
        state.cpu_percent = state.cpu_percent.value_or(0.0) + *status.cpu_percent;
      }
      if (status.level > state.level) {
        state.level = status.level;
        state.message = what + ": " + status.message;
      }
    }
    result.push_back(std::move(state));
  }
  return result;
}

std::string to_text(const std::vector<RobotState>& robots) {
  using Cell = command_line::TextTable::Cell;
  const auto number = [](const std::optional<double>& value) {
    return value ? Cell(std::round(*value * 10.0) / 10.0) : Cell();
  };
  const auto text = [](const std::optional<Duration>& value) {
    return value ? Cell(in_seconds(*value)) : Cell();
  };
  command_line::TextTable table(
      {"robot", "nodes", "since", "last heard", "clock", "drops", "CPU %", "battery %"});
  std::string notes;
  for (const RobotState& robot : robots) {
    table.add_row({robot.name, static_cast<std::int64_t>(robot.nodes),
                   robot.started ? Cell(utc(*robot.started, UtcForm::kReadable)) : Cell(),
                   text(robot.last_heard), text(robot.clock_offset),
                   static_cast<std::int64_t>(robot.drops), number(robot.cpu_percent),
                   number(robot.battery_percent)});
    for (const std::string& concern : concerns(robot)) {
      notes += robot.name + " " + concern + "\n";
    }
  }
  std::ostringstream out;
  table.print(out);
  return out.str() + notes;
}

std::string to_json(const std::vector<RobotState>& robots, Time time) {
  auto rows = nlohmann::json::array();
  for (const RobotState& robot : robots) {
    nlohmann::json row;
    row["name"] = robot.name;
    row["nodes"] = robot.nodes;
    row["started"] =
        robot.started ? nlohmann::json(utc(*robot.started, UtcForm::kIso)) : nlohmann::json();
    row["last_heard_s"] = or_null(seconds_or_nothing(robot.last_heard));
    row["clock_offset_s"] = or_null(seconds_or_nothing(robot.clock_offset));
    row["drops"] = robot.drops;
    row["cpu_percent"] = or_null(robot.cpu_percent);
    row["battery_percent"] = or_null(robot.battery_percent);
    row["level"] = level_text(robot.level);
    row["message"] = robot.message;
    row["concerns"] = concerns(robot);
    rows.push_back(std::move(row));
  }
  const nlohmann::json document{{"time", utc(time, UtcForm::kIso)}, {"robots", std::move(rows)}};
  return document.dump(-1, ' ', false, nlohmann::json::error_handler_t::replace);
}

}  // namespace pipescout::host
