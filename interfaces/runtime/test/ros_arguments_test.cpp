// SPDX-License-Identifier: Apache-2.0
#include "pipescout/runtime/ros_arguments.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include <fstream>

#include "pipescout/files/testing/temporary_folder.hpp"

namespace pipescout {
namespace {

using ::testing::AllOf;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::StartsWith;

RosArguments parse(std::vector<std::string> of_ros) {
  of_ros.insert(of_ros.begin(), "--ros-args");
  return parse_ros_arguments(of_ros);
}

std::string error_of(const std::vector<std::string>& of_ros) {
  try {
    static_cast<void>(parse(of_ros));
  } catch (const RosArgumentError& error) {
    return error.what();
  }
  return "no error";
}

/// "name = value" in the order of names.
std::vector<std::string> parameters_of(const RosArguments& arguments, const std::string& node) {
  std::vector<std::string> texts;
  for (const auto& parameter : arguments.parameters.overrides_for(node)) {
    texts.push_back(parameter.name + " = " + to_yaml(parameter.value));
  }
  std::sort(texts.begin(), texts.end());
  return texts;
}

TEST(RosArguments, OthersAreLeftAsTheyAre) {
  const auto arguments =
      parse_ros_arguments({"-r", "first", "--ros-args", "-r", "a:=b", "--", "-p", "--", "x:=y",
                           "--ros-args", "--ros-args", "--log-level", "warn"});
  EXPECT_THAT(arguments.others, ElementsAre("-r", "first", "-p", "--", "x:=y"));
  EXPECT_THAT(arguments.remap_rules, ElementsAre(RemapRule::parse("a:=b")));
  EXPECT_THAT(arguments.log_levels, ElementsAre(LogLevelRule{"", LogSeverity::kWarn}));

  const char* const argv[] = {"program", "one", "--ros-args"};
  EXPECT_THAT(parse_ros_arguments(3, argv).others, ElementsAre("one"));
  EXPECT_THAT(parse_ros_arguments(0, nullptr).others, IsEmpty());
}

TEST(RosArguments, Remapping) {
  const auto arguments = parse({"-r", "__node:=left", "--remap", "camera:__ns:=/robot_1", "-r",
                                "left:~/image:=/image", "--remap", "rostopic://a:=b"});
  const auto node = remap_node({"/", "camera"}, arguments.remap_rules);
  EXPECT_EQ(node, (NodeName{"/", "left"}));
  EXPECT_EQ(resolve_topic_name("~/image", node, arguments.remap_rules), "/image");
  EXPECT_EQ(resolve_topic_name("a", node, arguments.remap_rules), "/b");
  EXPECT_EQ(resolve_service_name("a", node, arguments.remap_rules), "/a");
}

TEST(RosArguments, LaterParametersCount) {
  const testing::TemporaryFolder folder;
  const auto file = (folder.path() / "p.yaml").string();
  std::ofstream(file)
      << "/**:\n  ros__parameters: {a: 1, b: 1}\nfusion:\n  ros__parameters: {c: 1}\n"
         "other:\n  ros__parameters: {d: 1}\n";
  const auto arguments = parse({"-p", "a:=0", "-p", "fusion:c:=0", "--params-file", file, "--param",
                                "b:=[1.5, 2.0]", "-p", "other:b:=3", "-p", "e:='1'"});
  EXPECT_THAT(parameters_of(arguments, "/fusion"),
              ElementsAre("a = 1", "b = [1.5, 2.0]", "c = 1", "e = \"1\""));
  EXPECT_THAT(parameters_of(arguments, "/other"),
              ElementsAre("a = 1", "b = 3", "d = 1", "e = \"1\""));
  const auto overrides = arguments.parameters.overrides_for("/fusion");
  const auto is_b = [](const auto& parameter) { return parameter.name == "b"; };
  EXPECT_EQ(std::find_if(overrides.begin(), overrides.end(), is_b)->source,
            "--param b:=[1.5, 2.0]");
}

TEST(RosArguments, ThresholdOfTheNearestLogger) {
  const auto arguments = parse({"--log-level", "ERROR", "--log-level", "robot:=Warn", "--log-level",
                                "robot.arm:=debug", "--log-level", "robot.arm:=fatal"});
  EXPECT_EQ(arguments.log_threshold("fusion"), LogSeverity::kError);
  EXPECT_EQ(arguments.log_threshold("robot"), LogSeverity::kWarn);
  EXPECT_EQ(arguments.log_threshold("robot.base"), LogSeverity::kWarn);
  EXPECT_EQ(arguments.log_threshold("robot.arm"), LogSeverity::kFatal);
  EXPECT_EQ(arguments.log_threshold("robot.arm.wrist"), LogSeverity::kFatal);
  EXPECT_EQ(arguments.log_threshold("robot_2"), LogSeverity::kError);
  EXPECT_EQ(parse({"--log-level", "a:=info"}).log_threshold("b"), std::nullopt);
}

TEST(RosArguments, WhatIsSoInAnyCaseIsNoError) {
  EXPECT_THAT(parse({"--enable-rosout-logs", "--enable-stdout-logs"}).others, IsEmpty());
  EXPECT_EQ(parse({"-e", "/a", "--enclave", "/b"}).enclave, "/b");
}

TEST(RosArguments, ErrorsNameTheArgument) {
  EXPECT_EQ(error_of({"-r"}), "-r needs a rule FROM:=TO behind it");
  EXPECT_EQ(error_of({"--params-file"}), "--params-file needs the name of a file behind it");
  EXPECT_THAT(error_of({"-r", "chatter"}), StartsWith("-r chatter: "));
  EXPECT_THAT(error_of({"--remap", "__node:=a/b"}), StartsWith("--remap __node:=a/b: "));
  EXPECT_THAT(error_of({"-p", "rate"}), StartsWith("-p rate: "));
  EXPECT_THAT(error_of({"-p", ":=1"}), StartsWith("-p :=1: "));
  EXPECT_THAT(error_of({"-p", "a:=[1, x]"}), StartsWith("-p a:=[1, x]: "));
  EXPECT_THAT(error_of({"-p", "a b:c:=1"}), StartsWith("-p a b:c:=1: "));
  EXPECT_THAT(error_of({"--params-file", "no/such.yaml"}),
              AllOf(StartsWith("--params-file: no/such.yaml: "), HasSubstr("No such file")));
  EXPECT_EQ(error_of({"--log-level", "loud"}),
            "--log-level loud: 'loud' is not one of debug, info, warn, error, fatal");
  EXPECT_EQ(error_of({"--log-level", "a:="}),
            "--log-level a:=: '' is not one of debug, info, warn, error, fatal");
  EXPECT_EQ(error_of({"--log-level", ":=info"}),
            "--log-level :=info: the name of a logger is missing before ':='");
  EXPECT_EQ(error_of({"chatter:=a"}), "'chatter:=a' is not an argument of --ros-args");
  EXPECT_EQ(error_of({"-r=a:=b"}), "'-r=a:=b' is not an argument of --ros-args");
}

TEST(RosArguments, WhatRclTakesBeyondIsRefusedWithTheReason) {
  EXPECT_EQ(error_of({"--disable-rosout-logs"}),
            "--disable-rosout-logs is not supported: messages are always published on /rosout; "
            "select them with --log-level");
  EXPECT_THAT(error_of({"--disable-stdout-logs"}),
              StartsWith("--disable-stdout-logs is not supported: "));
  for (const char* argument :
       {"--disable-external-lib-logs", "--enable-external-lib-logs", "--log-config-file"}) {
    EXPECT_EQ(error_of({argument, "file"}),
              std::string(argument) +
                  " is not supported: there are no log files; redirect the standard error stream, "
                  "or record /rosout");
  }
}

RC_GTEST_PROP(RosArgumentsProperty, AnyWordsGiveAResultOrOneKindOfError, ()) {
  const auto word = rc::gen::oneOf(
      rc::gen::element<std::string>("--ros-args", "--", "-r", "-p", "--params-file", "--log-level",
                                    "-e", "a:=b", "__ns:=/a", "info", "x:=1"),
      rc::gen::container<std::string>(rc::gen::element('-', ':', '=', 'a', '/', '[', '{', '*')));
  const auto words = *rc::gen::container<std::vector<std::string>>(word);
  try {
    const auto arguments = parse_ros_arguments(words);
    RC_ASSERT(arguments.others.size() <= words.size());
  } catch (const RosArgumentError& error) {
    RC_ASSERT(!std::string(error.what()).empty());
  }
}

}  // namespace
}  // namespace pipescout
