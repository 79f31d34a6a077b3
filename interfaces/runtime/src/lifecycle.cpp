// SPDX-License-Identifier: Apache-2.0
#include "pipescout/runtime/lifecycle.hpp"

#include <algorithm>
#include <array>

namespace pipescout {

namespace {

using enum LifecycleState;

// The numbers are those of lifecycle_msgs/msg/Transition, labels and order those of rcl_lifecycle:
// what `ros2 lifecycle list -a` prints.
constexpr std::array<LifecycleEdge, 25> kEdges{{
    {1, "configure", kUnconfigured, kConfiguring},
    {10, "transition_success", kConfiguring, kInactive},
    {11, "transition_failure", kConfiguring, kUnconfigured},
    {12, "transition_error", kConfiguring, kErrorProcessing},
    {2, "cleanup", kInactive, kCleaningUp},
    {20, "transition_success", kCleaningUp, kUnconfigured},
    {21, "transition_failure", kCleaningUp, kInactive},
    {22, "transition_error", kCleaningUp, kErrorProcessing},
    {3, "activate", kInactive, kActivating},
    {30, "transition_success", kActivating, kActive},
    {31, "transition_failure", kActivating, kInactive},
    {32, "transition_error", kActivating, kErrorProcessing},
    {4, "deactivate", kActive, kDeactivating},
    {40, "transition_success", kDeactivating, kInactive},
    {41, "transition_failure", kDeactivating, kActive},
    {42, "transition_error", kDeactivating, kErrorProcessing},
    {5, "shutdown", kUnconfigured, kShuttingDown},
    {6, "shutdown", kInactive, kShuttingDown},
    {7, "shutdown", kActive, kShuttingDown},
    {50, "transition_success", kShuttingDown, kFinalized},
    {51, "transition_failure", kShuttingDown, kFinalized},
    {52, "transition_error", kShuttingDown, kErrorProcessing},
    {60, "transition_success", kErrorProcessing, kUnconfigured},
    {61, "transition_failure", kErrorProcessing, kFinalized},
    {62, "transition_error", kErrorProcessing, kFinalized},
}};

constexpr std::array<LifecycleState, 11> kStates{
    kUnknown,    kUnconfigured, kInactive,   kActive,       kFinalized,      kConfiguring,
    kCleaningUp, kShuttingDown, kActivating, kDeactivating, kErrorProcessing};

constexpr std::uint8_t kLastRequestable =
    static_cast<std::uint8_t>(LifecycleTransition::kActiveShutdown);

}  // namespace

std::string_view to_string(LifecycleState state) noexcept {
  switch (state) {
    case kUnknown:
      return "unknown";
    case kUnconfigured:
      return "unconfigured";
    case kInactive:
      return "inactive";
    case kActive:
      return "active";
    case kFinalized:
      return "finalized";
    case kConfiguring:
      return "configuring";
    case kCleaningUp:
      return "cleaningup";
    case kShuttingDown:
      return "shuttingdown";
    case kActivating:
      return "activating";
    case kDeactivating:
      return "deactivating";
    case kErrorProcessing:
      return "errorprocessing";
  }
  return "unknown";
}

std::string_view to_string(LifecycleTransition transition) noexcept {
  const auto id = static_cast<std::uint8_t>(transition);
  const auto edge =
      std::find_if(kEdges.begin(), kEdges.end(),
                   [id](const LifecycleEdge& candidate) { return candidate.id == id; });
  return edge == kEdges.end() ? "unknown" : edge->label;
}

std::span<const LifecycleEdge> lifecycle_edges() noexcept {
  return kEdges;
}

std::span<const LifecycleState> lifecycle_states() noexcept {
  return kStates;
}

std::optional<LifecycleTransition> requested_transition(LifecycleState state, std::uint8_t id,
                                                        std::string_view label) noexcept {
  for (const LifecycleEdge& edge : kEdges) {
    const bool requestable = edge.id >= 1 && edge.id <= kLastRequestable;
    const bool meant = label.empty() ? edge.id == id : edge.label == label;
    if (requestable && edge.start == state && meant) {
      return static_cast<LifecycleTransition>(edge.id);
    }
  }
  return std::nullopt;
}

}  // namespace pipescout
