// SPDX-License-Identifier: Apache-2.0
#include "run/host_node.hpp"

#include <algorithm>
#include <set>
#include <utility>

#include "pipescout/runtime/conversions.hpp"
#include "pipescout/runtime/lifecycle.hpp"
#include "pipescout/runtime/standard_topics.hpp"

namespace pipescout::host {
namespace {

ComponentReport to_report(const pipescout_msgs::msg::MissionStatus& message) {
  using pipescout_msgs::msg::MissionStatus;
  ComponentReport report;
  switch (message.state) {
    case MissionStatus::COMPLETE:
      report.state = ComponentReport::State::kComplete;
      break;
    case MissionStatus::FAILED:
      report.state = ComponentReport::State::kFailed;
      break;
    default:
      break;
  }
  report.done = message.done;
  report.total = message.total;
  report.message = message.message;
  return report;
}

/// As Logger names a node: "/robot_1/fusion" -> "robot_1.fusion".
std::string logger_name(const NodeName& node) {
  auto name = node.fully_qualified().substr(1);
  std::replace(name.begin(), name.end(), '/', '.');
  return name;
}

}  // namespace

ErrorWatch watch_errors(Node& node, const std::shared_ptr<CallbackGroup>& group,
                        const NodeName& component, std::function<void()> broke) {
  return node.create_subscription<lifecycle_msgs::msg::TransitionEvent>(
      component.fully_qualified() + "/transition_event", QoS::reliable(),
      [broke = std::move(broke)](const lifecycle_msgs::msg::TransitionEvent& event) {
        constexpr auto kError = static_cast<std::uint8_t>(LifecycleState::kErrorProcessing);
        if (event.goal_state.id == kError) {
          broke();
        }
      },
      {.group = group, .managed = false});
}

HostNode::HostNode(Node& node, const std::vector<NodeName>& components,
                   const std::vector<NodeName>& watched, Callbacks callbacks)
    : node_(node),
      components_(components),
      group_(node.create_callback_group(CallbackGroupType::kMutuallyExclusive)),
      diagnostics_(
          node.create_publisher(topics::kDiagnostics, {.group = group_, .managed = false})) {
  // One queue takes the reports of all components: room for what comes while it waits.
  auto qos = topics::kMissionStatus.requested;
  qos.depth = 1000;
  std::set<std::string> namespaces;
  for (const auto& component : components) {
    namespaces.insert(component.ns);
  }
  for (const auto& ns : namespaces) {
    const auto topic = (ns == "/" ? "/" : ns + "/") + std::string(topics::kMissionStatus.name);
    status_.push_back(node.create_subscription<pipescout_msgs::msg::MissionStatus>(
        topic, qos,
        [this, reported = callbacks.reported](const pipescout_msgs::msg::MissionStatus& message) {
          const auto component = std::find_if(
              components_.begin(), components_.end(),
              [&](const NodeName& name) { return name.fully_qualified() == message.node; });
          if (component != components_.end()) {
            reported(*component, to_report(message));
          }
        },
        {.group = group_, .managed = false}));
  }
  for (const auto& name : watched) {
    watches_.push_back(
        watch_errors(node, group_, name, [name, broke = callbacks.broke] { broke(name); }));
  }
}

void HostNode::log_into(MissionFolder& folder) {
  std::set<std::string> names{logger_name(node_.node_name())};
  for (const auto& component : components_) {
    names.insert(logger_name(component));
  }
  rosout_ = node_.create_subscription(
      topics::kRosout,
      [&folder, names = std::move(names)](const rcl_interfaces::msg::Log& log) {
        if (names.contains(log.name)) {
          folder.log(static_cast<LogSeverity>(log.level), from_message(log.stamp), log.name,
                     log.msg);
        }
      },
      {.group = group_, .managed = false});
}

void HostNode::when_logged(std::function<void()> done) {
  // The group runs its work in order.
  group_->post(std::move(done));
}

void HostNode::publish_diagnostics(std::vector<diagnostic_msgs::msg::DiagnosticStatus> status) {
  diagnostic_msgs::msg::DiagnosticArray array;
  array.header.stamp = to_message(node_.now());
  array.status = std::move(status);
  diagnostics_.publish(std::move(array));
}

}  // namespace pipescout::host
