// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <array>
#include <geometry_msgs/msg/pose_stamped.hpp>
#include <geometry_msgs/msg/pose_with_covariance_stamped.hpp>
#include <geometry_msgs/msg/transform_stamped.hpp>
#include <iomanip>
#include <nav_msgs/msg/odometry.hpp>
#include <sstream>
#include <tf2_msgs/msg/tf_message.hpp>
#include <utility>

#include "pipescout/csv/csv_cell.hpp"
#include "topic_export.hpp"

namespace pipescout::bag_command {
namespace {

template <class Header, class Position, class Orientation>
std::string line(const Header& header, const Position& position, const Orientation& orientation) {
  std::ostringstream out;
  out << header.stamp.sec << '.' << std::setfill('0') << std::setw(9) << header.stamp.nanosec;
  for (const double value : {position.x, position.y, position.z, orientation.x, orientation.y,
                             orientation.z, orientation.w}) {
    out << ' ' << format_csv_number(value);
  }
  return out.str();
}

template <class T>
const T& as(MessageView message) {
  return *static_cast<const T*>(message.message);
}

}  // namespace

TrajectoryExport::TrajectoryExport(std::filesystem::path path) : path_(std::move(path)) {}

bool TrajectoryExport::takes(std::string_view type) {
  constexpr std::array<std::string_view, 5> kTypes{
      "nav_msgs/msg/Odometry", "geometry_msgs/msg/PoseStamped",
      "geometry_msgs/msg/PoseWithCovarianceStamped", "geometry_msgs/msg/TransformStamped",
      "tf2_msgs/msg/TFMessage"};
  return std::find(kTypes.begin(), kTypes.end(), type) != kTypes.end();
}

void TrajectoryExport::write(MessageView message) {
  const std::string_view type = message.type->name;
  if (type == "nav_msgs/msg/Odometry") {
    const auto& odometry = as<nav_msgs::msg::Odometry>(message);
    const auto& pose = odometry.pose.pose;
    file("").write(line(odometry.header, pose.position, pose.orientation));
  } else if (type == "geometry_msgs/msg/PoseStamped") {
    const auto& stamped = as<geometry_msgs::msg::PoseStamped>(message);
    file("").write(line(stamped.header, stamped.pose.position, stamped.pose.orientation));
  } else if (type == "geometry_msgs/msg/PoseWithCovarianceStamped") {
    const auto& stamped = as<geometry_msgs::msg::PoseWithCovarianceStamped>(message);
    const auto& pose = stamped.pose.pose;
    file("").write(line(stamped.header, pose.position, pose.orientation));
  } else if (type == "geometry_msgs/msg/TransformStamped") {
    write_transform(message.message);
  } else {
    for (const auto& transform : as<tf2_msgs::msg::TFMessage>(message).transforms) {
      write_transform(&transform);
    }
  }
}

void TrajectoryExport::write_transform(const void* transform) {
  const auto& stamped = *static_cast<const geometry_msgs::msg::TransformStamped*>(transform);
  file(stamped.child_frame_id)
      .write(line(stamped.header, stamped.transform.translation, stamped.transform.rotation));
}

TextFile& TrajectoryExport::file(const std::string& child_frame) {
  auto& known = files_[child_frame];
  if (!known) {
    const std::string frame = child_frame.empty() ? "" : "_" + file_name_of(child_frame);
    known = std::make_unique<TextFile>(path_.string() + frame + ".tum");
  }
  return *known;
}

std::size_t TrajectoryExport::close() {
  for (const auto& [frame, file] : files_) {
    file->close();
  }
  return files_.size();
}

}  // namespace pipescout::bag_command
