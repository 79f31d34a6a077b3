// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string_view>

/// The managed lifecycle of ROS 2 as data: states, transitions and edges. Numbers and labels are
/// those of lifecycle_msgs.
namespace pipescout {

enum class LifecycleState : std::uint8_t {
  kUnknown = 0,
  kUnconfigured = 1,
  kInactive = 2,
  kActive = 3,
  kFinalized = 4,
  kConfiguring = 10,
  kCleaningUp = 11,
  kShuttingDown = 12,
  kActivating = 13,
  kDeactivating = 14,
  kErrorProcessing = 15
};

/// Transitions that can be requested.
enum class LifecycleTransition : std::uint8_t {
  kConfigure = 1,
  kCleanup = 2,
  kActivate = 3,
  kDeactivate = 4,
  kUnconfiguredShutdown = 5,
  kInactiveShutdown = 6,
  kActiveShutdown = 7
};

/// The result of a lifecycle callback.
enum class CallbackReturn : std::uint8_t {
  kSuccess,  ///< go on to the goal state
  kFailure,  ///< back to the state before
  kError     ///< on_error decides
};

struct LifecycleEdge {
  std::uint8_t id;         ///< lifecycle_msgs/msg/Transition
  std::string_view label;  ///< as rcl_lifecycle: "configure", "transition_failure", ...
  LifecycleState start;
  LifecycleState goal;
};

[[nodiscard]] std::string_view to_string(LifecycleState state) noexcept;  ///< "active"
[[nodiscard]] std::string_view to_string(LifecycleTransition transition) noexcept;

/// All edges, as `get_transition_graph` lists them.
[[nodiscard]] std::span<const LifecycleEdge> lifecycle_edges() noexcept;
/// All states, as `get_available_states` lists them.
[[nodiscard]] std::span<const LifecycleState> lifecycle_states() noexcept;

/// The transition for a request in a state: by id, or, when the label is not empty, by label
/// ("shutdown" selects that of the state). Nothing when the state does not allow it.
[[nodiscard]] std::optional<LifecycleTransition> requested_transition(
    LifecycleState state, std::uint8_t id, std::string_view label) noexcept;

}  // namespace pipescout
