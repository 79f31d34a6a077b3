// SPDX-License-Identifier: Apache-2.0
#include "cli/message_text.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <diagnostic_msgs/msg/diagnostic_array.hpp>
#include <geometry_msgs/msg/pose_with_covariance_stamped.hpp>
#include <limits>
#include <pipescout_msgs/msg/fused_odometer.hpp>
#include <rcl_interfaces/msg/parameter_descriptor.hpp>
#include <sensor_msgs/msg/image.hpp>
#include <std_msgs/msg/empty.hpp>
#include <std_msgs/msg/string.hpp>

namespace pipescout::host {
namespace {

template <class T>
DynamicMessage read(const T& message) {
  const auto& type = message_type<T>();
  std::vector<std::byte> bytes(type.serialized_size(&message));
  bytes.resize(type.serialize(&message, bytes));
  return read_message(MessageDescriptions::installed().find(type.name), bytes);
}

struct Quoting {
  std::string_view text;
  std::string_view block;
  std::string_view flow;
};

TEST(YamlText, QuotesAsPyYamlDoes) {
  // Written by PyYAML 6.0 as the value of a mapping and as the item of a flow sequence.
  constexpr Quoting kCases[] = {
      {"", "''", "''"},
      {"hello", "hello", "hello"},
      {"true", "'true'", "'true'"},
      {"Yes", "'Yes'", "'Yes'"},
      {"1", "'1'", "'1'"},
      {"1.0", "'1.0'", "'1.0'"},
      {"1e5", "1e5", "1e5"},
      {"1.5e+3", "'1.5e+3'", "'1.5e+3'"},
      {"-7", "'-7'", "'-7'"},
      {"0x1f", "'0x1f'", "'0x1f'"},
      {"0o17", "0o17", "0o17"},
      {"017", "'017'", "'017'"},
      {"190:20:30", "'190:20:30'", "'190:20:30'"},
      {"2001-01-01", "'2001-01-01'", "'2001-01-01'"},
      {"2001-12-14t21:59:43.10-05:00", "'2001-12-14t21:59:43.10-05:00'",
       "'2001-12-14t21:59:43.10-05:00'"},
      {"~", "'~'", "'~'"},
      {"null", "'null'", "'null'"},
      {"<<", "'<<'", "'<<'"},
      {"=", "'='", "'='"},
      {".inf", "'.inf'", "'.inf'"},
      {".nan", "'.nan'", "'.nan'"},
      {"...", "'...'", "'...'"},
      {"---", "'---'", "'---'"},
      {"- a", "'- a'", "'- a'"},
      {"-a", "-a", "-a"},
      {"a: b", "'a: b'", "'a: b'"},
      {"a:b", "a:b", "'a:b'"},
      {"a #b", "'a #b'", "'a #b'"},
      {"a#b", "a#b", "a#b"},
      {"#a", "'#a'", "'#a'"},
      {"[x]", "'[x]'", "'[x]'"},
      {"x, y", "x, y", "'x, y'"},
      {"? a", "'? a'", "'? a'"},
      {"?a", "?a", "'?a'"},
      {": a", "': a'", "': a'"},
      {":a", ":a", "':a'"},
      {"*a", "'*a'", "'*a'"},
      {"&a", "'&a'", "'&a'"},
      {"|", "'|'", "'|'"},
      {"> x", "'> x'", "'> x'"},
      {"'q'", "'''q'''", "'''q'''"},
      {"it's", "it's", "it's"},
      {"\"q\"", "'\"q\"'", "'\"q\"'"},
      {"%x", "'%x'", "'%x'"},
      {"@x", "'@x'", "'@x'"},
      {" lead", "' lead'", "' lead'"},
      {"trail ", "'trail '", "'trail '"},
      {"a  b", "a  b", "a  b"},
      {"a\nb", "'a\n\n  b'", "'a\n\n    b'"},
      {"a\n\nb", "'a\n\n\n  b'", "'a\n\n\n    b'"},
      {"a\n b", "\"a\\n b\"", "\"a\\n b\""},
      {"a \nb", "\"a \\nb\"", "\"a \\nb\""},
      {"\na", "'\n\n  a'", "'\n\n    a'"},
      {"a\n", "'a\n\n  '", "'a\n\n    '"},
      {"tab\011here", "\"tab\\there\"", "\"tab\\there\""},
      {"\001", "\"\\x01\"", "\"\\x01\""},
      {"caf\303\251", "caf\303\251", "caf\303\251"},
      {"\344\270\255", "\344\270\255", "\344\270\255"},
      {"\177", "\"\\x7F\"", "\"\\x7F\""},
      {"\302\205", "'\302\205  '", "'\302\205    '"},
      {"\342\200\250", "'\342\200\250  '", "'\342\200\250    '"},
      {"\357\273\277", "\"\\uFEFF\"", "\"\\uFEFF\""},
      {"\360\237\230\200", "\360\237\230\200", "\360\237\230\200"},
      {"off", "'off'", "'off'"},
      {"=x", "=x", "=x"},
      {"!", "'!'", "'!'"},
      {"-", "'-'", "'-'"},
      {"1.", "'1.'", "'1.'"},
      {"+.5", "+.5", "+.5"},
      {"-.5", "-.5", "-.5"},
      {".5", "'.5'", "'.5'"},
      {"1,2", "1,2", "'1,2'"},
      {"<array type: double[9]>", "'<array type: double[9]>'", "'<array type: double[9]>'"},
      {"0b01", "'0b01'", "'0b01'"},
      {"_", "_", "_"},
      {"a\\b", "a\\b", "a\\b"},
      {"9:59", "'9:59'", "'9:59'"},
  };
  for (const auto& [text, block, flow] : kCases) {
    EXPECT_EQ(yaml_text(text, false, 2), block) << text;
    EXPECT_EQ(yaml_text(text, true, 4), flow) << text;
  }
}

TEST(YamlText, ReplacesWhatIsNoUtf8) {
  EXPECT_EQ(yaml_text("a\xff\xc3", false, 2), "a\xef\xbf\xbd\xef\xbf\xbd");
  EXPECT_EQ(yaml_text("\xed\xa0\x80", false, 2),
            "\xef\xbf\xbd\xef\xbf\xbd\xef\xbf\xbd");                       // a surrogate
  EXPECT_EQ(yaml_text("\xc0\x80", false, 2), "\xef\xbf\xbd\xef\xbf\xbd");  // overlong
}

pipescout_msgs::msg::FusedOdometer fused() {
  pipescout_msgs::msg::FusedOdometer message;
  message.header.stamp.sec = 12;
  message.header.stamp.nanosec = 500;
  message.distance = 5.51;
  message.variance = 1e-7;
  message.speed = 0.5;
  message.name = {"left", "1"};
  message.in_fusion_set = {true, false};
  message.support = {1, 0};
  message.confidence_distance = {std::numeric_limits<double>::quiet_NaN(),
                                 -std::numeric_limits<double>::infinity(), 1e16, 2.0};
  return message;
}

TEST(ToYaml, WritesNestedMessagesAndArrays) {
  EXPECT_EQ(to_yaml(read(fused()), {}), R"(header:
  stamp:
    sec: 12
    nanosec: 500
  frame_id: ''
distance: 5.51
variance: 1.0e-07
name:
- left
- '1'
in_fusion_set:
- true
- false
support:
- 1
- 0
confidence_distance:
- .nan
- -.inf
- 1.0e+16
- 2.0
rejection_reason: []
status: 0
speed: 0.5
independent_variance: 0.0
health: []
scale: []
scale_standard_deviation: []
)");
}

TEST(ToYaml, WritesSequencesOfMessages) {
  diagnostic_msgs::msg::DiagnosticArray message;
  diagnostic_msgs::msg::DiagnosticStatus status;
  status.level = 2;
  status.name = "fusion: status";
  diagnostic_msgs::msg::KeyValue value;
  value.key = "restarts";
  value.value = "3";
  status.values = {value, value};
  message.status = {status};
  EXPECT_EQ(to_yaml(read(message), {}), R"(header:
  stamp:
    sec: 0
    nanosec: 0
  frame_id: ''
status:
- level: "\x02"
  name: 'fusion: status'
  message: ''
  hardware_id: ''
  values:
  - key: restarts
    value: '3'
  - key: restarts
    value: '3'
)");
}

TEST(ToYaml, CutsWhatIsLong) {
  sensor_msgs::msg::Image image;
  image.encoding = "mono16";
  image.data.resize(5);
  image.header.frame_id = std::string(130, 'x');
  const auto text = to_yaml(read(image), {.truncate = 3});
  EXPECT_THAT(text, ::testing::HasSubstr("data:\n- 0\n- 0\n- 0\n- '...'\n"));
  EXPECT_THAT(text, ::testing::HasSubstr("frame_id: xxx...\n"));
  EXPECT_THAT(text, ::testing::HasSubstr("encoding: mon...\n"));
  EXPECT_THAT(to_yaml(read(image), {}),
              ::testing::HasSubstr("frame_id: " + std::string(128, 'x') + "...\n"));
  const auto whole = to_yaml(read(image), {.truncate = std::nullopt});
  EXPECT_THAT(whole, ::testing::HasSubstr("frame_id: " + std::string(130, 'x') + "\n"));
  EXPECT_THAT(whole, ::testing::Not(::testing::HasSubstr("...")));
}

TEST(ToYaml, CutsBetweenCharacters) {
  std_msgs::msg::String message;
  message.data = "\xc3\xa9\xc3\xa9\xc3\xa9";
  EXPECT_EQ(to_yaml(read(message), {.truncate = 2}), "data: \xc3\xa9\xc3\xa9...\n");
}

TEST(ToYaml, LeavesArraysAndTextsOut) {
  geometry_msgs::msg::PoseWithCovarianceStamped pose;
  EXPECT_THAT(to_yaml(read(pose), {.no_arrays = true}),
              ::testing::HasSubstr("  covariance: '<array type: double[36]>'\n"));
  EXPECT_THAT(to_yaml(read(fused()), {.no_arrays = true}),
              ::testing::HasSubstr("name: '<sequence type: string, length: 2>'\n"));
  EXPECT_THAT(to_yaml(read(rcl_interfaces::msg::ParameterDescriptor{}), {.no_arrays = true}),
              ::testing::HasSubstr(
                  "floating_point_range: "
                  "'<sequence type: rcl_interfaces/msg/FloatingPointRange[1], length: 0>'\n"));
  std_msgs::msg::String text;
  text.data = "hello";
  EXPECT_EQ(to_yaml(read(text), {.no_strings = true}), "data: '<string length: <5>>'\n");
}

TEST(ToYaml, WritesInOneLine) {
  EXPECT_EQ(to_yaml(read(fused()), {.flow = true}),
            "{header: {stamp: {sec: 12, nanosec: 500}, frame_id: ''}, distance: 5.51, "
            "variance: 1.0e-07, name: [left, '1'], in_fusion_set: [true, false], support: [1, 0], "
            "confidence_distance: [.nan, -.inf, 1.0e+16, 2.0], rejection_reason: [], status: 0, "
            "speed: 0.5, independent_variance: 0.0, health: [], scale: [], "
            "scale_standard_deviation: []}\n");
}

TEST(ToYaml, ShowsAnEmptyMessageAsEmpty) {
  EXPECT_EQ(to_yaml(read(std_msgs::msg::Empty{}), {}), "{}\n");
}

TEST(ToCsv, WritesTheValuesInOrder) {
  EXPECT_EQ(to_csv(read(fused()), {.truncate = 3}),
            "12,500,,5.51,1e-07,lef...,1,True,False,1,0,nan,-inf,1e+16,...,0,0.5,0.0");
}

TEST(ToText, WritesFieldsAsTheyAre) {
  const auto message = read(fused());
  const auto field = [&](const char* path) { return to_text(find_field(message, path), {}); };
  EXPECT_EQ(field("distance"), "5.51\n");
  EXPECT_EQ(field("header.stamp"), "sec: 12\nnanosec: 500\n");
  EXPECT_EQ(field("in_fusion_set"), "[true, false]\n");
  EXPECT_EQ(field("name"), "[left, '1']\n");
  EXPECT_EQ(field("header.frame_id"), "\n");
}

}  // namespace
}  // namespace pipescout::host
