// SPDX-License-Identifier: Apache-2.0
#include "pipescout/idl/message_type.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstddef>
#include <geometry_msgs/msg/pose2_d.hpp>
#include <geometry_msgs/msg/quaternion.hpp>
#include <pipescout_msgs/msg/fused_odometer.hpp>
#include <pipescout_msgs/msg/mission_status.hpp>
#include <rcl_interfaces/msg/log.hpp>
#include <rcl_interfaces/msg/parameter_descriptor.hpp>
#include <rcl_interfaces/srv/list_parameters.hpp>
#include <rcl_interfaces/srv/set_parameters_atomically.hpp>
#include <sensor_msgs/msg/nav_sat_fix.hpp>
#include <sensor_msgs/msg/nav_sat_status.hpp>
#include <sensor_msgs/msg/point_cloud2.hpp>
#include <std_msgs/msg/color_rgba.hpp>
#include <std_msgs/msg/u_int8_multi_array.hpp>
#include <std_srvs/srv/trigger.hpp>
#include <string>
#include <string_view>
#include <tf2_msgs/msg/tf2_error.hpp>
#include <tf2_msgs/msg/tf_message.hpp>
#include <trajectory_msgs/msg/joint_trajectory_point.hpp>
#include <type_traits>
#include <vector>
#include <visualization_msgs/msg/uv_coordinate.hpp>

#include "pipescout/idl/service_type.hpp"

namespace pipescout {
namespace {

// The includes above are those that rosidl's rule gives for these names. A header gives its own
// types and no others.
static_assert(Message<sensor_msgs::msg::NavSatFix>);
static_assert(Message<std_srvs::srv::Trigger_Request>);
static_assert(!Message<std_srvs::srv::Trigger>);
static_assert(!Message<int>);
static_assert(ServiceTag<std_srvs::srv::Trigger>);
static_assert(!ServiceTag<std_srvs::srv::Trigger_Request>);
static_assert(
    std::is_same_v<ServiceType<std_srvs::srv::Trigger>::Request, std_srvs::srv::Trigger_Request>);
static_assert(std::is_same_v<std_srvs::srv::Trigger::Response, std_srvs::srv::Trigger_Response>);
static_assert(ServiceType<std_srvs::srv::Trigger>::service_name == "std_srvs/srv/Trigger");

/// "std_srvs/srv/Trigger_Request" -> "std_srvs::srv::dds_::Trigger_Request_", as rmw_fastrtps does.
std::string mangled(std::string_view name) {
  const std::size_t first = name.find('/');
  const std::size_t last = name.rfind('/');
  return std::string(name.substr(0, first)) +
         "::" + std::string(name.substr(first + 1, last - first - 1)) +
         "::dds_::" + std::string(name.substr(last + 1)) + "_";
}

TEST(MessageTypeTest, NamesOfTypesAndServices) {
  EXPECT_EQ(message_type<sensor_msgs::msg::PointCloud2>().name, "sensor_msgs/msg/PointCloud2");
  EXPECT_EQ(message_type<sensor_msgs::msg::PointCloud2>().dds_name,
            "sensor_msgs::msg::dds_::PointCloud2_");
  EXPECT_EQ(message_type<std_srvs::srv::Trigger_Request>().name, "std_srvs/srv/Trigger_Request");
  EXPECT_EQ(message_type<std_srvs::srv::Trigger_Request>().dds_name,
            "std_srvs::srv::dds_::Trigger_Request_");
  EXPECT_EQ(message_type<std_srvs::srv::Trigger_Response>().dds_name,
            "std_srvs::srv::dds_::Trigger_Response_");
  EXPECT_EQ(message_type<pipescout_msgs::msg::FusedOdometer>().dds_name,
            "pipescout_msgs::msg::dds_::FusedOdometer_");
}

TEST(MessageTypeTest, EveryDdsNameIsTheMangledRosName) {
  for (const MessageType* type : message_types()) {
    EXPECT_EQ(type->dds_name, mangled(type->name));
  }
}

TEST(MessageTypeTest, RegistryIsSortedWithoutRepetition) {
  const auto types = message_types();
  ASSERT_GE(types.size(), 100u);
  EXPECT_EQ(std::ranges::adjacent_find(types, std::ranges::greater_equal{}, &MessageType::name),
            types.end());
}

TEST(MessageTypeTest, FindsEveryTypeByName) {
  for (const MessageType* type : message_types()) {
    EXPECT_EQ(find_message_type(type->name), type);
  }
  EXPECT_EQ(&message_type<tf2_msgs::msg::TFMessage>(), find_message_type("tf2_msgs/msg/TFMessage"));
}

TEST(MessageTypeTest, UnknownNamesAreNotFound) {
  for (const std::string_view name :
       {"", "a", "zzz", "sensor_msgs/msg/Imag", "sensor_msgs/msg/Image_", "sensor_msgs/Image",
        "std_srvs/srv/Trigger", "sensor_msgs::msg::dds_::Image_"}) {
    EXPECT_EQ(find_message_type(name), nullptr) << name;
  }
}

TEST(MessageTypeTest, DefaultsAreThoseOfRos) {
  const geometry_msgs::msg::Quaternion rotation;
  EXPECT_EQ(rotation.x, 0.0);
  EXPECT_EQ(rotation.y, 0.0);
  EXPECT_EQ(rotation.z, 0.0);
  EXPECT_EQ(rotation.w, 1.0);
  const rcl_interfaces::msg::ParameterDescriptor descriptor;
  EXPECT_FALSE(descriptor.read_only);
  EXPECT_FALSE(descriptor.dynamic_typing);
}

TEST(MessageTypeTest, ConstantsAreThoseOfRos) {
  EXPECT_EQ(sensor_msgs::msg::NavSatStatus::STATUS_NO_FIX, -1);
  EXPECT_EQ(sensor_msgs::msg::NavSatFix::COVARIANCE_TYPE_KNOWN, 3);
  EXPECT_EQ(rcl_interfaces::msg::Log::FATAL, 50);
  EXPECT_EQ(rcl_interfaces::srv::ListParameters_Request::DEPTH_RECURSIVE, 0u);
  EXPECT_EQ(tf2_msgs::msg::TF2Error::TRANSFORM_ERROR, 6);
  EXPECT_EQ(pipescout_msgs::msg::MissionStatus::FAILED, 2);
}

TEST(MessageTypeTest, EveryDefaultSurvivesARoundTrip) {
  for (const MessageType* type : message_types()) {
    SCOPED_TRACE(type->name);
    const auto message = type->create();
    std::vector<std::byte> bytes(type->serialized_size(message.get()));
    ASSERT_EQ(type->serialize(message.get(), bytes), bytes.size());
    const auto copy = type->create();
    ASSERT_TRUE(type->deserialize(bytes, copy.get()));
    std::vector<std::byte> again(type->serialized_size(copy.get()));
    ASSERT_EQ(type->serialize(copy.get(), again), again.size());
    EXPECT_EQ(again, bytes);
  }
}

TEST(MessageTypeTest, ATooSmallBufferIsRefused) {
  for (const MessageType* type : message_types()) {
    SCOPED_TRACE(type->name);
    const auto message = type->create();
    std::vector<std::byte> bytes(type->serialized_size(message.get()));
    for (std::size_t size = 0; size < bytes.size(); ++size) {
      ASSERT_EQ(type->serialize(message.get(), std::span(bytes).first(size)), 0u) << size;
    }
  }
}

}  // namespace
}  // namespace pipescout
