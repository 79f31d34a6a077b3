// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <nav_msgs/msg/odometry.hpp>
#include <numbers>
#include <optional>
#include <sensor_msgs/msg/imu.hpp>
#include <sensor_msgs/msg/nav_sat_fix.hpp>
#include <sensor_msgs/msg/nav_sat_status.hpp>
#include <utility>

#include "bag_sections.hpp"
#include "pipescout/statistics/median.hpp"
#include "tables/values.hpp"

namespace pipescout::summary {
namespace {

template <class T>
const T& as(MessageView message) {
  return *static_cast<const T*>(message.message);
}

class OdometrySection final : public SectionMaker {
 public:
  bool takes(const bags::BagTopic& topic) const override {
    return topic.type == "nav_msgs/msg/Odometry";
  }

  void add(const bags::BagTopic& topic, MessageView view) override {
    const auto& message = as<nav_msgs::msg::Odometry>(view);
    Way& way = ways_[topic.name];
    way.frames = message.header.frame_id + " -> " + message.child_frame_id;
    ++way.messages;
    const auto& p = message.pose.pose.position;
    const std::array<double, 3> position{p.x, p.y, p.z};
    const auto& v = message.twist.twist.linear;
    const double speed = std::hypot(v.x, v.y, v.z);
    if (!std::isfinite(p.x + p.y + p.z) || !std::isfinite(speed)) {
      ++way.not_finite;
      return;
    }
    way.fastest = std::max(way.fastest, speed);
    if (!way.last) {
      way.first = position;
    } else {
      way.length += distance(position, *way.last);
    }
    way.last = position;
  }

  void add_to(Sections& sections) override {
    if (ways_.empty()) {
      return;
    }
    MissionSection section;
    section.title = "Odometry";
    section.columns = {"topic",          "frames",        "messages",  "way [m]",
                       "from start [m]", "fastest [m/s]", "not finite"};
    for (const auto& [name, way] : ways_) {
      section.rows.push_back(
          {name, way.frames, count_cell(way.messages), rounded_cell(way.length, 100),
           way.last ? rounded_cell(distance(*way.last, way.first), 100) : MissionCell(),
           rounded_cell(way.fastest, 1000), count_cell(way.not_finite)});
    }
    section.notes.emplace_back(
        "Way: the sum of the steps between positions, so that noise and corrections add to it.");
    sections["odometry"] = std::move(section);
  }

 private:
  using Position = std::array<double, 3>;
  struct Way {
    std::string frames;
    std::uint64_t messages = 0;
    std::uint64_t not_finite = 0;
    Position first{};
    std::optional<Position> last;
    double length = 0.0;   // m
    double fastest = 0.0;  // m/s
  };
  static double distance(const Position& a, const Position& b) {
    return std::hypot(a[0] - b[0], a[1] - b[1], a[2] - b[2]);
  }

  std::map<std::string, Way> ways_;
};

class ImuSection final : public SectionMaker {
 public:
  bool takes(const bags::BagTopic& topic) const override {
    return topic.type == "sensor_msgs/msg/Imu";
  }

  void add(const bags::BagTopic& topic, MessageView view) override {
    const auto& message = as<sensor_msgs::msg::Imu>(view);
    Readings& readings = readings_[topic.name];
    readings.frame = message.header.frame_id;
    ++readings.messages;
    const auto& f = message.linear_acceleration;
    const auto& w = message.angular_velocity;
    const double force = std::hypot(f.x, f.y, f.z);
    const double rate = std::hypot(w.x, w.y, w.z);
    if (!std::isfinite(force) || !std::isfinite(rate)) {
      ++readings.not_finite;
      return;
    }
    if (force == 0.0) {
      ++readings.dead;
    }
    ++readings.used;
    readings.force += force;
    readings.fastest = std::max(readings.fastest, rate);
  }

  void add_to(Sections& sections) override {
    if (readings_.empty()) {
      return;
    }
    MissionSection section;
    section.title = "IMU";
    section.columns = {"topic",
                       "frame",
                       "messages",
                       "mean specific force [m/s^2]",
                       "fastest turn [deg/s]",
                       "force zero",
                       "not finite"};
    for (const auto& [name, readings] : readings_) {
      const double mean = readings.used == 0 ? std::numeric_limits<double>::quiet_NaN()
                                             : readings.force / static_cast<double>(readings.used);
      section.rows.push_back({name, readings.frame, count_cell(readings.messages),
                              rounded_cell(mean, 1000),
                              rounded_cell(readings.fastest * 180.0 / std::numbers::pi, 100),
                              count_cell(readings.dead), count_cell(readings.not_finite)});
      // Between gravity and nothing: neither is what a slow robot's accelerometer reads.
      constexpr double kLeast = 9.0;
      constexpr double kMost = 10.6;
      if (mean < kLeast || mean > kMost) {
        section.notes.push_back(name + ": the mean specific force is not that of gravity (9.8): " +
                                (mean < 1.0 ? "gravity is taken out, or the unit is g."
                                            : "the unit or the scale is another one."));
      }
    }
    sections["imu"] = std::move(section);
  }

