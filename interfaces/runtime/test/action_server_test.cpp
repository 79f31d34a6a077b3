// SPDX-License-Identifier: Apache-2.0
#include "pipescout/runtime/action_server.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <optional>
#include <rosgraph_msgs/msg/clock.hpp>
#include <stdexcept>
#include <string>
#include <vector>

#include "fibonacci_action.hpp"
#include "pipescout/runtime/component.hpp"
#include "pipescout/runtime/conversions.hpp"
#include "pipescout/testing/component_harness.hpp"

namespace pipescout {
namespace {

using testing::ComponentHarness;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using SendGoal = Fibonacci::Impl::SendGoalService;
using GetResult = Fibonacci::Impl::GetResultService;

GoalId id_of(std::uint8_t number) {
  GoalId id;
  id.bytes[0] = number;
  return id;
}

/// A server, and a peer that speaks to it by its services and topics, as any node of ROS 2 could.
class ActionServerOnTheWire : public ::testing::Test {
 protected:
  using Cancel = CancelGoal::Response;

  std::string part(const char* name) { return action_part_name("/robot/fibonacci", name); }

  std::shared_ptr<const SendGoal::Response> send(std::uint8_t id, std::int32_t numbers = 1) {
    SendGoal::Request request;
    request.goal_id = to_message(id_of(id));
    request.goal.order = numbers;
    return call<SendGoal>("send_goal", std::move(request));
  }
  std::shared_ptr<const Cancel> cancel(const GoalId& id, Time not_after = {}) {
    CancelGoal::Request request;
    request.goal_info.goal_id = to_message(id);
    request.goal_info.stamp = to_message(not_after);
    return call<CancelGoal>("cancel_goal", std::move(request));
  }
  /// Null while the result is not there.
  std::shared_ptr<const GetResult::Response> result(std::uint8_t id) {
    GetResult::Request request;
    request.goal_id = to_message(id_of(id));
    return call<GetResult>("get_result", std::move(request));
  }
  template <class S>
  std::shared_ptr<const typename S::Response> call(const char* name, typename S::Request request) {
    auto client = process_.node.create_client<S>(part(name));
    const auto answer = std::make_shared<std::shared_ptr<const typename S::Response>>();
    client.call(std::move(request), [answer](const typename Client<S>::Result& told) {
      if (told) {
        *answer = told.shared();
      }
    });
    process_.executor.spin_ready();
    waiting_.push_back(client.untyped());
    return *answer;
  }
  /// What the status topic says now: "1 executing".
  std::vector<std::string> statuses() {
    process_.executor.spin_ready();
    std::vector<std::string> texts;
    for (const auto& entry : status_.status_list) {
      texts.push_back(std::to_string(entry.goal_info.goal_id.uuid[0]) + " " +
                      std::string(to_string(static_cast<GoalStatus>(entry.status))));
    }
    return texts;
  }
  static std::vector<int> ids(const Cancel& response) {
    std::vector<int> result;
    for (const auto& info : response.goals_canceling) {
      result.push_back(info.goal_id.uuid[0]);
    }
    return result;
  }

