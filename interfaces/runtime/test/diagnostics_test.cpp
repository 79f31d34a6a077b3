// SPDX-License-Identifier: Apache-2.0
#include "pipescout/runtime/diagnostics.hpp"

#include <gtest/gtest.h>

#include <diagnostic_msgs/msg/diagnostic_array.hpp>
#include <map>
#include <memory>
#include <std_msgs/msg/header.hpp>
#include <std_srvs/srv/set_bool.hpp>
#include <string>
#include <thread>
#include <vector>

#include "diagnostics_publisher.hpp"
#include "pipescout/testing/component_harness.hpp"
#include "pipescout/testing/fake_transport.hpp"

namespace pipescout {
namespace {

using testing::ComponentHarness;
using Message = std_msgs::msg::Header;
using std_srvs::srv::SetBool;

TEST(Diagnostics, IsFineAtFirst) {
  Diagnostics diagnostics;
  const auto snapshot = diagnostics.take();
  EXPECT_EQ(snapshot.level, DiagnosticLevel::kOk);
  EXPECT_TRUE(snapshot.message.empty());
  EXPECT_TRUE(snapshot.values.empty());
}

TEST(Diagnostics, WarnsWhileACounterGrowsAndNamesIt) {
  Diagnostics diagnostics;
  diagnostics.count("readings.not_a_number");
  diagnostics.count("readings.not_a_number", 2);
  auto snapshot = diagnostics.take();
  EXPECT_EQ(snapshot.level, DiagnosticLevel::kWarn);
  EXPECT_EQ(snapshot.message, "readings.not_a_number +3");
  EXPECT_EQ(snapshot.values.at("readings.not_a_number"), "3");

  snapshot = diagnostics.take();
  EXPECT_EQ(snapshot.level, DiagnosticLevel::kOk);
  EXPECT_TRUE(snapshot.message.empty());
  EXPECT_EQ(snapshot.values.at("readings.not_a_number"), "3");
  EXPECT_EQ(diagnostics.counter("readings.not_a_number"), 3U);
  EXPECT_EQ(diagnostics.counter("never.counted"), 0U);
}

TEST(Diagnostics, CountingNothingChangesNothing) {
  Diagnostics diagnostics;
  diagnostics.count("readings.stale", 0);
  const auto snapshot = diagnostics.take();
  EXPECT_EQ(snapshot.level, DiagnosticLevel::kOk);
  EXPECT_TRUE(snapshot.values.empty());
}

TEST(Diagnostics, AStatusHoldsAndCountersDoNotLowerIt) {
  Diagnostics diagnostics;
  diagnostics.set_status(DiagnosticLevel::kError, "no odometer answers");
  diagnostics.count("readings.empty");
  auto snapshot = diagnostics.take();
  EXPECT_EQ(snapshot.level, DiagnosticLevel::kError);
  EXPECT_EQ(snapshot.message, "no odometer answers; readings.empty +1");
  snapshot = diagnostics.take();
  EXPECT_EQ(snapshot.level, DiagnosticLevel::kError);
  EXPECT_EQ(snapshot.message, "no odometer answers");
}

TEST(Diagnostics, TellsOfAChangeOfLevelOnceForEachSnapshot) {
  Diagnostics diagnostics;
  int told = 0;
  diagnostics.on_level_changed([&told] { ++told; });
  diagnostics.set_status(DiagnosticLevel::kOk, "same level");
  EXPECT_EQ(told, 0);
  diagnostics.count("faults");
  diagnostics.count("faults");
  diagnostics.set_status(DiagnosticLevel::kError, "worse");
  EXPECT_EQ(told, 1);
  (void)diagnostics.take();
  diagnostics.count("faults");
  EXPECT_EQ(told, 1);
  diagnostics.set_status(DiagnosticLevel::kOk, "well again");
  EXPECT_EQ(told, 2);
  diagnostics.on_level_changed({});
  (void)diagnostics.take();
  diagnostics.set_status(DiagnosticLevel::kStale, "nobody listens");
  EXPECT_EQ(told, 2);
}

TEST(Diagnostics, CountsFromManyThreads) {
  Diagnostics diagnostics;
  std::vector<std::thread> threads;
  for (int i = 0; i < 4; ++i) {
    threads.emplace_back([&diagnostics] {
      for (int n = 0; n < 1000; ++n) {
        diagnostics.count("faults");
        if (n % 100 == 0) {
          (void)diagnostics.take();
        }
      }
    });
  }
  for (auto& thread : threads) {
    thread.join();
  }
  EXPECT_EQ(diagnostics.counter("faults"), 4000U);
}

class Listener : public Component {
 public:
  explicit Listener(ComponentOptions options) : Component(std::move(options)) {}

