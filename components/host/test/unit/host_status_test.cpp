// SPDX-License-Identifier: Apache-2.0
#include "run/host_status.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "pipescout/runtime/context.hpp"
#include "pipescout/runtime/diagnostics.hpp"
#include "pipescout/runtime/executor.hpp"
#include "pipescout/runtime/node.hpp"
#include "pipescout/runtime/standard_topics.hpp"
#include "rosgraph_msgs/msg/clock.hpp"

namespace pipescout::host {
namespace {

using ::testing::HasSubstr;

TEST(CpuSeconds, AreReadBehindTheNameOfTheProcess) {
  EXPECT_EQ(cpu_seconds_in("12 (a) b) R 1 2 3 4 5 6 7 8 9 10 150 50 11 12", 100.0), 2.0);
}

TEST(CpuSeconds, OfSomethingElseAreNone) {
  EXPECT_LT(cpu_seconds_in("", 100.0), 0.0);
  EXPECT_LT(cpu_seconds_in("12 (a) R 1 2", 100.0), 0.0);
}

std::string value_of(const diagnostic_msgs::msg::DiagnosticStatus& status, const std::string& key) {
  for (const auto& pair : status.values) {
    if (pair.key == key) {
      return pair.value;
    }
  }
  return "none";
}

TEST(HostStatusTest, TellsOfItsProcess) {
  HostStatus status({"/robot_1", "host"}, {});
  const auto first = status.process({}, SteadyTime(std::chrono::seconds(1)));
  EXPECT_EQ(first.name, "robot_1/host: process");
  EXPECT_EQ(value_of(first, "cpu_percent"), "none");
  EXPECT_EQ(value_of(first, "processes"), "1");
  EXPECT_GT(std::stod(value_of(first, "memory_mb")), 1.0);
  EXPECT_GT(std::stod(value_of(first, "started")), 1.6e9);
  const auto second = status.process({}, SteadyTime(std::chrono::seconds(2)));
  EXPECT_GE(std::stod(value_of(second, "cpu_percent")), 0.0);
}

TEST(HostStatusTest, NamesSeveralPublishersOfAClock) {
  const auto context = Context::create_in_process();
  Executor executor;
  Node node({.context = context, .executor = &executor, .name = {"/robot_1", "simulator"}});
  const HostStatus status({"/robot_1", "host"}, {{"/robot_1", "simulator"}});
  const auto first = node.create_publisher<rosgraph_msgs::msg::Clock>("clock", topics::kClock.qos);
  EXPECT_EQ(status.network(context->graph()).level,
            static_cast<std::uint8_t>(DiagnosticLevel::kOk));
  const auto second = node.create_publisher<rosgraph_msgs::msg::Clock>("clock", topics::kClock.qos);
  const auto said = status.network(context->graph());
  EXPECT_EQ(said.level, static_cast<std::uint8_t>(DiagnosticLevel::kError));
  EXPECT_THAT(said.message, HasSubstr("2 publishers drive /robot_1/clock"));
}

}  // namespace
}  // namespace pipescout::host