  ActionProcess process_{"server"};
  action_msgs::msg::GoalStatusArray status_;
  std::size_t status_messages_ = 0;
  Subscription<action_msgs::msg::GoalStatusArray> subscription_ =
      process_.node.create_subscription<action_msgs::msg::GoalStatusArray>(
          part("status"), QoS::latched(1), [this](const action_msgs::msg::GoalStatusArray& told) {
            status_ = told;
            ++status_messages_;
          });
  std::vector<std::shared_ptr<UntypedClient>> waiting_;
};

TEST_F(ActionServerOnTheWire, AGoalIsAcceptedExecutedAndItsResultIsTold) {
  FibonacciServer server(process_.node);
  const auto response = send(1, 5);
  ASSERT_TRUE(response);
  EXPECT_TRUE(response->accepted);
  EXPECT_NEAR(to_seconds(process_.node.now() - from_message(response->stamp)), 0.0, 60.0);
  EXPECT_THAT(server.events, ElementsAre("decide 5", "accepted 5"));
  EXPECT_THAT(statuses(), ElementsAre("1 executing"));
  EXPECT_EQ(status_.status_list.at(0).goal_info.stamp, response->stamp);
  EXPECT_EQ(server.goals.at(0).id(), id_of(1));
  EXPECT_EQ(to_message(server.goals.at(0).accepted_at()), response->stamp);

  EXPECT_TRUE(server.goals.at(0).succeed(numbers({0, 1, 1})));
  EXPECT_THAT(statuses(), ElementsAre("1 succeeded"));
  const auto told = result(1);
  ASSERT_TRUE(told);
  EXPECT_EQ(told->status, 4);
  EXPECT_THAT(told->result.sequence, ElementsAre(0, 1, 1));
  EXPECT_TRUE(result(1)) << "results are kept";
}

TEST_F(ActionServerOnTheWire, AResultThatIsAskedForBeforeTheEndIsAnsweredAtTheEnd) {
  const FibonacciServer server(process_.node);
  send(1);
  auto client = process_.node.create_client<GetResult>(part("get_result"));
  std::vector<int> answers;
  for (int i = 0; i < 2; ++i) {
    GetResult::Request request;
    request.goal_id = to_message(id_of(1));
    client.call(std::move(request), [&](const Client<GetResult>::Result& told) {
      answers.push_back(told ? told->status : -1);
    });
  }
  process_.executor.spin_ready();
  EXPECT_THAT(answers, IsEmpty());
  server.goals.at(0).abort();
  process_.executor.spin_ready();
  EXPECT_THAT(answers, ElementsAre(6, 6));
}

TEST_F(ActionServerOnTheWire, TheResultOfAnUnknownGoalIsUnknown) {
  const FibonacciServer server(process_.node);
  const auto told = result(9);
  ASSERT_TRUE(told);
  EXPECT_EQ(told->status, 0);
  EXPECT_EQ(told->result, Fibonacci::Result{});
}

TEST_F(ActionServerOnTheWire, RejectsWhatTheHandlerRejectsAndEveryIdentifierTwice) {
  FibonacciServer server(process_.node);
  server.decision = GoalDecision::kReject;
  const auto rejected = send(1);
  EXPECT_FALSE(rejected->accepted);
  EXPECT_EQ(rejected->stamp, builtin_interfaces::msg::Time{});
  EXPECT_EQ(result(1)->status, 0);
  EXPECT_EQ(status_messages_, 0U);
  server.decision = GoalDecision::kAccept;
  EXPECT_TRUE(send(1)->accepted) << "a goal that was rejected may be sent again";
  EXPECT_FALSE(send(1)->accepted);
  server.goals.at(0).succeed();
  EXPECT_FALSE(send(1)->accepted) << "also while its result is kept";
  EXPECT_FALSE(send(0)->accepted);
  EXPECT_EQ(server.server.statistics().accepted, 1U);
  EXPECT_EQ(server.server.statistics().rejected, 4U);
}

TEST_F(ActionServerOnTheWire, SaysInItsLogWhyItRejects) {
  FibonacciServer server(process_.node);
  std::vector<std::string> lines;
  Logger logger = process_.node.logger();  // a copy shares its state
  logger.set_sink([&](LogSeverity, const std::string& text, const Logger::Location&) {
    lines.push_back(text);
  });
  server.rejection = "a sequence of nothing";
  EXPECT_FALSE(send(1)->accepted);
  server.rejection.reset();
  server.decision = GoalDecision::kReject;
  EXPECT_FALSE(send(1)->accepted);
  logger.set_sink({});
  const std::string goal = "action '/robot/fibonacci': goal " + to_string(id_of(1)) + " rejected: ";
  EXPECT_THAT(lines,
              ElementsAre(goal + "a sequence of nothing", goal + "the server gives no reason"));
  EXPECT_EQ(server.server.statistics().rejected, 2U);
}

TEST_F(ActionServerOnTheWire, ADeferredGoalWaitsToBeExecuted) {
  FibonacciServer server(process_.node);
  server.decision = GoalDecision::kDefer;
  send(1);
  EXPECT_THAT(statuses(), ElementsAre("1 accepted"));
  const auto goal = server.goals.at(0);
  EXPECT_THROW(goal.succeed(), std::logic_error);
  EXPECT_THROW(goal.canceled(), std::logic_error);
  EXPECT_TRUE(goal.execute());
  EXPECT_FALSE(goal.execute());
  EXPECT_THAT(statuses(), ElementsAre("1 executing"));
  EXPECT_THROW(goal.canceled(), std::logic_error);
  EXPECT_TRUE(goal.succeed());
}

TEST_F(ActionServerOnTheWire, AGoalEndsOnce) {
  const FibonacciServer server(process_.node);
  send(1);
  const auto goal = server.goals.at(0);
  EXPECT_TRUE(goal.succeed(numbers({1})));
  EXPECT_FALSE(goal.succeed(numbers({2})));
  EXPECT_FALSE(goal.abort());
  EXPECT_FALSE(goal.canceled());
  EXPECT_FALSE(goal.execute());
  EXPECT_FALSE(goal.publish_feedback({}));
  EXPECT_THAT(result(1)->result.sequence, ElementsAre(1));
  EXPECT_EQ(cancel(id_of(1))->return_code, Cancel::ERROR_GOAL_TERMINATED);
}

TEST_F(ActionServerOnTheWire, CancelsOneGoal) {
  const FibonacciServer server(process_.node);
  send(1, 1);
  send(2, 2);
  EXPECT_EQ(cancel(id_of(3))->return_code, Cancel::ERROR_UNKNOWN_GOAL_ID);
  const auto response = cancel(id_of(2));
  EXPECT_EQ(response->return_code, Cancel::ERROR_NONE);
  EXPECT_THAT(ids(*response), ElementsAre(2));
  EXPECT_EQ(response->goals_canceling[0].stamp, to_message(server.goals[1].accepted_at()));
  EXPECT_THAT(server.events, ElementsAre("decide 1", "accepted 1", "decide 2", "accepted 2",
                                         "cancel 2", "canceling 2"));
  EXPECT_THAT(statuses(), ElementsAre("1 executing", "2 canceling"));
  EXPECT_TRUE(server.goals[1].is_canceling());
  // Asked again it is canceling still, and the handler has nothing to decide.
  const auto again = cancel(id_of(2));
  EXPECT_EQ(again->return_code, Cancel::ERROR_NONE);
  EXPECT_THAT(ids(*again), ElementsAre(2));
  EXPECT_EQ(server.events.size(), 6U);
  EXPECT_TRUE(server.goals[1].canceled(numbers({7})));
  EXPECT_EQ(result(2)->status, 5);
  EXPECT_THAT(result(2)->result.sequence, ElementsAre(7));
  EXPECT_FALSE(server.goals[0].is_canceling());
}

TEST_F(ActionServerOnTheWire, ACancellationMayBeRejected) {
  FibonacciServer server(process_.node);
  server.cancel_decision = CancelDecision::kReject;
  EXPECT_EQ(cancel({})->return_code, Cancel::ERROR_NONE) << "there is nothing to cancel";
  send(1);
  const auto response = cancel(id_of(1));
  EXPECT_EQ(response->return_code, Cancel::ERROR_REJECTED);
  EXPECT_THAT(response->goals_canceling, IsEmpty());
  EXPECT_EQ(cancel({})->return_code, Cancel::ERROR_REJECTED);
  EXPECT_THAT(statuses(), ElementsAre("1 executing"));
}

TEST_F(ActionServerOnTheWire, CancelsAllGoalsThatHaveNotEnded) {
  FibonacciServer server(process_.node);
  send(1);
  server.decision = GoalDecision::kDefer;
  send(2);
  send(3);
  server.goals[0].succeed();
  EXPECT_THAT(ids(*cancel({})), ElementsAre(2, 3));
  EXPECT_THAT(statuses(), ElementsAre("1 succeeded", "2 canceling", "3 canceling"));
  EXPECT_FALSE(server.goals[1].execute());
  EXPECT_TRUE(server.goals[1].canceled());
}

TEST_F(ActionServerOnTheWire, AGoalThatEndsWhileItsCancellationIsDecidedIsNotCanceling) {
  ServerGoal<Fibonacci> kept;
  const auto server = process_.node.create_action_server<Fibonacci>(
      "fibonacci", {.accepted = [&](ServerGoal<Fibonacci> goal) { kept = std::move(goal); },
                    .cancel =
                        [&](const ServerGoal<Fibonacci>& goal) {
                          goal.succeed();
                          return CancelDecision::kAccept;
                        },
                    .canceling = [](const ServerGoal<Fibonacci>&) { FAIL(); }});
  send(1);
  const auto response = cancel(id_of(1));
  EXPECT_EQ(response->return_code, Cancel::ERROR_GOAL_TERMINATED);
  EXPECT_THAT(response->goals_canceling, IsEmpty());
  EXPECT_EQ(result(1)->status, 4);
}

TEST_F(ActionServerOnTheWire, AGoalWithoutHandlesIsAborted) {
  FibonacciServer server(process_.node);
  send(1);
  server.goals.clear();
  EXPECT_THAT(statuses(), ElementsAre("1 aborted"));
  EXPECT_EQ(result(1)->status, 6);
  EXPECT_EQ(server.server.statistics().dropped, 1U);
  EXPECT_EQ(server.server.statistics().aborted, 1U);
}

TEST_F(ActionServerOnTheWire, WhatAHandlerThrowsRejectsOrAborts) {
  std::string failing = "decide";
  const auto fail = [&](const char* handler) {
    if (failing == handler) {
      throw std::runtime_error(handler);
    }
  };
  std::vector<ServerGoal<Fibonacci>> goals;
  const auto server = process_.node.create_action_server<Fibonacci>(
      "fibonacci", {.decide =
                        [&](const GoalId&, const std::shared_ptr<const Fibonacci::Goal>&) {
                          fail("decide");
                          return GoalDecision::kAccept;
                        },
                    .accepted =
                        [&](ServerGoal<Fibonacci> goal) {
                          fail("accepted");
                          goals.push_back(std::move(goal));
                        },
                    .cancel =
                        [&](const ServerGoal<Fibonacci>&) {
                          fail("cancel");
                          return CancelDecision::kAccept;
                        },
                    .canceling = [&](const ServerGoal<Fibonacci>&) { fail("canceling"); }});
  // The exception leaves the executor of a plain node; the answer was given before.
  EXPECT_THROW(send(1), std::runtime_error);
  EXPECT_EQ(server.statistics().rejected, 1U);
  failing = "accepted";
  EXPECT_THROW(send(2), std::runtime_error);
  EXPECT_THAT(statuses(), ElementsAre("2 aborted"));
  failing = "";
  EXPECT_TRUE(send(3)->accepted);
  failing = "cancel";
  EXPECT_THROW(cancel(id_of(3)), std::runtime_error);
  EXPECT_EQ(goals.at(0).status(), GoalStatus::kExecuting);
  failing = "canceling";
  EXPECT_THROW(cancel(id_of(3)), std::runtime_error);
  EXPECT_EQ(goals.at(0).status(), GoalStatus::kCanceling);
}

TEST_F(ActionServerOnTheWire, GoalsAreBounded) {
  const FibonacciServer server(process_.node, {.max_goals = 2});
  EXPECT_TRUE(send(1)->accepted);
  EXPECT_TRUE(send(2)->accepted);
  EXPECT_FALSE(send(3)->accepted);
  server.goals[0].succeed();
  EXPECT_TRUE(send(4)->accepted);
}

TEST_F(ActionServerOnTheWire, ResultsAreBoundedAndThoseThatWereFetchedGoFirst) {
  const FibonacciServer server(process_.node, {.max_results = 2});
  for (std::uint8_t id = 1; id <= 3; ++id) {
    send(id);
    server.goals.back().succeed();
    if (id == 2) {
      EXPECT_EQ(result(2)->status, 4);
    }
  }
  EXPECT_EQ(result(1)->status, 4);
  EXPECT_EQ(result(2)->status, 0) << "it had been fetched";
  EXPECT_EQ(server.server.statistics().results_lost, 0U);
  send(4);
  server.goals.back().succeed();
  send(5);
  server.goals.back().succeed();
  EXPECT_EQ(server.server.statistics().results_lost, 1U);
}

TEST_F(ActionServerOnTheWire, ANewGoalPreemptsTheOldOne) {
  FibonacciServer server(process_.node, {.preempts = true});
  send(1, 1);
  send(2, 2);
  EXPECT_THAT(server.events,
              ElementsAre("decide 1", "accepted 1", "decide 2", "preempted 1", "accepted 2"));
  EXPECT_THAT(statuses(), ElementsAre("1 aborted", "2 executing"));
  EXPECT_EQ(result(1)->status, 6);
  server.decision = GoalDecision::kReject;
  send(3, 3);
  EXPECT_THAT(statuses(), ElementsAre("1 aborted", "2 executing")) << "a rejected one does not";
}

TEST_F(ActionServerOnTheWire, APreemptedGoalMayEndWithAResultOfItsOwn) {
  std::vector<ServerGoal<Fibonacci>> goals;
  const auto server = process_.node.create_action_server<Fibonacci>(
      "fibonacci",
      {.accepted = [&](ServerGoal<Fibonacci> goal) { goals.push_back(std::move(goal)); },
       .preempted =
           [](const ServerGoal<Fibonacci>& goal) {
             goal.abort(numbers({1, 2}));
           }},
      {.preempts = true});
  send(1);
  send(2);
  EXPECT_THAT(result(1)->result.sequence, ElementsAre(1, 2));
  EXPECT_EQ(server.statistics().aborted, 1U);
}

TEST_F(ActionServerOnTheWire, FeedbackNamesItsGoal) {
  std::vector<Fibonacci::Impl::FeedbackMessage> feedback;
  const auto subscription = process_.node.create_subscription<Fibonacci::Impl::FeedbackMessage>(
      part("feedback"), QoS::reliable(),
      [&](const Fibonacci::Impl::FeedbackMessage& message) { feedback.push_back(message); });
  const FibonacciServer server(process_.node);
  send(7);
  EXPECT_TRUE(server.goals[0].publish_feedback(so_far({3})));
  process_.executor.spin_ready();
  ASSERT_EQ(feedback.size(), 1U);
  EXPECT_EQ(feedback[0].goal_id.uuid[0], 7);
  EXPECT_THAT(feedback[0].feedback.sequence, ElementsAre(3));
}

TEST_F(ActionServerOnTheWire, AServerThatGoesAbortsItsGoalsAndTheirHandlesStayUsable) {
  std::optional<FibonacciServer> server(std::in_place, process_.node);
  send(1);
  const ServerGoal<Fibonacci> goal = server->goals.at(0);
  server.reset();
  EXPECT_THAT(statuses(), ElementsAre("1 aborted"));
  EXPECT_EQ(goal.status(), GoalStatus::kAborted);
  EXPECT_FALSE(goal.succeed());
  EXPECT_FALSE(goal.publish_feedback({}));
}

TEST_F(ActionServerOnTheWire, RefusesWhatMakesNoSense) {
  using Handlers = ActionHandlers<Fibonacci>;
  const Handlers complete{.accepted = [](const ServerGoal<Fibonacci>&) {}};
  auto& node = process_.node;
  const auto make = [&](Handlers handlers, const NodeActionServerOptions& options) {
    return node.create_action_server<Fibonacci>("other", std::move(handlers), options);
  };
  EXPECT_THROW(make({}, {}), std::invalid_argument);
  EXPECT_THROW(make(complete, {.max_goals = 0}), std::invalid_argument);
  EXPECT_THROW(make(complete, {.max_results = 0}), std::invalid_argument);
  EXPECT_THROW(make(complete, {.result_timeout = -Duration(1)}), std::invalid_argument);
  EXPECT_THROW(make(complete, {.feedback_depth = 0}), std::invalid_argument);
  EXPECT_THROW(static_cast<void>(node.create_action_server<Fibonacci>("a b", complete)),
               InvalidName);
  EXPECT_TRUE(make(complete, {}));
}

TEST_F(ActionServerOnTheWire, ItsNamesAreHiddenAndItsTypesThoseOfRos2) {
  const FibonacciServer server(process_.node);
  const auto services = process_.context->graph().services();
  EXPECT_THAT(services.at(part("send_goal")),
              ElementsAre("example_interfaces/action/Fibonacci_SendGoal"));
  EXPECT_THAT(services.at(part("get_result")),
              ElementsAre("example_interfaces/action/Fibonacci_GetResult"));
  EXPECT_THAT(services.at(part("cancel_goal")), ElementsAre("action_msgs/srv/CancelGoal"));
  const auto topics = process_.context->graph().topics();
  EXPECT_THAT(topics.at(part("feedback")),
              ElementsAre("example_interfaces/action/Fibonacci_FeedbackMessage"));
  EXPECT_THAT(topics.at(part("status")), ElementsAre("action_msgs/msg/GoalStatusArray"));
}

/// Results by the node's clock.
class ActionServerInSimulatedTime : public ActionServerOnTheWire {
 protected:
  ActionServerInSimulatedTime()
      : node_({.context = process_.context,
               .executor = &process_.executor,
               .name = {"/robot", "simulated"},
               .parameter_overrides = {{.name = "use_sim_time", .value = true}}}) {}