 private:
  CallbackReturn on_configure() override {
    subscription_ = create_subscription<Message>("input", QoS::reliable(2), [](const Message&) {});
    publisher_ = create_publisher<Message>("output", QoS::reliable(2));
    return CallbackReturn::kSuccess;
  }
  CallbackReturn on_activate() override {
    publisher_.publish(Message{});
    return CallbackReturn::kSuccess;
  }

  Subscription<Message> subscription_;
  Publisher<Message> publisher_;
};

TEST(DiagnosticsPublisher, SaysWhatTheTransportCannotDo) {
  testing::FakeNetwork network;
  Executor executor;
  const auto context = Context::create(network.create_transport());
  std::map<std::string, diagnostic_msgs::msg::DiagnosticStatus> statuses;
  const auto subscription = context->create_subscription(
      {.topic = {"rt/diagnostics", &message_type<diagnostic_msgs::msg::DiagnosticArray>()},
       .callback = [&](const std::shared_ptr<const void>& message, const MessageInfo&) {
         const auto& array =
             *static_cast<const diagnostic_msgs::msg::DiagnosticArray*>(message.get());
         for (const auto& status : array.status) {
           statuses[status.name] = status;
         }
       }});
  Listener component({.context = context,
                      .executor = &executor,
                      .name = {"/", "listener"},
                      .standard_interfaces = false});
  DiagnosticsPublisher publisher(component);
  publisher.publish_now();
  EXPECT_FALSE(statuses.contains("listener: transport"));
  network.warn("no room in /dev/shm");
  network.warn("no second port");
  publisher.publish_now();
  const auto& status = statuses["listener: transport"];
  EXPECT_EQ(status.level, diagnostic_msgs::msg::DiagnosticStatus::WARN);
  EXPECT_EQ(status.message, "no room in /dev/shm; no second port");
  EXPECT_EQ(statuses["listener: status"].level, diagnostic_msgs::msg::DiagnosticStatus::OK);
}

TEST(DiagnosticsPublisher, SaysOnceASecondHowTheComponentIs) {
  ComponentHarness harness({.ns = "/robot_1", .simulated_time = true});
  auto& component = harness.make<Listener>({.name = "listener"});
  ASSERT_TRUE(harness.bring_up(component).success);
  component.diagnostics().set_value("temperature", "21.5");
  const auto status = harness.next_diagnostics(component);
  EXPECT_EQ(status.name, "robot_1/listener: status");
  EXPECT_EQ(status.hardware_id, "none");
  EXPECT_EQ(status.level, diagnostic_msgs::msg::DiagnosticStatus::OK);
  EXPECT_EQ(ComponentHarness::value(status, "lifecycle_state"), "active");
  EXPECT_EQ(ComponentHarness::value(status, "temperature"), "21.5");
  const std::size_t before = harness.diagnostics(component).size();
  harness.advance(std::chrono::seconds(1));
  EXPECT_EQ(harness.diagnostics(component).size(), before + 1);
}

TEST(DiagnosticsPublisher, PublishesAChangeOfLevelAtOnce) {
  ComponentHarness harness({.simulated_time = true});
  auto& component = harness.make<Listener>();
  ASSERT_TRUE(harness.bring_up(component).success);
  const std::size_t before = harness.diagnostics(component).size();
  component.diagnostics().set_status(DiagnosticLevel::kError, "broken");
  const auto statuses = harness.diagnostics(component);
  ASSERT_EQ(statuses.size(), before + 1);
  EXPECT_EQ(statuses.back().level, diagnostic_msgs::msg::DiagnosticStatus::ERROR);
  EXPECT_EQ(statuses.back().message, "broken");
}

TEST(DiagnosticsPublisher, WarnsOfMessagesThatTheQueueDropped) {
  ComponentHarness harness({.simulated_time = true});
  auto& component = harness.make<Listener>();
  ASSERT_TRUE(harness.bring_up(component).success);
  for (int i = 0; i < 5; ++i) {
    harness.publish("input", Message{});
  }
  const auto status = harness.next_diagnostics(component);
  EXPECT_EQ(status.level, diagnostic_msgs::msg::DiagnosticStatus::WARN);
  EXPECT_EQ(status.message, "subscription /input: dropped_queue_full +3");
  EXPECT_EQ(ComponentHarness::value(status, "subscription /input: dropped_queue_full"), "3");

  const auto later = harness.next_diagnostics(component);
  EXPECT_EQ(later.level, diagnostic_msgs::msg::DiagnosticStatus::OK);
  EXPECT_EQ(ComponentHarness::value(later, "subscription /input: dropped_queue_full"), "3");
}

TEST(DiagnosticsPublisher, ShowsWhatAnInactiveComponentDropsWithoutAWarning) {
  ComponentHarness harness({.simulated_time = true});
  auto& component = harness.make<Listener>();
  ASSERT_TRUE(harness.configure(component).success);
  for (int i = 0; i < 3; ++i) {
    harness.publish("input", Message{});
  }
  ASSERT_TRUE(harness.activate(component).success);
  const auto status = harness.next_diagnostics(component);
  EXPECT_EQ(status.level, diagnostic_msgs::msg::DiagnosticStatus::OK);
  EXPECT_EQ(ComponentHarness::value(status, "subscription /input: dropped_inactive"), "1");
  EXPECT_EQ(ComponentHarness::value(status, "publisher /output: suppressed"), "1");
}

/// Serves with a short queue, and calls a server that there is not.
class Serving : public Component {
 public:
  explicit Serving(ComponentOptions options) : Component(std::move(options)) {}

