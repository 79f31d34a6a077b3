// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <geometry_msgs/msg/pose_with_covariance_stamped.hpp>
#include <geometry_msgs/msg/twist_stamped.hpp>
#include <geometry_msgs/msg/twist_with_covariance_stamped.hpp>
#include <memory>
#include <nav_msgs/msg/odometry.hpp>
#include <numbers>
#include <optional>
#include <sensor_msgs/msg/fluid_pressure.hpp>
#include <sensor_msgs/msg/imu.hpp>
#include <sensor_msgs/msg/joint_state.hpp>
#include <sensor_msgs/msg/magnetic_field.hpp>
#include <sensor_msgs/msg/nav_sat_fix.hpp>
#include <sensor_msgs/msg/range.hpp>
#include <set>
#include <tf2_msgs/msg/tf_message.hpp>
#include <utility>

#include "pipescout/bags/bag_error.hpp"
#include "pipescout/bags/bag_reader.hpp"
#include "pipescout/command_line/formatted.hpp"
#include "pipescout/idl/message_type.hpp"
#include "pipescout/message_conversions/geometry.hpp"
#include "pipescout/statistics/median.hpp"
#include "recording.hpp"

namespace pipescout::estimate {
namespace {

using command_line::formatted;
using statistics::median;

constexpr std::uint64_t kMessagesPerReport = 5000;
/// Stamps of one clock differ by less from the times of recording, relative to other topics.
constexpr double kOtherClock = 2;  // s
/// Between two messages on /tf, m and rad: more than rounding.
constexpr double kMoves = 1e-3;
constexpr double kLeastWay = 1;  // m, of poses that move

/// A recorder that is late writes what waits in its queue faster than it was measured; no queue
/// holds as much, and none turns messages round.
constexpr double kLongestQueue = 60;  // s

double seconds(std::int64_t nanoseconds) {
  return static_cast<double>(nanoseconds) * 1e-9;
}

std::string without_slash(const std::string& frame) {
  return frame.starts_with('/') ? frame.substr(1) : frame;
}

/// Times of the messages of one topic that have been read so far.
struct Clock {
  std::vector<double> delays;  // s, recording minus stamp
  // Where the stamps jump, they go on as the times of recording do.
  double moved = 0;  // s, added to the stamps
  double stamp = 0;  // s, of the newest message, as it is; 0: none
  double recorded = 0;
  std::size_t jumps = 0;
  double first_jump = 0;  // s
};

/// A pose of nav_msgs/Odometry, in the plane.
struct PlanarPose {
  double time = 0;
  Eigen::Vector2d position = Eigen::Vector2d::Zero();
  double yaw = 0;
};

struct Topic {
  bags::BagTopic of;
  const MessageType* type = nullptr;
  std::shared_ptr<void> message;
  std::optional<Kind> kind;
  bool transforms = false;
  bool further = false;          // its messages are kept for a further source
  std::set<std::string> joints;  // of sensor_msgs/JointState
  std::optional<estimation::WheelDrive> wheels;
  Stream stream;
  std::vector<PlanarPose> poses;
  Clock clock;
  std::size_t undecoded = 0;
};

constexpr const char* kJointState = "sensor_msgs/msg/JointState";
constexpr const char* kPose = "geometry_msgs/msg/PoseWithCovarianceStamped";

std::optional<Kind> kind_of(const std::string& type) {
  if (type == "sensor_msgs/msg/Imu") {
    return Kind::kImu;
  }
  if (type == "sensor_msgs/msg/NavSatFix") {
    return Kind::kGps;
  }
  if (type == "nav_msgs/msg/Odometry" || type == "geometry_msgs/msg/TwistStamped" ||
      type == "geometry_msgs/msg/TwistWithCovarianceStamped" || type == kJointState) {
    return Kind::kOdometer;
  }
  if (type == "sensor_msgs/msg/MagneticField" || type == "sensor_msgs/msg/FluidPressure" ||
      type == "sensor_msgs/msg/Range" || type == kPose) {
    return Kind::kFurther;
  }
  return std::nullopt;
}

template <class T>
const T& as(const Topic& topic) {
  return *static_cast<const T*>(topic.message.get());
}

std::int64_t stamp_of(const std_msgs::msg::Header& header) {
  return static_cast<std::int64_t>(header.stamp.sec) * 1'000'000'000 +
         static_cast<std::int64_t>(header.stamp.nanosec);
}

/// The stamp; of a message without one, the time of its recording. Noted once for each message.
double time_of(Topic& topic, const std_msgs::msg::Header& header, std::int64_t log_time) {
  const std::int64_t stamp = stamp_of(header);
  if (topic.stream.frame.empty()) {
    topic.stream.frame = without_slash(header.frame_id);
  }
  if (stamp == 0) {
    ++topic.stream.faults["header.stamp is zero; the time of recording is used"];
    return seconds(log_time);
  }
  Clock& clock = topic.clock;
  if (clock.stamp > 0) {
    const double step = seconds(stamp) - clock.stamp;
    const double jump = step - (seconds(log_time) - clock.recorded);
    if ((step < 0 && jump < -kOtherClock) || jump > kLongestQueue) {
      clock.moved -= jump;
      clock.first_jump = clock.jumps++ == 0 ? jump : clock.first_jump;
    }
  }
  clock.stamp = seconds(stamp);
  clock.recorded = seconds(log_time);
  clock.delays.push_back(seconds(log_time - stamp) - clock.moved);
  return seconds(stamp) + clock.moved;
}

void take_imu(Topic& topic, std::int64_t log_time) {
  const auto& m = as<sensor_msgs::msg::Imu>(topic);
  const double time = time_of(topic, m.header, log_time);
  const auto& f = m.linear_acceleration;
  const auto& w = m.angular_velocity;
  if (m.angular_velocity_covariance[0] == -1 || m.linear_acceleration_covariance[0] == -1) {
    ++topic.stream.faults
          ["angular_velocity or linear_acceleration is not measured (covariance -1); "
           "not used"];
    return;
  }
  add_imu(topic.stream, {.time = time, .force = {f.x, f.y, f.z}, .rate = {w.x, w.y, w.z}});
}

void take_fix(Topic& topic, std::int64_t log_time) {
  const auto& m = as<sensor_msgs::msg::NavSatFix>(topic);
  const double time = time_of(topic, m.header, log_time);
  if (m.status.status < 0) {
    ++topic.stream.faults["status is 'no fix'; not used"];
    return;
  }
  GpsRow row{.time = time, .place = {m.latitude, m.longitude, m.altitude}};
  if (m.position_covariance_type != sensor_msgs::msg::NavSatFix::COVARIANCE_TYPE_UNKNOWN) {
    row.covariance = Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>(
        m.position_covariance.data());
  }
  add_gps(topic.stream, std::move(row));
}

void take_twist(Topic& topic, double time, const geometry_msgs::msg::Twist& twist) {
  add_odometer(topic.stream, {.time = time, .speed = twist.linear.x, .yaw_rate = twist.angular.z});
}

void take_joints(Topic& topic, std::int64_t log_time) {
  const auto& m = as<sensor_msgs::msg::JointState>(topic);
  topic.joints.insert(m.name.begin(), m.name.end());
  const double time = time_of(topic, m.header, log_time);
  if (!topic.wheels) {
    return;
  }
  try {
    if (const auto motion = topic.wheels->add(time, m.name, m.position, m.velocity)) {
      add_odometer(topic.stream,
                   {.time = motion->time, .speed = motion->speed, .yaw_rate = motion->yaw_rate});
    }
  } catch (const std::invalid_argument&) {
    ++topic.stream.faults
          ["a wheel's velocity and position are missing, not finite or of no later "
           "stamp; not used"];
  }
}

/// What a topic of joints is good for, where that is not known yet.
std::string about_joints(const Topic& topic) {
  std::string all;
  std::string left;
  std::string right;
  for (const std::string& name : topic.joints) {
    all += (all.empty() ? "" : ", ") + name;
    if (name.find("wheel") != std::string::npos) {
      std::string& side = name.find("left") != std::string::npos ? left : right;
      side += (side.empty() ? "" : ", ") + name;
    }
  }
  std::string text = topic.of.name + ": joints " + all +
                     ". Not used; if some are driven wheels, name them, their radius and track, m, "
                     "in the configuration";
  if (!left.empty() && !right.empty()) {
    text += ": 'odometer: {wheels: {left: [" + left + "], right: [" + right +
            "], radius: ..., track: ...}}'";
  }
  return text + ".";
}

void take_odometer(Topic& topic, std::int64_t log_time) {
  if (topic.of.type == kJointState) {
    take_joints(topic, log_time);
    return;
  }
  if (topic.of.type == "nav_msgs/msg/Odometry") {
    const auto& m = as<nav_msgs::msg::Odometry>(topic);
    if (topic.stream.frame.empty()) {
      topic.stream.frame = without_slash(m.child_frame_id);
    }
    const double time = time_of(topic, m.header, log_time);
    take_twist(topic, time, m.twist.twist);
    const auto& p = m.pose.pose.position;
    const auto& q = m.pose.pose.orientation;
    const double yaw = std::atan2(2 * (q.w * q.z + q.x * q.y), 1 - 2 * (q.y * q.y + q.z * q.z));
    if (std::isfinite(p.x + p.y + yaw)) {
      topic.poses.push_back({time, {p.x, p.y}, yaw});
    }
  } else if (topic.of.type == "geometry_msgs/msg/TwistStamped") {
    const auto& m = as<geometry_msgs::msg::TwistStamped>(topic);
    take_twist(topic, time_of(topic, m.header, log_time), m.twist);
  } else {
    const auto& m = as<geometry_msgs::msg::TwistWithCovarianceStamped>(topic);
    take_twist(topic, time_of(topic, m.header, log_time), m.twist.twist);
  }
}

template <class Message>
void keep(Topic& topic, std::int64_t log_time) {
  const auto& m = as<Message>(topic);
  const std::int64_t stamp = stamp_of(m.header);
  const double time = topic.kind == Kind::kFurther ? time_of(topic, m.header, log_time)
                      : stamp == 0                 ? seconds(log_time)
                                                   : seconds(stamp) + topic.clock.moved;
  add_further(topic.stream, time, m);
}

void take_further(Topic& topic, std::int64_t log_time) {
  const std::string& type = topic.of.type;
  if (type == "sensor_msgs/msg/MagneticField") {
    keep<sensor_msgs::msg::MagneticField>(topic, log_time);
  } else if (type == "sensor_msgs/msg/FluidPressure") {
    keep<sensor_msgs::msg::FluidPressure>(topic, log_time);
  } else if (type == "sensor_msgs/msg/Range") {
    keep<sensor_msgs::msg::Range>(topic, log_time);
  } else if (type == "sensor_msgs/msg/NavSatFix") {
    keep<sensor_msgs::msg::NavSatFix>(topic, log_time);
  } else if (type == "nav_msgs/msg/Odometry") {
    keep<nav_msgs::msg::Odometry>(topic, log_time);
  } else if (type == "geometry_msgs/msg/TwistStamped") {
    keep<geometry_msgs::msg::TwistStamped>(topic, log_time);
  } else if (type == "geometry_msgs/msg/TwistWithCovarianceStamped") {
    keep<geometry_msgs::msg::TwistWithCovarianceStamped>(topic, log_time);
  } else if (type == kPose) {
    keep<geometry_msgs::msg::PoseWithCovarianceStamped>(topic, log_time);
  } else if (type == kJointState) {
    keep<sensor_msgs::msg::JointState>(topic, log_time);
  }
}

/// Of both /tf_static and /tf, where robots of ROS 1 repeat their fixed transforms: frames that
/// move are noted.
void take_transforms(const Topic& topic, Recording& recording, std::set<std::string>& moving) {
  for (const auto& each : as<tf2_msgs::msg::TFMessage>(topic).transforms) {
    const auto& q = each.transform.rotation;
    const double norm = std::sqrt(q.x * q.x + q.y * q.y + q.z * q.z + q.w * q.w);
    const std::string child = without_slash(each.child_frame_id);
    if (!(std::abs(norm - 1) < 0.1)) {
      recording.remarks.push_back(topic.of.name + ": the rotation of frame " + child +
                                  " is no unit quaternion; not used.");
      continue;
    }
    const Mount mount{.parent = without_slash(each.header.frame_id),
                      .T_parent_child = from_message(each.transform)};
    const auto [known, is_new] = recording.mounts.try_emplace(child, mount);
    const geometry::SE3 change = known->second.T_parent_child.inverse() * mount.T_parent_child;
    if (!is_new && (known->second.parent != mount.parent || change.log().norm() > kMoves)) {
      moving.insert(child);
    }
  }
}

/// Some odometries, of lidars and cameras, leave the twist empty: it then comes from the poses.
void differentiate_poses(Topic& topic, std::vector<std::string>& remarks) {
  const auto& poses = topic.poses;
  const bool empty = std::ranges::all_of(topic.stream.odometer, [](const OdometerRow& row) {
    return row.speed == 0 && row.yaw_rate.value_or(0) == 0;
  });
  double way = 0;
  for (std::size_t i = 1; i < poses.size(); ++i) {
    way += (poses[i].position - poses[i - 1].position).norm();
  }
  if (!empty || way < kLeastWay) {
    return;
  }
  topic.stream.odometer.clear();
  for (std::size_t i = 1; i < poses.size(); ++i) {
    const PlanarPose& a = poses[i - 1];
    const PlanarPose& b = poses[i];
    const double step = b.time - a.time;
    if (!(step > 0)) {
      continue;
    }
    const double turn = std::remainder(b.yaw - a.yaw, 2 * std::numbers::pi);
    const double yaw = a.yaw + turn / 2;
    const Eigen::Vector2d forwards(std::cos(yaw), std::sin(yaw));
    // The mean over the step holds in its middle.
    add_odometer(topic.stream, {.time = a.time + step / 2,
                                .speed = forwards.dot(b.position - a.position) / step,
                                .yaw_rate = turn / step});
  }
  remarks.push_back(topic.of.name +
                    ": twist is zero in all messages; speed and yaw rate are those of the poses.");
}

/// Moves the topics whose stamps are of another clock than those of most topics onto that clock.
void reconcile_clocks(std::vector<Topic>& topics, std::vector<std::string>& remarks) {
  std::vector<double> delays;
  for (const Topic& topic : topics) {
    if (!topic.clock.delays.empty()) {
      delays.push_back(median(topic.clock.delays));
    }
  }
  if (delays.empty()) {
    return;
  }
  // Of most topics, by the smallest sum of distances; of two, the one nearer to the recording's.
  const double common = *std::ranges::min_element(delays, {}, [&](double d) {
    std::size_t others = 0;
    for (const double other : delays) {
      others += std::abs(other - d) > kOtherClock ? 1 : 0;
    }
    return std::pair(others, std::abs(d));
  });
  for (Topic& topic : topics) {
    if (topic.clock.delays.empty()) {
      continue;
    }
    const double offset = median(topic.clock.delays) - common;
    if (std::abs(offset) <= kOtherClock) {
      continue;
    }
    remarks.push_back(topic.of.name + ": header.stamp is of another clock, " +
                      formatted("%.3f s %s", std::abs(offset), offset > 0 ? "behind" : "ahead") +
                      " the other topics; it was moved by that, from the times of recording.");
    topic.stream.shift(offset);
  }
}

void take(Topic& topic, std::int64_t log_time, Recording& recording,
          std::set<std::string>& moving) {
  if (topic.transforms) {
    take_transforms(topic, recording, moving);
    return;
  }
  switch (*topic.kind) {
    case Kind::kImu:
      take_imu(topic, log_time);
      break;
    case Kind::kGps:
      take_fix(topic, log_time);
      break;
    case Kind::kOdometer:
      take_odometer(topic, log_time);
      break;
    case Kind::kFurther:
      break;
  }
  if (topic.further) {
    take_further(topic, log_time);
  }
}

}  // namespace

Recording read_bag(const std::filesystem::path& bag,
                   const std::optional<estimation::WheelDriveParameters>& wheels,
                   const std::vector<NamedSource>& further, const Progress& progress) {
  bags::BagReader reader(bag);
  Recording recording;
  std::vector<Topic> topics;
  for (const bags::BagTopic& each : reader.topics()) {
    Topic topic{.of = each};
    if (each.serialization_format != "cdr") {
      recording.remarks.push_back(each.name + ": messages in the encoding '" +
                                  each.serialization_format + "' are not read.");
      topics.push_back(std::move(topic));
      continue;
    }
    topic.type = find_message_type(each.type);
    // The same fields as in tf2_msgs.
    const bool old_transforms = each.type == "tf/msg/tfMessage";
    topic.transforms = (each.type == "tf2_msgs/msg/TFMessage" || old_transforms) &&
                       (each.name.ends_with("tf_static") || each.name.ends_with("/tf"));
    if (topic.transforms && old_transforms && topic.type == nullptr) {
      topic.type = find_message_type("tf2_msgs/msg/TFMessage");
    }
    topic.kind = kind_of(each.type);
    if (wheels && each.type == kJointState) {
      topic.wheels.emplace(*wheels);
    }
    topic.further =
        std::ranges::find(further, each.name, &NamedSource::topic) != further.end() && topic.kind;
    const bool used =
        topic.further || topic.transforms || (topic.kind && *topic.kind != Kind::kFurther);
    if (topic.type != nullptr && used) {
      topic.message = topic.type->create();
    }
    if (topic.kind) {
      topic.stream.kind = *topic.kind;
      topic.stream.name = each.name;
      topic.stream.type = each.type;
      topic.stream.message_type = each.type;
    } else if (!topic.transforms) {
      recording.remarks.push_back(each.name + ": messages of type " + each.type +
                                  " are not used by the estimator.");
    }
    topics.push_back(std::move(topic));
  }
  const double expected = static_cast<double>(reader.metadata().messages);
  std::uint64_t read = 0;
  std::set<std::string> moving;
  try {
    while (const auto message = reader.next()) {
      if (++read % kMessagesPerReport == 0 && expected > 0) {
        progress("reading " + bag.string(), std::min(1.0, static_cast<double>(read) / expected));
      }
      Topic& topic = topics.at(message->topic);
      if (!topic.message) {
        continue;
      }
      if (!topic.type->deserialize(message->data, topic.message.get())) {
        ++topic.undecoded;
        continue;
      }
      take(topic, message->log_time, recording, moving);
    }
  } catch (const bags::BagError& error) {
    recording.remarks.push_back(std::string("The bag cannot be read to its end: ") + error.what() +
                                ". What was read before is used.");
  }
  for (const std::string& frame : moving) {
    recording.mounts.erase(frame);
  }
  for (Topic& topic : topics) {
    differentiate_poses(topic, recording.remarks);
  }
  reconcile_clocks(topics, recording.remarks);
  for (Topic& topic : topics) {
    if (topic.clock.jumps > 0) {
      recording.remarks.push_back(
          topic.of.name +
          formatted(": header.stamp jumps %s%.1f s, as of a clock that was set; from there on the "
                    "stamps go on as the times of recording do.",
                    topic.clock.jumps == 1
                        ? "by "
                        : formatted("%zu times, first by ", topic.clock.jumps).c_str(),
                    topic.clock.first_jump));
    }
    if (topic.undecoded > 0) {
      recording.remarks.push_back(topic.of.name + ": " + std::to_string(topic.undecoded) +
                                  " messages are no " + topic.of.type + "; not used.");
    }
    const bool any_wheel = topic.wheels && topic.stream.rows() > 0;
    if (topic.of.type == kJointState && !any_wheel && !topic.further) {
      recording.remarks.push_back(about_joints(topic));
    } else if (topic.kind == Kind::kFurther && !topic.further) {
      recording.remarks.push_back(about_further(topic.of.name, topic.of.type));
    } else if (topic.kind) {
      recording.streams.push_back(std::move(topic.stream));
    }
  }
  finish(recording);
  return recording;
}

}  // namespace pipescout::estimate