  void set_time(Duration since_start) {
    rosgraph_msgs::msg::Clock clock;
    clock.clock = to_message(Time(since_start));
    clock_.publish(std::move(clock));
    process_.executor.spin_ready();
  }

  Publisher<rosgraph_msgs::msg::Clock> clock_ =
      process_.node.create_publisher<rosgraph_msgs::msg::Clock>("/clock", QoS::reliable());
  Node node_;
};

TEST_F(ActionServerInSimulatedTime, ResultsAreKeptForFifteenMinutesAfterTheEnd) {
  using std::chrono::minutes;
  using std::chrono::seconds;
  const FibonacciServer server(node_);
  set_time(seconds(1));
  EXPECT_EQ(from_message(send(1)->stamp), Time(seconds(1)));
  set_time(minutes(20));
  server.goals[0].succeed();
  set_time(minutes(35));
  EXPECT_EQ(result(1)->status, 4);
  set_time(minutes(35) + seconds(1));
  EXPECT_EQ(result(1)->status, 0);
  EXPECT_EQ(cancel(id_of(1))->return_code, Cancel::ERROR_UNKNOWN_GOAL_ID);
  EXPECT_TRUE(send(1)->accepted) << "and its identifier is free";
  EXPECT_THAT(statuses(), ElementsAre("1 executing"));
}

TEST_F(ActionServerInSimulatedTime, CancelsTheGoalsThatWereAcceptedUpToATime) {
  using std::chrono::seconds;
  const FibonacciServer server(node_);
  for (std::uint8_t id = 1; id <= 4; ++id) {
    set_time(seconds(id));
    send(id);
  }
  EXPECT_THAT(ids(*cancel({}, Time(seconds(2)))), ElementsAre(1, 2));
  server.goals[0].canceled();
  server.goals[1].canceled();
  // With an identifier: that one too.
  EXPECT_THAT(ids(*cancel(id_of(4), Time(seconds(2)))), ElementsAre(4));
  EXPECT_THAT(ids(*cancel(id_of(9), Time(seconds(3)))), ElementsAre(3));
  const auto none = cancel({}, Time(seconds(1)));
  EXPECT_EQ(none->return_code, Cancel::ERROR_NONE);
  EXPECT_THAT(ids(*none), IsEmpty());
}

class Worker : public Component {
 public:
  explicit Worker(ComponentOptions options) : Component(std::move(options)) {}
  std::vector<ServerGoal<Fibonacci>> goals;
  bool fails = false;

