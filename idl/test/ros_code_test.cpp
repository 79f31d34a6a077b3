// SPDX-License-Identifier: Apache-2.0
// Code as it is written for ROS 2: it compiles here unchanged.
#include <gtest/gtest.h>

#include <chrono>
#include <cmath>
#include <cstring>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "builtin_interfaces/msg/time.hpp"
#include "diagnostic_msgs/msg/diagnostic_array.hpp"
#include "diagnostic_msgs/msg/diagnostic_status.hpp"
#include "diagnostic_msgs/msg/key_value.hpp"
#include "geometry_msgs/msg/pose_stamped.hpp"
#include "geometry_msgs/msg/twist.hpp"
#include "nav_msgs/msg/occupancy_grid.hpp"
#include "nav_msgs/msg/odometry.hpp"
#include "nav_msgs/msg/path.hpp"
#include "nav_msgs/srv/get_map.hpp"
#include "sensor_msgs/msg/camera_info.hpp"
#include "sensor_msgs/msg/image.hpp"
#include "sensor_msgs/msg/imu.hpp"
#include "sensor_msgs/msg/laser_scan.hpp"
#include "sensor_msgs/msg/nav_sat_fix.hpp"
#include "sensor_msgs/msg/point_cloud2.hpp"
#include "std_srvs/srv/trigger.hpp"

namespace {

sensor_msgs::msg::Image::UniquePtr make_image(const builtin_interfaces::msg::Time& stamp) {
  auto msg = std::make_unique<sensor_msgs::msg::Image>();
  msg->header.stamp = stamp;
  msg->header.frame_id = "camera_optical_frame";
  msg->height = 2;
  msg->width = 3;
  msg->encoding = "rgb8";
  msg->is_bigendian = false;
  msg->step = msg->width * 3;
  msg->data.resize(msg->height * msg->step);
  std::memset(&msg->data[0], 127, msg->data.size());
  return msg;
}

TEST(RosCode, FillsAndReadsAnImage) {
  builtin_interfaces::msg::Time now;
  now.sec = 12;
  now.nanosec = 500000000u;
  sensor_msgs::msg::Image::SharedPtr msg = make_image(now);
  const sensor_msgs::msg::Image::ConstSharedPtr& received = msg;
  EXPECT_EQ(received->header.stamp, now);
  EXPECT_EQ(received->data.size(), received->height * received->step);
  EXPECT_EQ(received->data.at(17), 127);
  const double seconds = received->header.stamp.sec + received->header.stamp.nanosec * 1e-9;
  EXPECT_DOUBLE_EQ(seconds, 12.5);
}

TEST(RosCode, FillsACloud) {
  sensor_msgs::msg::PointCloud2 cloud;
  cloud.header.frame_id = "lidar";
  cloud.height = 1;
  cloud.point_step = 12;
  for (const std::string name : {"x", "y", "z"}) {
    sensor_msgs::msg::PointField field;
    field.name = name;
    field.offset = static_cast<uint32_t>(4 * cloud.fields.size());
    field.datatype = sensor_msgs::msg::PointField::FLOAT32;
    field.count = 1;
    cloud.fields.push_back(field);
  }
  cloud.width = 10;
  cloud.row_step = cloud.point_step * cloud.width;
  cloud.data.resize(cloud.row_step * cloud.height);
  EXPECT_EQ(cloud.fields[2].offset, 8u);
}

TEST(RosCode, FillsSensors) {
  sensor_msgs::msg::NavSatFix fix;
  fix.status.status = sensor_msgs::msg::NavSatStatus::STATUS_FIX;
  fix.status.service = sensor_msgs::msg::NavSatStatus::SERVICE_GPS;
  fix.position_covariance.fill(0.0);
  fix.position_covariance[0] = fix.position_covariance[4] = fix.position_covariance[8] = 4.0;
  fix.position_covariance_type = sensor_msgs::msg::NavSatFix::COVARIANCE_TYPE_DIAGONAL_KNOWN;
  EXPECT_EQ(fix.position_covariance_type, 2);

  sensor_msgs::msg::Imu imu;
  imu.orientation_covariance[0] = -1;
  imu.angular_velocity.z = 0.1;
  EXPECT_EQ(imu.orientation.w, 1.0);

  sensor_msgs::msg::LaserScan scan;
  scan.angle_min = -static_cast<float>(M_PI);
  scan.ranges.assign(360, std::numeric_limits<float>::infinity());
  for (const auto& range : scan.ranges) {
    EXPECT_TRUE(std::isinf(range));
  }

  sensor_msgs::msg::CameraInfo info;
  info.distortion_model = "plumb_bob";
  info.d = {0.1, 0.0, 0.0, 0.0, 0.0};
  info.k = {500.0, 0.0, 320.0, 0.0, 500.0, 240.0, 0.0, 0.0, 1.0};
  info.roi.do_rectify = true;
  EXPECT_EQ(info.k[4], 500.0);
}

TEST(RosCode, FillsNavigation) {
  nav_msgs::msg::Odometry odom;
  odom.header.frame_id = "odom";
  odom.child_frame_id = "base_link";
  odom.pose.pose.position.x = 1.0;
  odom.pose.covariance[35] = 0.01;
  geometry_msgs::msg::Twist twist;
  twist.linear.x = 0.5;
  odom.twist.twist = twist;
  EXPECT_EQ(odom.twist.twist.linear.x, 0.5);

  nav_msgs::msg::Path path;
  path.header = odom.header;
  for (int i = 0; i < 3; ++i) {
    geometry_msgs::msg::PoseStamped pose;
    pose.header = path.header;
    pose.pose.position.x = i;
    path.poses.emplace_back(std::move(pose));
  }
  EXPECT_EQ(path.poses.back().pose.position.x, 2.0);
  EXPECT_EQ(path.poses.back().pose.orientation.w, 1.0);

  auto response = std::make_shared<nav_msgs::srv::GetMap::Response>();
  response->map.info.resolution = 0.05f;
  response->map.data.assign(100, -1);
  EXPECT_EQ(response->map.data.front(), -1);
}

TEST(RosCode, FillsDiagnostics) {
  diagnostic_msgs::msg::DiagnosticStatus status;
  status.level = diagnostic_msgs::msg::DiagnosticStatus::WARN;
  status.name = "camera: temperature";
  diagnostic_msgs::msg::KeyValue kv;
  kv.key = "degrees";
  kv.value = "71";
  status.values.push_back(kv);
  diagnostic_msgs::msg::DiagnosticArray array;
  array.status.push_back(status);
  EXPECT_EQ(array.status.at(0).values.front().value, "71");
  EXPECT_EQ(array.status[0].level, 1);
}

/// The signature of a service's callback.
void handle(const std::shared_ptr<std_srvs::srv::Trigger::Request> request,
            std::shared_ptr<std_srvs::srv::Trigger::Response> response) {
  (void)request;
  response->success = true;
  response->message = "done";
}

TEST(RosCode, AnswersAService) {
  const auto request = std::make_shared<std_srvs::srv::Trigger::Request>();
  const auto response = std::make_shared<std_srvs::srv::Trigger::Response>();
  handle(request, response);
  EXPECT_TRUE(response->success);
}

}  // namespace
