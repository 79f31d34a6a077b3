// SPDX-License-Identifier: Apache-2.0
#include "lifecycle_services.hpp"

#include <gtest/gtest.h>

#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "pipescout/testing/component_harness.hpp"

namespace pipescout {
namespace {

namespace srv = lifecycle_msgs::srv;
using lifecycle_msgs::msg::TransitionEvent;
using testing::Collector;
using testing::ComponentHarness;

/// Answers each lifecycle callback as the test says.
class Scripted : public Component {
 public:
  explicit Scripted(ComponentOptions options) : Component(std::move(options)) {}

  CallbackReturn configure_result = CallbackReturn::kSuccess;
  CallbackReturn error_result = CallbackReturn::kSuccess;
  std::string reason;
  bool throw_in_activate = false;

 private:
  CallbackReturn on_configure() override {
    if (!reason.empty()) {
      diagnostics().set_status(DiagnosticLevel::kError, reason);
    }
    return configure_result;
  }
  CallbackReturn on_activate() override {
    if (throw_in_activate) {
      throw std::runtime_error("the motor does not answer");
    }
    return CallbackReturn::kSuccess;
  }
  CallbackReturn on_error() override { return error_result; }
};

/// A callback of another group throws just before it is activated.
class Overtaken : public Component {
 public:
  explicit Overtaken(ComponentOptions options) : Component(std::move(options)) {}

  void publish() { publisher_.publish(TransitionEvent{}); }
  void break_soon() {
    group_->post([] { throw std::runtime_error("the encoder is gone"); });
  }

 private:
  CallbackReturn on_configure() override {
    publisher_ = create_publisher<TransitionEvent>("~/out", QoS::reliable());
    return CallbackReturn::kSuccess;
  }
  CallbackReturn on_cleanup() override { return CallbackReturn::kSuccess; }

  const std::shared_ptr<CallbackGroup> group_ =
      create_callback_group(CallbackGroupType::kReentrant);
  Publisher<TransitionEvent> publisher_;
};

class LifecycleServicesTest : public ::testing::Test {
 protected:
  bool change(std::uint8_t id, const std::string& label = {}) {
    srv::ChangeState::Request request;
    request.transition.id = id;
    request.transition.label = label;
    const auto result = harness_.call<srv::ChangeState>("/arm/change_state", request);
    EXPECT_TRUE(result);
    return result && result->success;
  }

  std::pair<int, std::string> state() {
    const auto result = harness_.call<srv::GetState>("/arm/get_state", {});
    EXPECT_TRUE(result);
    return result
               ? std::pair<int, std::string>(result->current_state.id, result->current_state.label)
               : std::pair<int, std::string>();
  }

  std::vector<std::string> path() const {
    std::vector<std::string> result;
    for (const auto& event : events_.messages()) {
      result.push_back(event->start_state.label + " -" + std::to_string(event->transition.id) +
                       "-> " + event->goal_state.label);
    }
    return result;
  }

