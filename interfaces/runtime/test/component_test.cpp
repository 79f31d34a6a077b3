// SPDX-License-Identifier: Apache-2.0
#include "pipescout/runtime/component.hpp"

#include <gtest/gtest.h>

#include <atomic>
#include <chrono>
#include <functional>
#include <future>
#include <latch>
#include <memory>
#include <std_msgs/msg/header.hpp>
#include <std_srvs/srv/set_bool.hpp>
#include <stdexcept>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "pipescout/testing/component_harness.hpp"

namespace pipescout {
namespace {

/// A callback that is being run until it is let go.
class Held {
 public:
  [[nodiscard]] std::function<void()> callback() {
    return [this] {
      entered_.set_value();
      released_.wait();
      left_ = true;
    };
  }
  /// Returns once the callback is running.
  void wait() { entered_.get_future().wait(); }
  void release() { release_.set_value(); }
  [[nodiscard]] bool left() const { return left_; }

 private:
  std::promise<void> entered_;
  std::promise<void> release_;
  std::shared_future<void> released_ = release_.get_future().share();
  std::atomic<bool> left_ = false;
};

/// Has a second group, and calls the test from its lifecycle callbacks.
class Observed : public Component {
 public:
  using Component::Component;

  const std::shared_ptr<CallbackGroup> group =
      create_callback_group(CallbackGroupType::kMutuallyExclusive);
  std::function<void(const std::string&)> on_call = [](const std::string&) {};

 private:
  CallbackReturn called(const char* name) {
    on_call(name);
    return CallbackReturn::kSuccess;
  }
  CallbackReturn on_configure() override { return called("configure"); }
  CallbackReturn on_activate() override { return called("activate"); }
  CallbackReturn on_deactivate() override { return called("deactivate"); }
  CallbackReturn on_cleanup() override { return called("cleanup"); }
  CallbackReturn on_shutdown() override { return called("shutdown"); }
  CallbackReturn on_error() override { return called("error"); }
};

class ComponentCallbacks : public ::testing::Test {
 protected:
  ComponentCallbacks() : spinning_([this] { executor_.spin(); }) {}
  ~ComponentCallbacks() override {
    component_.reset();
    other_.reset();
    executor_.stop();
    spinning_.join();
  }

  ComponentOptions options(const std::string& name) {
    ComponentOptions options;
    options.context = context_;
    options.executor = &executor_;
    options.name = {"/", name};
    return options;
  }

  static std::future<TransitionResult> request(Component& component,
                                               LifecycleTransition transition) {
    const auto promise = std::make_shared<std::promise<TransitionResult>>();
    component.request_transition(
        transition, [promise](const TransitionResult& result) { promise->set_value(result); });
    return promise->get_future();
  }
  static void bring_up(Component& component) {
    ASSERT_TRUE(request(component, LifecycleTransition::kConfigure).get().success);
    ASSERT_TRUE(request(component, LifecycleTransition::kActivate).get().success);
  }
  /// Runs everything that the default group has to do so far.
  static void pass_through_default_group(Component& component) {
    std::promise<void> passed;
    component.default_group()->post([&passed] { passed.set_value(); });
    passed.get_future().wait();
  }

