// SPDX-License-Identifier: Apache-2.0
// Definitions as .msg text: what `interface show`, MCAP and the export to ROS 2 give.
#include <gtest/gtest.h>

#include <string>
#include <test_msgs/msg/everything.hpp>
#include <test_msgs/msg/from_idl.hpp>
#include <test_msgs/msg/nothing.hpp>

#include "definitions.hpp"
#include "msg_emitter.hpp"
#include "names.hpp"
#include "parsers.hpp"

namespace pipescout {
namespace {

TEST(MsgTextTest, CommentsOfMsgFilesAreKept) {
  const std::string text(message_type<test_msgs::msg::Everything>().definition);
  EXPECT_TRUE(text.starts_with("# Every type that a field can have.\n#\n# Second paragraph.\n\n"))
      << text;
  EXPECT_NE(text.find("# The largest number of eight bits.\nuint8 LARGEST=255\n"),
            std::string::npos);
  EXPECT_NE(text.find("int64 SMALLEST=-9223372036854775808  # of 64 bits\n"), std::string::npos);
  EXPECT_NE(text.find("float64 f64_default 0.001  # m\n"), std::string::npos);
  EXPECT_NE(text.find("string<=5[<=3] few_short_texts\n"), std::string::npos);
}

TEST(MsgTextTest, CommentsOfIdlFilesAreKept) {
  EXPECT_EQ(message_type<test_msgs::msg::FromIdl>().definition,
            "# Speaks of the whole.\n"
            "\n"
            "# Of the level.\n"
            "# Two lines.\n"
            "byte WARN=1\n"
            "string NAME=\"name\"\n"
            "\n"
            "# row-major\n"
            "float64[9] matrix\n"
            "Inner[2] inners\n"
            "uint32 count 2  # [m]\n"
            "int16[] numbers [1, 2]\n"
            "Inner[<=4] few\n"
            "string<=8 map\n"
            "wstring wide\n"
            "Inner relative\n");
  EXPECT_EQ(message_type<test_msgs::msg::Nothing>().definition, "# Says only that it was sent.\n");
}

/// The text is read again as the same definition.
TEST(MsgTextTest, EveryDefinitionSurvivesItsText) {
  generator::Definitions definitions({DEFINITIONS_DIR, TEST_DEFINITIONS_DIR}, {});
  for (const auto& name :
       {"test_msgs/msg/Everything", "test_msgs/msg/FromIdl", "test_msgs/msg/Nothing",
        "test_msgs/srv/Sum", "test_msgs/action/Count", "sensor_msgs/msg/BatteryState",
        "rcl_interfaces/msg/ParameterDescriptor", "diagnostic_msgs/msg/DiagnosticStatus",
        "nav_msgs/srv/GetMap", "pipescout_msgs/msg/LeakEvent"}) {
    SCOPED_TRACE(name);
    const auto& interface = definitions.load(name);
    const auto text = generator::msg_text(interface);
    const auto again = generator::parse_msg(
        text, {interface.package, interface.kind, interface.name, "again.msg"});
    EXPECT_EQ(generator::msg_text(again), text);
    ASSERT_LE(again.structures.size(), interface.structures.size());
    for (std::size_t i = 0; i < again.structures.size(); ++i) {
      EXPECT_EQ(again.structures[i].fields.size(), interface.structures[i].fields.size());
    }
  }
}

TEST(MsgTextTest, HeaderNames) {
  EXPECT_EQ(generator::snake_case("NavSatFix"), "nav_sat_fix");
  EXPECT_EQ(generator::snake_case("TFMessage"), "tf_message");
  EXPECT_EQ(generator::snake_case("TF2Error"), "tf2_error");
  EXPECT_EQ(generator::snake_case("Pose2D"), "pose2_d");
  EXPECT_EQ(generator::snake_case("UInt8MultiArray"), "u_int8_multi_array");
  EXPECT_EQ(generator::snake_case("PointCloud2"), "point_cloud2");
  EXPECT_EQ(generator::snake_case("UUID"), "uuid");
}

}  // namespace
}  // namespace pipescout
