// SPDX-License-Identifier: Apache-2.0
#include "cli/yaml_message.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <diagnostic_msgs/msg/diagnostic_status.hpp>
#include <geometry_msgs/msg/twist_stamped.hpp>
#include <nav_msgs/msg/odometry.hpp>
#include <rcl_interfaces/msg/parameter_descriptor.hpp>
#include <std_msgs/msg/string.hpp>
#include <string>

namespace pipescout::host {
namespace {

template <class T>
T parsed(const std::string& yaml) {
  T message;
  set_from_yaml(yaml, message_type<T>(), &message);
  return message;
}

template <class T>
std::string error_of(const std::string& yaml) {
  try {
    parsed<T>(yaml);
  } catch (const YamlMessageError& error) {
    return error.what();
  }
  return "none";
}

using diagnostic_msgs::msg::DiagnosticStatus;
using geometry_msgs::msg::TwistStamped;
using nav_msgs::msg::Odometry;
using std_msgs::msg::String;

TEST(YamlMessage, SetsWhatIsNamed) {
  const auto twist = parsed<TwistStamped>(
      "{header: {frame_id: base, stamp: {sec: -3}}, twist: {linear: {x: 1, y: -2.5, z: .inf}}}");
  EXPECT_EQ(twist.header.frame_id, "base");
  EXPECT_EQ(twist.header.stamp.sec, -3);
  EXPECT_EQ(twist.twist.linear.x, 1.0);
  EXPECT_EQ(twist.twist.linear.y, -2.5);
  EXPECT_TRUE(std::isinf(twist.twist.linear.z));
  EXPECT_EQ(twist.twist.angular, geometry_msgs::msg::Vector3());
  EXPECT_EQ(parsed<String>(""), String());
  EXPECT_EQ(parsed<String>("data: 5").data, "5");
}

TEST(YamlMessage, BytesAreNumbersOrCharacters) {
  EXPECT_EQ(parsed<DiagnosticStatus>("level: 2").level, 2);
  EXPECT_EQ(parsed<DiagnosticStatus>("level: 0x10").level, 16);
  EXPECT_EQ(parsed<DiagnosticStatus>("level: \"\\x02\"").level, 2);
  EXPECT_EQ(parsed<DiagnosticStatus>("level: '2'").level, '2');
  EXPECT_EQ(parsed<DiagnosticStatus>("level: ÿ").level, 255);
}

TEST(YamlMessage, WhatDoesNotFitIsSaidWithItsPath) {
  EXPECT_EQ(error_of<TwistStamped>("header: {stamp: {sec: 3000000000}}"),
            "header.stamp.sec: 3000000000 does not fit into int32");
  EXPECT_EQ(error_of<TwistStamped>("header: {stamp: {sec: 1.5}}"),
            "header.stamp.sec: '1.5' is no int32");
  EXPECT_EQ(error_of<TwistStamped>("header: {stam: {}}"),
            "header: 'stam' is not a field of std_msgs/msg/Header");
  EXPECT_EQ(error_of<TwistStamped>("twist: 5"),
            "twist: expected a mapping with fields of geometry_msgs/msg/Twist");
  EXPECT_EQ(error_of<Odometry>("pose: {covariance: [1, 2]}"),
            "pose.covariance: expected 36 elements, not 2");
  EXPECT_EQ(error_of<Odometry>("pose: {covariance: 1}"), "pose.covariance: expected a list");
  EXPECT_EQ(error_of<DiagnosticStatus>("values: [{key: a}, {kei: b}]"),
            "values[1]: 'kei' is not a field of diagnostic_msgs/msg/KeyValue");
  EXPECT_EQ(error_of<rcl_interfaces::msg::ParameterDescriptor>("integer_range: [{}, {}]"),
            "integer_range: a sequence of at most 1 elements was to hold 2");
  EXPECT_EQ(error_of<String>("just text"),
            "the message: expected a mapping with fields of std_msgs/msg/String");
  EXPECT_TRUE(error_of<String>("{data: ").starts_with("the values are not YAML: "));
}

}  // namespace
}  // namespace pipescout::host