  void ask() {
    client_.call(
        {}, [](const Client<SetBool>::Result&) {}, Duration::zero());
  }

 private:
  CallbackReturn on_configure() override {
    service_ = create_service<SetBool>("switch", [](const SetBool::Request&, SetBool::Response&) {},
                                       {.qos = QoS::reliable(2)});
    client_ = create_client<SetBool>("absent");
    return CallbackReturn::kSuccess;
  }

  Service<SetBool> service_;
  Client<SetBool> client_;
};

TEST(DiagnosticsPublisher, WarnsOfWhatServicesAndClientsLose) {
  ComponentHarness harness({.simulated_time = true});
  auto& component = harness.make<Serving>();
  ASSERT_TRUE(harness.bring_up(component).success);
  EXPECT_EQ(component.clients().size(), 1U);
  component.ask();
  auto caller = harness.peer().create_client<SetBool>("switch");
  for (int i = 0; i < 5; ++i) {
    caller.call({}, [](const Client<SetBool>::Result&) {});
  }
  harness.spin();
  const auto status = harness.next_diagnostics(component);
  EXPECT_EQ(status.level, diagnostic_msgs::msg::DiagnosticStatus::WARN);
  EXPECT_EQ(status.message,
            "client /absent: without_server +1, service /switch: "
            "dropped_queue_full +3");
  EXPECT_EQ(ComponentHarness::value(status, "client /absent: without_server"), "1");
  EXPECT_EQ(ComponentHarness::value(status, "service /switch: dropped_queue_full"), "3");

  component.ask();
  const auto later = harness.next_diagnostics(component);
  EXPECT_EQ(later.message, "client /absent: without_server +1");
  EXPECT_EQ(ComponentHarness::value(later, "client /absent: without_server"), "2");
}

TEST(DiagnosticsPublisher, WarnsOfAnIncompatibleQos) {
  ComponentHarness harness({.simulated_time = true});
  auto& component = harness.make<Listener>();
  ASSERT_TRUE(harness.bring_up(component).success);
  harness.publish("input", Message{}, QoS::sensor_data());
  const auto status = harness.next_diagnostics(component);
  EXPECT_EQ(status.level, diagnostic_msgs::msg::DiagnosticStatus::WARN);
  EXPECT_EQ(ComponentHarness::value(status, "subscription /input: incompatible_qos"), "1");
}

}  // namespace
}  // namespace pipescout