  ComponentHarness harness_;
  Scripted& component_ = harness_.make<Scripted>({.name = "arm"});
  Collector<TransitionEvent> events_ = harness_.collect<TransitionEvent>("/arm/transition_event");
};

TEST_F(LifecycleServicesTest, GoesThroughTheWholeLife) {
  EXPECT_EQ(state(), std::pair(1, std::string("unconfigured")));
  EXPECT_TRUE(change(1));
  EXPECT_EQ(state(), std::pair(2, std::string("inactive")));
  EXPECT_TRUE(change(3));
  EXPECT_EQ(state(), std::pair(3, std::string("active")));
  EXPECT_TRUE(change(4));
  EXPECT_TRUE(change(2));
  EXPECT_TRUE(change(5));
  EXPECT_EQ(state(), std::pair(4, std::string("finalized")));
  EXPECT_EQ(path(), (std::vector<std::string>{
                        "unconfigured -1-> configuring", "configuring -10-> inactive",
                        "inactive -3-> activating", "activating -30-> active",
                        "active -4-> deactivating", "deactivating -40-> inactive",
                        "inactive -2-> cleaningup", "cleaningup -20-> unconfigured",
                        "unconfigured -5-> shuttingdown", "shuttingdown -50-> finalized"}));
  EXPECT_GT(events_.at(0).timestamp, 0U);
}

TEST_F(LifecycleServicesTest, TakesLabelsToo) {
  EXPECT_TRUE(change(0, "configure"));
  EXPECT_TRUE(change(0, "activate"));
  EXPECT_TRUE(change(0, "shutdown"));
  EXPECT_EQ(state().second, "finalized");
}

TEST_F(LifecycleServicesTest, RefusesWhatTheStateDoesNotAllow) {
  EXPECT_FALSE(change(3));
  EXPECT_FALSE(change(0));
  EXPECT_FALSE(change(10));
  EXPECT_FALSE(change(200));
  EXPECT_FALSE(change(1, "explode"));
  EXPECT_FALSE(change(0, "transition_success"));
  EXPECT_EQ(state().second, "unconfigured");
  EXPECT_TRUE(events_.empty());
  bool logged = false;
  for (const auto& entry : harness_.logs()) {
    logged = logged || entry.text.find("'explode'") != std::string::npos;
  }
  EXPECT_TRUE(logged);
}

TEST_F(LifecycleServicesTest, AFailureLeadsBack) {
  component_.configure_result = CallbackReturn::kFailure;
  EXPECT_FALSE(change(1));
  EXPECT_EQ(state().second, "unconfigured");
  EXPECT_EQ(path(), (std::vector<std::string>{"unconfigured -1-> configuring",
                                              "configuring -11-> unconfigured"}));
  component_.configure_result = CallbackReturn::kSuccess;
  EXPECT_TRUE(change(1));
}

TEST_F(LifecycleServicesTest, AFailureIsShownOnDiagnosticsWithItsReason) {
  component_.configure_result = CallbackReturn::kFailure;
  EXPECT_FALSE(change(1));
  auto status = harness_.diagnostics(component_).back();
  EXPECT_EQ(status.level, diagnostic_msgs::msg::DiagnosticStatus::ERROR);
  EXPECT_EQ(status.message, "on_configure failed");

  component_.reason = "port 5 does not open";
  EXPECT_EQ(harness_.configure(component_).message, "on_configure failed: port 5 does not open");
  EXPECT_EQ(harness_.configure(component_).message, "on_configure failed: port 5 does not open");
  status = harness_.diagnostics(component_).back();
  EXPECT_EQ(status.level, diagnostic_msgs::msg::DiagnosticStatus::ERROR);
  EXPECT_EQ(status.message, "on_configure failed: port 5 does not open");

  component_.configure_result = CallbackReturn::kSuccess;
  EXPECT_TRUE(change(1));
  status = harness_.diagnostics(component_).back();
  EXPECT_EQ(status.level, diagnostic_msgs::msg::DiagnosticStatus::OK);
  EXPECT_EQ(status.message, "inactive");
}

/// Its constructor runs whatever the executor has for it, as another thread might.
class Slow : public Component {
 public:
  explicit Slow(ComponentOptions options) : Component(std::move(options)) {
    for (const auto& group :
         {default_group(), create_callback_group(CallbackGroupType::kReentrant)}) {
      group->post([this] { ++(complete_ ? called : called_incomplete); });
    }
    executor().spin_ready();
    complete_ = true;
  }

  int called = 0;
  int called_incomplete = 0;

