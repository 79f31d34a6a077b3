// SPDX-License-Identifier: Apache-2.0
#include <unistd.h>

#include <iostream>
#include <map>
#include <sensor_msgs/msg/battery_state.hpp>
#include <string>

#include "cli/session.hpp"
#include "core/fleet_table.hpp"
#include "pipescout/runtime/standard_topics.hpp"

namespace pipescout::host {
namespace {

constexpr Duration kRefresh = std::chrono::seconds(1);
/// A robot says how it is each second; one that was late says it in the next.
constexpr Duration kListening = std::chrono::milliseconds(2500);

struct FleetOptions {
  DiscoveryOptions discovery;
  bool once = false;
  bool json = false;
};

/// Fills a table with what the robots say.
class FleetListener {
 public:
  explicit FleetListener(Session& session)
      : session_(session),
        diagnostics_(session.node().create_subscription(
            many_robots(topics::kDiagnostics),
            [this](const diagnostic_msgs::msg::DiagnosticArray& message, const MessageInfo& info) {
              table_.diagnostics(message, info, steady_now());
            })) {}

  /// Looks for who is there, and for new batteries.
  void look() {
    table_.nodes(session_.nodes(false));
    for (const auto& [topic, types] : session_.graph().topics()) {
      if (types.contains("sensor_msgs/msg/BatteryState") && !batteries_.contains(topic)) {
        batteries_.emplace(topic,
                           session_.node().create_subscription<sensor_msgs::msg::BatteryState>(
                               topic, QoS::sensor_data(1),
                               [this, topic = topic](const sensor_msgs::msg::BatteryState& message,
                                                     const MessageInfo& info) {
                                 table_.battery(topic, message.percentage, info, steady_now());
                               }));
      }
    }
  }

  [[nodiscard]] std::vector<RobotState> robots() const { return table_.robots(steady_now()); }

 private:
  /// Room for what all components of a fleet say at once.
  static Topic<diagnostic_msgs::msg::DiagnosticArray> many_robots(
      Topic<diagnostic_msgs::msg::DiagnosticArray> topic) {
    constexpr std::size_t kStatuses = 1000;
    topic.requested.depth = kStatuses;
    return topic;
  }

  Session& session_;
  FleetTable table_;
  Subscription<diagnostic_msgs::msg::DiagnosticArray> diagnostics_;
  std::map<std::string, Subscription<sensor_msgs::msg::BatteryState>> batteries_;
};

void show(const std::vector<RobotState>& robots, bool json, bool refreshes) {
  if (json) {
    std::cout << to_json(robots, std::chrono::system_clock::now()) << std::endl;
    return;
  }
  if (refreshes) {
    std::cout << "\x1b[H\x1b[J";  // from the top left corner on
  }
  std::cout << to_text(robots) << std::flush;
}

int fleet_status(Session& session, const FleetOptions& options) {
  FleetListener listener(session);
  if (options.once) {
    session.settle();
    listener.look();
    session.spin_for(kListening);
    listener.look();
    const auto robots = listener.robots();
    show(robots, options.json, false);
    if (robots.empty()) {
      std::cerr << "no robot was found within " << options.discovery.spin_time << " s\n";
      return kExitError;
    }
    return kExitOk;
  }
  const bool refreshes = isatty(STDOUT_FILENO) == 1;
  const auto timer = session.node().create_timer(kRefresh, [&] {
    listener.look();
    show(listener.robots(), options.json, refreshes);
    if (!std::cout) {
      session.executor().stop();
    }
  });
  session.spin();
  return kExitOk;
}

}  // namespace

void add_fleet_commands(CLI::App& app, Action& action) {
  auto* group = app.add_subcommand("fleet", "Robots of a fleet");
  group->require_subcommand(1);
  const auto [status, options] = add_session_command<FleetOptions>(
      *group, action, "status",
      "Show who is there, since when, when it was last heard, its clock, losses, CPU and battery",
      false, fleet_status);
  status->add_flag("--once", options->once, "Show it once instead of each second");
  status->add_flag("--json", options->json, "As lines of JSON");
}

}  // namespace pipescout::host