  const std::shared_ptr<Context> context_ = Context::create_in_process();
  Executor executor_{3};
  std::thread spinning_;
  ComponentPtr<Observed> component_ = make_component<Observed>(options("observed"));
  ComponentPtr<Observed> other_ = make_component<Observed>(options("other"));
};

TEST_F(ComponentCallbacks, ATransitionWaitsForTheCallbacksOfAllGroups) {
  bring_up(*component_);
  std::atomic<int> called = 0;
  for (const auto transition : {LifecycleTransition::kDeactivate, LifecycleTransition::kCleanup,
                                LifecycleTransition::kConfigure, LifecycleTransition::kActivate,
                                LifecycleTransition::kActiveShutdown}) {
    SCOPED_TRACE(to_string(transition));
    called = 0;
    Held held;
    component_->on_call = [&](const std::string&) {
      EXPECT_TRUE(held.left());
      ++called;
    };
    component_->group->post(held.callback());
    held.wait();
    auto result = request(*component_, transition);
    // The transition has begun, and its callback had its chance.
    pass_through_default_group(*component_);
    EXPECT_EQ(called, 0);
    EXPECT_GE(static_cast<int>(component_->state()),
              static_cast<int>(LifecycleState::kConfiguring));
    held.release();
    EXPECT_TRUE(result.get().success);
    EXPECT_EQ(called, 1);
  }
}

TEST_F(ComponentCallbacks, ErrorProcessingWaitsForTheCallbacksOfAllGroups) {
  bring_up(*component_);
  Held held;
  std::promise<void> processed;
  component_->on_call = [&](const std::string& name) {
    EXPECT_EQ(name, "error");
    EXPECT_TRUE(held.left());
    processed.set_value();
  };
  component_->group->post(held.callback());
  held.wait();
  component_->default_group()->post([] { throw std::runtime_error("the motor does not answer"); });
  pass_through_default_group(*component_);
  pass_through_default_group(*component_);
  EXPECT_EQ(component_->state(), LifecycleState::kErrorProcessing);
  held.release();
  processed.get_future().wait();
}

TEST_F(ComponentCallbacks, NoCallbackBeginsInATransition) {
  bring_up(*component_);
  std::latch both_ran(2);
  std::atomic<bool> over = false;
  std::shared_ptr<CallbackGroup> made;
  component_->on_call = [&](const std::string&) {
    made = component_->create_callback_group(CallbackGroupType::kReentrant);
    for (const auto& group : {made, component_->group}) {
      group->post([&] {
        EXPECT_TRUE(over);
        both_ran.count_down();
      });
    }
    // Two more threads have nothing else to do meanwhile.
    for (int i = 0; i < 10; ++i) {
      std::promise<void> ran;
      other_->group->post([&ran] { ran.set_value(); });
      ran.get_future().wait();
    }
    over = true;
  };
  EXPECT_TRUE(request(*component_, LifecycleTransition::kDeactivate).get().success);
  both_ran.wait();
}

TEST_F(ComponentCallbacks, ATransitionMayBeAskedForFromACallbackOfAnyGroup) {
  for (const auto& group : {component_->default_group(), component_->group}) {
    bring_up(*component_);
    std::promise<TransitionResult> down;
    group->post([&] {
      component_->request_transition(LifecycleTransition::kDeactivate);
      component_->request_transition(
          LifecycleTransition::kCleanup,
          [&down](const TransitionResult& result) { down.set_value(result); });
    });
    const TransitionResult result = down.get_future().get();
    EXPECT_TRUE(result.success) << result.message;
    EXPECT_EQ(result.state, LifecycleState::kUnconfigured);
  }
}

TEST_F(ComponentCallbacks, ACallbackThatDoesNotReturnHoldsUpItsOwnComponentOnly) {
  bring_up(*component_);
  bring_up(*other_);
  Held held;
  component_->group->post(held.callback());
  held.wait();
  auto hanging = request(*component_, LifecycleTransition::kDeactivate);
  // One thread hangs in the callback; none of the others may wait for it.
  std::promise<void> stopped;
  component_->stop_callbacks([&stopped] { stopped.set_value(); });
  for (const auto transition : {LifecycleTransition::kDeactivate, LifecycleTransition::kCleanup,
                                LifecycleTransition::kUnconfiguredShutdown}) {
    EXPECT_TRUE(request(*other_, transition).get().success);
  }
  auto has_stopped = stopped.get_future();
  EXPECT_EQ(has_stopped.wait_for(std::chrono::seconds(0)), std::future_status::timeout);
  held.release();
  has_stopped.wait();
  EXPECT_EQ(hanging.wait_for(std::chrono::seconds(0)), std::future_status::timeout);
}

TEST_F(ComponentCallbacks, WhatATransitionsAnswerThrowsDoesNotKeepTheNextOne) {
  bring_up(*component_);
  std::promise<TransitionResult> down;
  component_->default_group()->post([&] {
    component_->request_transition(LifecycleTransition::kDeactivate, [](const TransitionResult&) {
      throw std::runtime_error("nobody wants to know");
    });
    component_->request_transition(
        LifecycleTransition::kCleanup,
        [&down](const TransitionResult& result) { down.set_value(result); });
  });
  EXPECT_TRUE(down.get_future().get().success);
}

constexpr Topic<std_msgs::msg::Header> kStates{.name = "states", .qos = QoS::reliable(5)};
constexpr Topic<std_msgs::msg::Header> kCommands{
    .name = "commands", .qos = QoS::reliable(5), .while_inactive = WhileInactive::kDrop};

/// Counts what it hears on two topics.
class Hearing : public Component {
 public:
  using Component::Component;

  int states = 0;
  int commands = 0;
  int kept_commands = 0;

 private:
  using Message = std_msgs::msg::Header;
  CallbackReturn on_configure() override {
    subscriptions_ = {create_subscription(kStates, [this](const Message&) { ++states; }),
                      create_subscription(kCommands, [this](const Message&) { ++commands; }),
                      create_subscription(kCommands, [this](const Message&) { ++kept_commands; },
                                          {.while_inactive = WhileInactive::kKeep})};
    return CallbackReturn::kSuccess;
  }

