// SPDX-License-Identifier: Apache-2.0
#include "pipescout/dds/run_component.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <csignal>
#include <fstream>
#include <std_msgs/msg/string.hpp>

#include "pipescout/dds/dds_transport.hpp"
#include "pipescout/files/testing/temporary_folder.hpp"
#include "pipescout/testing/program.hpp"

namespace pipescout {
namespace {

using ::testing::AllOf;
using testing::Finished;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using testing::kPatience;
using testing::Program;
using ::testing::StartsWith;

class RunComponent : public ::testing::Test {
 protected:
  [[nodiscard]] Finished run(std::vector<std::string> of_ros) const {
    of_ros.insert(of_ros.begin(), "--ros-args");
    return testing::run_program(TALKER_PROGRAM, of_ros, folder_.path());
  }
  [[nodiscard]] Program start(std::vector<std::string> of_ros) const {
    of_ros.insert(of_ros.begin(), "--ros-args");
    return {TALKER_PROGRAM, of_ros, folder_.path()};
  }

  /// What is heard first on a topic; empty when nothing comes.
  static std::string heard_on(const std::string& topic) {
    Executor executor;
    Node listener({.context = Context::create(create_dds_transport(DdsOptions::from_environment())),
                   .executor = &executor,
                   .name = {"/", "listener"},
                   .remap_rules = {},
                   .parameter_overrides = {},
                   .standard_interfaces = false});
    std::string text;
    const auto subscription = listener.create_subscription<std_msgs::msg::String>(
        topic, QoS::latched(),
        [&text](const std_msgs::msg::String& message) { text = message.data; });
    executor.spin_until([&text] { return !text.empty(); }, kPatience);
    return text;
  }

  testing::TemporaryFolder folder_;
};

TEST_F(RunComponent, EndsInGoodOrderWhenASignalAsks) {
  for (const int signal : {SIGTERM, SIGINT, SIGHUP}) {
    auto program = start({});
    ASSERT_TRUE(program.wait_for_err("[talker]: active\n"));
    program.signal(signal);
    const auto finished = program.finish();
    EXPECT_EQ(finished.code(), 0) << signal;
    const auto deactivated = finished.err.find("[talker]: deactivated\n");
    EXPECT_LT(deactivated, finished.err.find("[talker]: cleaned up\n"));
    EXPECT_NE(deactivated, std::string::npos) << finished.err;
    EXPECT_THAT(finished.out, IsEmpty());
  }
}

TEST_F(RunComponent, TakesNamesParametersAndLogLevel) {
  std::ofstream(folder_.path() / "p.yaml")
      << "/**:\n  ros__parameters: {text: of all, unknown_here: 1}\n"
         "/robot/left:\n  ros__parameters: {text: of left, repeat: 2}\n"
         "/robot/right:\n  ros__parameters: {text: of right, other: 1}\n";
  auto program = start({"-r", "__node:=left", "-r", "__ns:=/robot", "-r", "left:chatter:=/news",
                        "--params-file", "p.yaml", "--log-level", "robot:=debug"});
  ASSERT_TRUE(program.wait_for_err("[robot.left]: active\n"));
  EXPECT_THAT(program.err(), HasSubstr("[DEBUG]"));
  EXPECT_EQ(heard_on("/news"), "of leftof left");
}

TEST_F(RunComponent, IsQuietAboveItsLogLevel) {
  auto program = start({"-p", "text:=loud", "--log-level", "error"});
  EXPECT_EQ(heard_on("/chatter"), "loud");
  program.signal(SIGTERM);
  const auto finished = program.finish();
  EXPECT_EQ(finished.code(), 0);
  EXPECT_THAT(finished.err, IsEmpty());
}

TEST_F(RunComponent, WrongArgumentsExitWith2AndAreNamed) {
  const std::vector<std::pair<std::vector<std::string>, std::string>> cases{
      {{"-r", "chatter"}, "error: -r chatter: "},
      {{"-p", "txt:=a"}, "error: -p txt:=a: no parameter 'txt'; did you mean 'text'?"},
      {{"--param", "talker:txt:=a"}, "error: --param talker:txt:=a: no parameter 'txt'"},
      {{"-p", "repeat:=10"}, "error: -p repeat:=10: "},
      {{"-p", "repeat:=1.0"}, "error: -p repeat:=1.0: "},
      {{"--params-file", "none.yaml"}, "error: --params-file: none.yaml: "},
      {{"--log-level", "loud"}, "error: --log-level loud: "},
      {{"--disable-rosout-logs"}, "error: --disable-rosout-logs is not supported: "},
      {{"--", "x"}, "error: 'x' is not an argument of this program; "}};
  for (const auto& [arguments, message] : cases) {
    const auto finished = run(arguments);
    EXPECT_EQ(finished.code(), 2) << message;
    EXPECT_THAT(finished.err, StartsWith(message));
  }
  std::ofstream(folder_.path() / "p.yaml") << "talker:\n  ros__parameters: {txt: a}\n";
  const auto finished = run({"--params-file", "p.yaml"});
  EXPECT_EQ(finished.code(), 2);
  EXPECT_THAT(finished.err, StartsWith("error: p.yaml:2: no parameter 'txt'"));
}

TEST_F(RunComponent, WhatCannotStartExitsWith1) {
  auto finished = run({"-p", "failure:=constructor"});
  EXPECT_EQ(finished.code(), 1);
  EXPECT_THAT(finished.err, HasSubstr("error: the constructor failed\n"));
  finished = run({"-p", "failure:=configure"});
  EXPECT_EQ(finished.code(), 1);
  EXPECT_THAT(finished.err, AllOf(HasSubstr("error: component /talker: "), HasSubstr("no device")));
}

TEST_F(RunComponent, EndsByForceWhenACallbackHangs) {
  auto program = start({"-p", "failure:=hang"});
  ASSERT_TRUE(program.wait_for_err("hangs\n"));
  program.signal(SIGTERM);
  const auto finished = program.finish();
  EXPECT_EQ(finished.code(), 1);
  EXPECT_THAT(finished.err, HasSubstr("error: some components did not stop in time"));
}

TEST_F(RunComponent, Help) {
  const auto finished = testing::run_program(TALKER_PROGRAM, {"--help"}, folder_.path());
  EXPECT_EQ(finished.code(), 0);
  EXPECT_THAT(finished.out, AllOf(StartsWith("usage: "), HasSubstr("--params-file FILE")));
}

}  // namespace
}  // namespace pipescout