 private:
  struct Readings {
    std::string frame;
    std::uint64_t messages = 0;
    std::uint64_t used = 0;
    std::uint64_t dead = 0;
    std::uint64_t not_finite = 0;
    double force = 0.0;    // m/s^2, sum
    double fastest = 0.0;  // rad/s
  };
  std::map<std::string, Readings> readings_;
};

class GpsSection final : public SectionMaker {
 public:
  bool takes(const bags::BagTopic& topic) const override {
    return topic.type == "sensor_msgs/msg/NavSatFix";
  }

  void add(const bags::BagTopic& topic, MessageView view) override {
    using sensor_msgs::msg::NavSatFix;
    const auto& message = as<NavSatFix>(view);
    Fixes& fixes = fixes_[topic.name];
    ++fixes.messages;
    if (message.status.status < sensor_msgs::msg::NavSatStatus::STATUS_FIX ||
        !std::isfinite(message.latitude) || !std::isfinite(message.longitude)) {
      ++fixes.without;
      return;
    }
    if (message.latitude == 0.0 && message.longitude == 0.0) {
      ++fixes.zero;
      return;
    }
    const double variance = message.position_covariance[0];
    if (message.position_covariance_type != NavSatFix::COVARIANCE_TYPE_UNKNOWN &&
        std::isfinite(variance) && variance > 0.0) {
      fixes.deviations.push_back(std::sqrt(variance));
    }
    fixes.south = std::min(fixes.south, message.latitude);
    fixes.north = std::max(fixes.north, message.latitude);
    fixes.west = std::min(fixes.west, message.longitude);
    fixes.east = std::max(fixes.east, message.longitude);
  }

  void add_to(Sections& sections) override {
    if (fixes_.empty()) {
      return;
    }
    MissionSection section;
    section.title = "GPS";
    section.columns = {
        "topic",           "messages",     "without fix", "at 0, 0", "stated deviation [m]",
        "north-south [m]", "east-west [m]"};
    for (const auto& [name, fixes] : fixes_) {
      // Of a degree on the mean sphere: the size of an area needs no better Earth.
      constexpr double kMetresPerDegree = 111'195.0;
      const bool has_area = fixes.north >= fixes.south;
      const double middle = 0.5 * (fixes.north + fixes.south) * std::numbers::pi / 180.0;
      section.rows.push_back(
          {name, count_cell(fixes.messages), count_cell(fixes.without), count_cell(fixes.zero),
           median(fixes),
           has_area ? rounded_cell((fixes.north - fixes.south) * kMetresPerDegree, 10)
                    : MissionCell(),
           has_area
               ? rounded_cell((fixes.east - fixes.west) * kMetresPerDegree * std::cos(middle), 10)
               : MissionCell()});
    }
    section.notes.emplace_back(
        "Stated deviation: of the east, the median of what the receiver says; none: unknown.");
    sections["gps"] = std::move(section);
  }

 private:
  struct Fixes {
    std::uint64_t messages = 0;
    std::uint64_t without = 0;
    std::uint64_t zero = 0;
    std::vector<double> deviations;  // m
    double south = std::numeric_limits<double>::infinity();
    double north = -std::numeric_limits<double>::infinity();
    double west = std::numeric_limits<double>::infinity();
    double east = -std::numeric_limits<double>::infinity();
  };
  static MissionCell median(const Fixes& fixes) {
    if (fixes.deviations.empty()) {
      return {};
    }
    return rounded_cell(statistics::median(fixes.deviations), 1000);
  }

  std::map<std::string, Fixes> fixes_;
};

}  // namespace

std::unique_ptr<SectionMaker> odometry_section() {
  return std::make_unique<OdometrySection>();
}

std::unique_ptr<SectionMaker> imu_section() {
  return std::make_unique<ImuSection>();
}

std::unique_ptr<SectionMaker> gps_section() {
  return std::make_unique<GpsSection>();
}

}  // namespace pipescout::summary