  std::vector<Subscription<Message>> subscriptions_;
};

TEST(InactiveComponent, KeepsStatesAndDropsCommandsAsTheTopicSays) {
  testing::ComponentHarness harness;
  auto& hearing = harness.make<Hearing>();
  ASSERT_TRUE(harness.configure(hearing).success);
  harness.publish(kStates, std_msgs::msg::Header());
  harness.publish(kCommands, std_msgs::msg::Header());
  ASSERT_TRUE(harness.activate(hearing).success);
  EXPECT_EQ(hearing.states, 1);
  EXPECT_EQ(hearing.commands, 0);
  EXPECT_EQ(hearing.kept_commands, 1);
  harness.publish(kCommands, std_msgs::msg::Header());
  harness.spin();
  EXPECT_EQ(hearing.commands, 1);
}

/// Answers with the state that it is in; told to, it fails after that.
class Serving : public Component {
 public:
  explicit Serving(ComponentOptions options)
      : Component(std::move(options)),
        service_(create_service<std_srvs::srv::SetBool>(
            "ask", [this](const std_srvs::srv::SetBool::Request& request,
                          std_srvs::srv::SetBool::Response& response) {
              response.message = to_string(state());
              ++requests;
              if (request.data) {
                throw std::runtime_error("told to");
              }
            })) {}

  int requests = 0;
  int requests_before_the_error = -1;

 private:
  CallbackReturn on_error() override {
    requests_before_the_error = requests;
    return CallbackReturn::kSuccess;
  }

  Service<std_srvs::srv::SetBool> service_;
};

TEST(ServiceOfAComponent, AnswersInEveryState) {
  testing::ComponentHarness harness;
  auto& serving = harness.make<Serving>();
  const auto ask = [&harness] {
    const auto answer = harness.call<std_srvs::srv::SetBool>("ask", {});
    return answer ? answer->message : to_string(answer.error());
  };
  EXPECT_EQ(ask(), "unconfigured");
  ASSERT_TRUE(harness.configure(serving).success);
  EXPECT_EQ(ask(), "inactive");
  ASSERT_TRUE(harness.activate(serving).success);
  EXPECT_EQ(ask(), "active");
  ASSERT_TRUE(harness.deactivate(serving).success);
  EXPECT_EQ(ask(), "inactive");
  ASSERT_TRUE(harness.shutdown(serving).success);
  EXPECT_EQ(ask(), "finalized");
}

TEST(ServiceOfAComponent, IsNotAskedBetweenAnExceptionAndTheErrorState) {
  testing::ComponentHarness harness;
  auto& serving = harness.make<Serving>();
  ASSERT_TRUE(harness.bring_up(serving).success);
  auto client = harness.peer().create_client<std_srvs::srv::SetBool>("ask");
  int answers = 0;
  std::string last;
  for (const bool fails : {true, false}) {
    std_srvs::srv::SetBool::Request request;
    request.data = fails;
    client.call(request, [&](const Client<std_srvs::srv::SetBool>::Result& answer) {
      ++answers;
      last = answer ? answer->message : to_string(answer.error());
    });
  }
  ASSERT_TRUE(harness.spin_until([&] { return serving.requests == 2; }));
  EXPECT_EQ(serving.requests_before_the_error, 1);
  harness.spin();
  EXPECT_EQ(answers, 1);
  EXPECT_EQ(last, "unconfigured");
}

/// Uses a member in its callbacks, and its destructor gives them every chance.
class Careless : public Component {
 public:
  explicit Careless(ComponentOptions options) : Component(std::move(options)) {}
  Careless(const Careless&) = delete;
  Careless& operator=(const Careless&) = delete;
  ~Careless() override {
    is_alive_ = false;
    executor().spin_ready();
  }
  void work() {
    default_group()->post([this] { EXPECT_TRUE(is_alive_); });
  }

 private:
  bool is_alive_ = true;
};

TEST(ComponentPtr, NoCallbackMeetsAHalfDestroyedComponent) {
  Executor executor;
  ComponentOptions options;
  options.context = Context::create_in_process();
  options.executor = &executor;
  options.name = {"/", "careless"};
  auto owned = make_component<Careless>(options);
  owned->work();
  owned.reset();
  std::shared_ptr<Component> shared = make_component<Careless>(options);
  static_cast<Careless&>(*shared).work();
  shared.reset();
  EXPECT_EQ(executor.spin_ready(), 0U);
}

}  // namespace
}  // namespace pipescout
