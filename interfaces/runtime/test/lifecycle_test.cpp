// SPDX-License-Identifier: Apache-2.0
#include "pipescout/runtime/lifecycle.hpp"

#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include <algorithm>
#include <array>
#include <lifecycle_msgs/msg/state.hpp>
#include <lifecycle_msgs/msg/transition.hpp>
#include <set>
#include <string>
#include <utility>
#include <vector>

namespace pipescout {
namespace {

using lifecycle_msgs::msg::State;
using lifecycle_msgs::msg::Transition;

constexpr std::array kPrimary{LifecycleState::kUnconfigured, LifecycleState::kInactive,
                              LifecycleState::kActive, LifecycleState::kFinalized};

bool is_primary(LifecycleState state) {
  return std::find(kPrimary.begin(), kPrimary.end(), state) != kPrimary.end();
}

std::vector<LifecycleEdge> edges_from(LifecycleState state) {
  std::vector<LifecycleEdge> result;
  for (const LifecycleEdge& edge : lifecycle_edges()) {
    if (edge.start == state) {
      result.push_back(edge);
    }
  }
  return result;
}

TEST(Lifecycle, StatesHaveTheNumbersAndLabelsOfLifecycleMsgs) {
  const std::vector<std::pair<int, std::string>> expected{
      {State::PRIMARY_STATE_UNKNOWN, "unknown"},
      {State::PRIMARY_STATE_UNCONFIGURED, "unconfigured"},
      {State::PRIMARY_STATE_INACTIVE, "inactive"},
      {State::PRIMARY_STATE_ACTIVE, "active"},
      {State::PRIMARY_STATE_FINALIZED, "finalized"},
      {State::TRANSITION_STATE_CONFIGURING, "configuring"},
      {State::TRANSITION_STATE_CLEANINGUP, "cleaningup"},
      {State::TRANSITION_STATE_SHUTTINGDOWN, "shuttingdown"},
      {State::TRANSITION_STATE_ACTIVATING, "activating"},
      {State::TRANSITION_STATE_DEACTIVATING, "deactivating"},
      {State::TRANSITION_STATE_ERRORPROCESSING, "errorprocessing"}};
  std::vector<std::pair<int, std::string>> actual;
  for (const LifecycleState state : lifecycle_states()) {
    actual.emplace_back(static_cast<int>(state), std::string(to_string(state)));
  }
  EXPECT_EQ(actual, expected);
}

// What `ros2 lifecycle list -a` of Humble prints, in its order.
TEST(Lifecycle, EdgesAreThoseOfRos) {
  const std::vector<std::pair<int, std::string>> expected{
      {Transition::TRANSITION_CONFIGURE, "configure"},
      {Transition::TRANSITION_ON_CONFIGURE_SUCCESS, "transition_success"},
      {Transition::TRANSITION_ON_CONFIGURE_FAILURE, "transition_failure"},
      {Transition::TRANSITION_ON_CONFIGURE_ERROR, "transition_error"},
      {Transition::TRANSITION_CLEANUP, "cleanup"},
      {Transition::TRANSITION_ON_CLEANUP_SUCCESS, "transition_success"},
      {Transition::TRANSITION_ON_CLEANUP_FAILURE, "transition_failure"},
      {Transition::TRANSITION_ON_CLEANUP_ERROR, "transition_error"},
      {Transition::TRANSITION_ACTIVATE, "activate"},
      {Transition::TRANSITION_ON_ACTIVATE_SUCCESS, "transition_success"},
      {Transition::TRANSITION_ON_ACTIVATE_FAILURE, "transition_failure"},
      {Transition::TRANSITION_ON_ACTIVATE_ERROR, "transition_error"},
      {Transition::TRANSITION_DEACTIVATE, "deactivate"},
      {Transition::TRANSITION_ON_DEACTIVATE_SUCCESS, "transition_success"},
      {Transition::TRANSITION_ON_DEACTIVATE_FAILURE, "transition_failure"},
      {Transition::TRANSITION_ON_DEACTIVATE_ERROR, "transition_error"},
      {Transition::TRANSITION_UNCONFIGURED_SHUTDOWN, "shutdown"},
      {Transition::TRANSITION_INACTIVE_SHUTDOWN, "shutdown"},
      {Transition::TRANSITION_ACTIVE_SHUTDOWN, "shutdown"},
      {Transition::TRANSITION_ON_SHUTDOWN_SUCCESS, "transition_success"},
      {Transition::TRANSITION_ON_SHUTDOWN_FAILURE, "transition_failure"},
      {Transition::TRANSITION_ON_SHUTDOWN_ERROR, "transition_error"},
      {Transition::TRANSITION_ON_ERROR_SUCCESS, "transition_success"},
      {Transition::TRANSITION_ON_ERROR_FAILURE, "transition_failure"},
      {Transition::TRANSITION_ON_ERROR_ERROR, "transition_error"}};
  std::vector<std::pair<int, std::string>> actual;
  for (const LifecycleEdge& edge : lifecycle_edges()) {
    actual.emplace_back(edge.id, std::string(edge.label));
  }
  EXPECT_EQ(actual, expected);
}

TEST(Lifecycle, NumbersNameOneEdgeEach) {
  std::set<int> seen;
  for (const LifecycleEdge& edge : lifecycle_edges()) {
    EXPECT_TRUE(seen.insert(edge.id).second) << int{edge.id};
  }
}

TEST(Lifecycle, RequestsStartInPrimaryStatesAndOutcomesEndThere) {
  for (const LifecycleEdge& edge : lifecycle_edges()) {
    if (edge.id < 10) {
      EXPECT_TRUE(is_primary(edge.start)) << int{edge.id};
      EXPECT_FALSE(is_primary(edge.goal)) << int{edge.id};
    } else {
      EXPECT_FALSE(is_primary(edge.start)) << int{edge.id};
      EXPECT_TRUE(is_primary(edge.goal) || edge.goal == LifecycleState::kErrorProcessing)
          << int{edge.id};
    }
  }
}

TEST(Lifecycle, EachTransitionStateHasThreeOutcomesAndFinalizedNoWayOut) {
  for (const LifecycleState state : lifecycle_states()) {
    const auto edges = edges_from(state);
    if (state == LifecycleState::kFinalized || state == LifecycleState::kUnknown) {
      EXPECT_TRUE(edges.empty()) << to_string(state);
    } else if (!is_primary(state)) {
      ASSERT_EQ(edges.size(), 3U) << to_string(state);
      EXPECT_EQ(edges[0].label, "transition_success");
      EXPECT_EQ(edges[1].label, "transition_failure");
      EXPECT_EQ(edges[2].label, "transition_error");
    }
  }
}

TEST(Lifecycle, ShutdownIsPossibleFromEveryPrimaryStateButTheLast) {
  using enum LifecycleTransition;
  EXPECT_EQ(requested_transition(LifecycleState::kUnconfigured, 0, "shutdown"),
            kUnconfiguredShutdown);
  EXPECT_EQ(requested_transition(LifecycleState::kInactive, 0, "shutdown"), kInactiveShutdown);
  EXPECT_EQ(requested_transition(LifecycleState::kActive, 0, "shutdown"), kActiveShutdown);
  EXPECT_EQ(requested_transition(LifecycleState::kFinalized, 0, "shutdown"), std::nullopt);
}

TEST(Lifecycle, TheLabelOverrulesTheNumber) {
  EXPECT_EQ(
      requested_transition(LifecycleState::kInactive, Transition::TRANSITION_CLEANUP, "activate"),
      LifecycleTransition::kActivate);
  EXPECT_EQ(
      requested_transition(LifecycleState::kInactive, Transition::TRANSITION_CLEANUP, "actvate"),
      std::nullopt);
}

RC_GTEST_PROP(LifecycleProperties, OnlyEdgesThatStartInTheStateCanBeRequested, ()) {
  const auto state = lifecycle_states()[*rc::gen::inRange<std::size_t>(0, 11)];
  const auto id = *rc::gen::arbitrary<std::uint8_t>();
  const auto transition = requested_transition(state, id, {});
  const auto edges = edges_from(state);
  const bool possible =
      id < 10 && std::any_of(edges.begin(), edges.end(),
                             [id](const LifecycleEdge& edge) { return edge.id == id; });
  RC_ASSERT(transition.has_value() == possible);
  if (transition) {
    RC_ASSERT(static_cast<std::uint8_t>(*transition) == id);
  }
}

RC_GTEST_PROP(LifecycleProperties, OutcomesCannotBeRequestedByLabel, ()) {
  const auto state = lifecycle_states()[*rc::gen::inRange<std::size_t>(0, 11)];
  const auto label = *rc::gen::element<std::string>("transition_success", "transition_failure",
                                                    "transition_error", "create", "destroy", " ");
  RC_ASSERT(!requested_transition(state, 1, label));
}

// A walk that takes any edge at each state: it never leaves the table, reaches no state but those
// listed, and stops in "finalized" only.
RC_GTEST_PROP(LifecycleProperties, EveryWalkStaysInTheTable, ()) {
  LifecycleState state = LifecycleState::kUnconfigured;
  const auto choices =
      *rc::gen::container<std::vector<std::size_t>>(rc::gen::inRange<std::size_t>(0, 1000));
  for (const std::size_t choice : choices) {
    const auto edges = edges_from(state);
    if (edges.empty()) {
      RC_ASSERT(state == LifecycleState::kFinalized);
      return;
    }
    state = edges[choice % edges.size()].goal;
    RC_ASSERT(std::count(lifecycle_states().begin(), lifecycle_states().end(), state) == 1);
  }
}

}  // namespace
}  // namespace pipescout
