// SPDX-License-Identifier: Apache-2.0
#include "pipescout/bag_topics/bag_topic.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <geometry_msgs/msg/point_stamped.hpp>
#include <string>
#include <vector>

namespace pipescout {
namespace {

using ::testing::HasSubstr;
using ::testing::StartsWith;

TEST(BagTopicTest, ASchemaHasEveryTypeOnce) {
  const auto& type = message_type<geometry_msgs::msg::PointStamped>();
  const std::string schema = ros2msg_schema(type);
  const std::string line(80, '=');
  EXPECT_THAT(schema, StartsWith(std::string(type.definition)));
  for (const char* nested : {"std_msgs/Header", "builtin_interfaces/Time", "geometry_msgs/Point"}) {
    const auto heading = line + "\nMSG: " + nested + "\n";
    EXPECT_THAT(schema, HasSubstr(heading));
    EXPECT_EQ(schema.find(heading), schema.rfind(heading));
  }
}

TEST(BagTopicTest, AnUnknownTypeHasNoDefinition) {
  const auto topic =
      make_bag_topic("/secret", "nobody_msgs/msg/Unheard", std::vector{QoS::sensor_data()});
  EXPECT_EQ(topic.name, "/secret");
  EXPECT_EQ(topic.type, "nobody_msgs/msg/Unheard");
  EXPECT_EQ(topic.serialization_format, "cdr");
  EXPECT_EQ(topic.schema_encoding, "");
  EXPECT_EQ(topic.schema_text, "");
  EXPECT_THAT(topic.offered_qos_profiles, HasSubstr("reliability: 2"));
  EXPECT_EQ(make_bag_topic("/point", "geometry_msgs/msg/PointStamped", {}).schema_encoding,
            "ros2msg");
}

}  // namespace
}  // namespace pipescout
