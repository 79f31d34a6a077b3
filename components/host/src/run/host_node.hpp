// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <diagnostic_msgs/msg/diagnostic_array.hpp>
#include <functional>
#include <lifecycle_msgs/msg/transition_event.hpp>
#include <memory>
#include <pipescout_msgs/msg/mission_status.hpp>
#include <rcl_interfaces/msg/log.hpp>
#include <string>
#include <vector>

#include "core/mission_folder.hpp"
#include "core/mission_progress.hpp"
#include "pipescout/runtime/node.hpp"

namespace pipescout::host {

using ErrorWatch = Subscription<lifecycle_msgs::msg::TransitionEvent>;

/// Calls `broke` when a component goes through its error state. Only for a component of this
/// process: what it says right after it was found would be lost on the way to another.
[[nodiscard]] ErrorWatch watch_errors(Node& node, const std::shared_ptr<CallbackGroup>& group,
                                      const NodeName& component, std::function<void()> broke);

/// What the host hears of its components, and says of their processes, on topics. The callbacks run
/// on the executor.
class HostNode {
 public:
  struct Callbacks {
    std::function<void(const NodeName&, ComponentReport)> reported;
    /// A watched component went through its error state: it will not complete any more.
    std::function<void(const NodeName&)> broke;
  };

  /// `node` must outlive this object; `components` are the names that reports are taken from,
  /// `watched` those components of this process whose errors are wanted.
  HostNode(Node& node, const std::vector<NodeName>& components,
           const std::vector<NodeName>& watched, Callbacks callbacks);

  /// Writes what the components say on `/rosout`, from their start on, into the folder's log. The
  /// folder must outlive this object. Messages of other robots and programs are left out.
  void log_into(MissionFolder& folder);
  /// Calls `done` once all messages that have arrived so far are written.
  void when_logged(std::function<void()> done);

  /// Publishes the state of the isolated components on `/diagnostics`.
  void publish_diagnostics(std::vector<diagnostic_msgs::msg::DiagnosticStatus> status);

 private:
  Node& node_;
  std::vector<NodeName> components_;
  std::shared_ptr<CallbackGroup> group_;
  std::vector<Subscription<pipescout_msgs::msg::MissionStatus>> status_;
  std::vector<ErrorWatch> watches_;
  Subscription<rcl_interfaces::msg::Log> rosout_;
  Publisher<diagnostic_msgs::msg::DiagnosticArray> diagnostics_;
};

}  // namespace pipescout::host