 protected:
  CallbackReturn on_configure() override {
    server_ = create_action_server<Fibonacci>("fibonacci", {.accepted = [this](auto goal) {
                                                if (fails) {
                                                  throw std::runtime_error("the worker failed");
                                                }
                                                goals.push_back(std::move(goal));
                                              }});
    return CallbackReturn::kSuccess;
  }
  CallbackReturn on_cleanup() override {
    server_ = {};
    return CallbackReturn::kSuccess;
  }

 private:
  ActionServer<Fibonacci> server_;
};

TEST(ActionServerOfAComponent, WorksWhileTheComponentIsActive) {
  ComponentHarness harness({.ns = "/robot"});
  auto& worker = harness.make<Worker>({.name = "worker"});
  FibonacciClient client(harness.peer());
  ASSERT_TRUE(harness.configure(worker).success);
  client.send(1);
  harness.spin();
  EXPECT_THAT(client.told, ElementsAre("rejected")) << "an inactive server answers at once";
  client.told.clear();

  ASSERT_TRUE(harness.activate(worker).success);
  client.send(2);
  client.send(3);
  harness.spin();
  worker.goals.at(0).succeed(numbers({5}));
  harness.spin();
  EXPECT_THAT(client.told, ElementsAre("accepted", "accepted", "succeeded [5]"));
  client.told.clear();

  ASSERT_TRUE(harness.deactivate(worker).success);
  EXPECT_THAT(client.told, ElementsAre("aborted []"));
  EXPECT_FALSE(worker.goals.at(1).is_active());
  client.told.clear();
  client.send(4);
  harness.spin();
  EXPECT_THAT(client.told, ElementsAre("rejected"));
  ASSERT_TRUE(harness.cleanup(worker).success);
  EXPECT_FALSE(client.client.is_ready());
}

TEST(ActionServerOfAComponent, GoalsThatWereDroppedShowOnDiagnostics) {
  ComponentHarness harness({.ns = "/robot"});
  auto& worker = harness.make<Worker>({.name = "worker"});
  FibonacciClient client(harness.peer());
  ASSERT_TRUE(harness.bring_up(worker).success);
  client.send(1);
  harness.spin();
  worker.goals.clear();
  const auto status = harness.next_diagnostics(worker);
  EXPECT_EQ(ComponentHarness::value(status, "action /robot/fibonacci: dropped"), "1");
  EXPECT_THAT(status.message, HasSubstr("action /robot/fibonacci: dropped +1"));
}

TEST(ActionServerOfAComponent, AFailingComponentAbortsAllItsGoals) {
  ComponentHarness harness({.ns = "/robot"});
  auto& worker = harness.make<Worker>({.name = "worker"});
  FibonacciClient client(harness.peer());
  ASSERT_TRUE(harness.bring_up(worker).success);
  client.send(1);
  harness.spin();
  worker.fails = true;
  client.send(2);
  harness.spin();
  EXPECT_EQ(worker.state(), LifecycleState::kUnconfigured);
  // The second ended with its server before its client could ask for the result.
  EXPECT_THAT(client.told, ElementsAre("accepted", "accepted", "aborted []", "aborted"));
}

}  // namespace
}  // namespace pipescout