 private:
  bool complete_ = false;
};

TEST_F(LifecycleServicesTest, AreNotServedBeforeTheConstructorHasFinished) {
  auto client = harness_.peer().create_client<srv::ChangeState>("/slow/change_state");
  srv::ChangeState::Request request;
  request.transition.id = 1;
  bool answered = false;
  client.call(request, [&answered](const Client<srv::ChangeState>::Result& result) {
    answered = result && result->success;
  });
  auto& slow = harness_.make<Slow>({.name = "slow"});
  EXPECT_EQ(slow.state(), LifecycleState::kUnconfigured);
  EXPECT_TRUE(harness_.spin_until([&answered] { return answered; }));
  EXPECT_EQ(slow.state(), LifecycleState::kInactive);
  EXPECT_EQ(slow.called, 2);
  EXPECT_EQ(slow.called_incomplete, 0);
}

TEST_F(LifecycleServicesTest, AComponentMadeByHandIsServedFromItsFirstTransitionOn) {
  Scripted by_hand(harness_.component_options({.name = "by_hand"}));
  harness_.spin();
  EXPECT_TRUE(harness_.configure(by_hand).success);
  const auto result = harness_.call<srv::GetState>("/by_hand/get_state", {});
  ASSERT_TRUE(result);
  EXPECT_EQ(result->current_state.label, "inactive");
}

TEST_F(LifecycleServicesTest, AnExceptionBesideATransitionToActiveLeavesTheEndpointsDisabled) {
  auto& active = harness_.make<Overtaken>({.name = "overtaken"});
  const auto out = harness_.collect<TransitionEvent>("/overtaken/out");
  ASSERT_TRUE(harness_.configure(active).success);
  active.break_soon();
  ASSERT_TRUE(harness_.activate(active).success);
  EXPECT_EQ(active.state(), LifecycleState::kUnconfigured);
  active.publish();
  harness_.spin();
  EXPECT_TRUE(out.empty());
}

TEST_F(LifecycleServicesTest, AnErrorLeadsToTheErrorState) {
  component_.configure_result = CallbackReturn::kError;
  EXPECT_FALSE(change(1));
  EXPECT_EQ(state().second, "unconfigured");
  EXPECT_EQ(path(), (std::vector<std::string>{"unconfigured -1-> configuring",
                                              "configuring -12-> errorprocessing",
                                              "errorprocessing -60-> unconfigured"}));
}

TEST_F(LifecycleServicesTest, AnExceptionIsAnError) {
  component_.throw_in_activate = true;
  component_.error_result = CallbackReturn::kFailure;
  ASSERT_TRUE(change(1));
  EXPECT_FALSE(change(3));
  EXPECT_EQ(state().second, "finalized");
  ASSERT_EQ(events_.size(), 5U);
  EXPECT_EQ(path()[3], "activating -32-> errorprocessing");
  EXPECT_EQ(path()[4], "errorprocessing -61-> finalized");
}

TEST_F(LifecycleServicesTest, RequestsThatCrossAreTakenInTurn) {
  auto client = harness_.peer().create_client<srv::ChangeState>("/arm/change_state");
  std::vector<bool> answers;
  for (const std::uint8_t id : {std::uint8_t{1}, std::uint8_t{3}, std::uint8_t{1}}) {
    srv::ChangeState::Request request;
    request.transition.id = id;
    client.call(request, [&answers](const Client<srv::ChangeState>::Result& result) {
      answers.push_back(result && result->success);
    });
  }
  ASSERT_TRUE(harness_.spin_until([&answers] { return answers.size() == 3; }));
  EXPECT_EQ(answers, (std::vector<bool>{true, true, false}));
  EXPECT_EQ(component_.state(), LifecycleState::kActive);
}

TEST_F(LifecycleServicesTest, ListsStatesAndTransitions) {
  const auto states = harness_.call<srv::GetAvailableStates>("/arm/get_available_states", {});
  ASSERT_TRUE(states);
  EXPECT_EQ(states->available_states.size(), lifecycle_states().size());

  ASSERT_TRUE(change(1));
  const auto possible =
      harness_.call<srv::GetAvailableTransitions>("/arm/get_available_transitions", {});
  ASSERT_TRUE(possible);
  std::vector<std::string> labels;
  for (const auto& description : possible->available_transitions) {
    EXPECT_EQ(description.start_state.label, "inactive");
    labels.push_back(description.transition.label);
  }
  EXPECT_EQ(labels, (std::vector<std::string>{"cleanup", "activate", "shutdown"}));

  const auto graph = harness_.call<srv::GetAvailableTransitions>("/arm/get_transition_graph", {});
  ASSERT_TRUE(graph);
  ASSERT_EQ(graph->available_transitions.size(), lifecycle_edges().size());
  EXPECT_EQ(graph->available_transitions.back().goal_state.label, "finalized");
}

}  // namespace
}  // namespace pipescout
