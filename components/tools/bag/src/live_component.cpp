// SPDX-License-Identifier: Apache-2.0
#include "live_component.hpp"

#include <unistd.h>

#include <chrono>
#include <csignal>
#include <iostream>
#include <optional>
#include <pipescout_msgs/msg/mission_status.hpp>
#include <utility>

#include "pipescout/command_line/command.hpp"
#include "pipescout/dds/dds_transport.hpp"
#include "pipescout/runtime/bring_up.hpp"
#include "pipescout/runtime/component_registry.hpp"
#include "pipescout/runtime/standard_topics.hpp"
#include "pipescout/runtime/stop_signals.hpp"

namespace pipescout::bag_command {
namespace {

using pipescout_msgs::msg::MissionStatus;

constexpr Duration kGrace = std::chrono::seconds(2);

class Run {
 public:
  explicit Run(LiveComponent live)
      : live_(std::move(live)),
        signals_(
            kGrace, [this](int) { executor_.stop(); }, [] {}) {}

  int run() {
    auto dds = DdsOptions::from_environment();
    dds.name = live_.node_name;
    dds.hears_unexported = true;
    dds.super_client |= registry_.sees_whole_graph(live_.class_name);
    const auto context = Context::create(create_dds_transport(dds));
    const auto component =
        registry_.create(live_.class_name, {.context = context,
                                            .executor = &executor_,
                                            .name = {"/", live_.node_name},
                                            .remap_rules = live_.remap_rules,
                                            .parameter_overrides = live_.parameters});
    Node node({.context = context,
               .executor = &executor_,
               .name = {"/", "_pipescout_bag_" + std::to_string(getpid())},
               .standard_interfaces = false});
    const auto status = node.create_subscription(
        topics::kMissionStatus, [&](const MissionStatus& message) { follow(message); });
    std::shared_ptr<void> attendant;
    bring_up(*component, [&](const TransitionResult& result) {
      if (!result.success) {
        fail(result.message);
      } else if (live_.attend) {
        attendant = live_.attend(node);
      }
    });
    executor_.spin();
    signals_.expect_end();
    attendant.reset();
    take_down(*component, [this] { executor_.stop(); });
    executor_.spin();
    return failed_ ? command_line::kExitError : command_line::kExitOk;
  }

 private:
  void follow(const MissionStatus& message) {
    if (message.node != "/" + live_.node_name) {
      return;
    }
    if (message.state == MissionStatus::FAILED) {
      fail(message.message);
    } else if (message.state == MissionStatus::COMPLETE) {
      executor_.stop();
    }
  }
  void fail(const std::string& why) {
    std::cerr << "error: " << why << '\n';
    failed_ = true;
    executor_.stop();
  }

  LiveComponent live_;
  bool failed_ = false;
  Executor executor_;
  /// Goes after all that may hang while it is destroyed.
  StopSignals signals_;
  ComponentRegistry registry_;
};

}  // namespace

int run_live(LiveComponent live) {
  std::signal(SIGPIPE, SIG_IGN);
  StopSignals::block();
  return Run(std::move(live)).run();
}

ParameterOverride override_of(const char* name, ParameterValue value) {
  return {.name = name, .value = std::move(value), .source = "command line"};
}

}  // namespace pipescout::bag_command
