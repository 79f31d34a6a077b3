// SPDX-License-Identifier: Apache-2.0
// The components of a robot for the tests of a fleet.
#include <algorithm>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <nav_msgs/msg/odometry.hpp>
#include <sensor_msgs/msg/battery_state.hpp>
#include <sensor_msgs/msg/image.hpp>
#include <std_msgs/msg/header.hpp>
#include <string>
#include <utility>

#include "pipescout/catalogue/topics.hpp"
#include "pipescout/runtime/component.hpp"
#include "pipescout/runtime/conversions.hpp"
#include "pipescout/runtime/register_component.hpp"

namespace pipescout_test {

using pipescout::CallbackReturn;
using pipescout::Component;
using pipescout::ComponentOptions;
using pipescout::QoS;

/// Publishes what the components of a robot publish, each message numbered: `state` at the rate
/// `state_rate` (the number is the position x), `finding` at the rate `finding_rate`, kept for late
/// comers (the number is the frame), `battery_state`, and `image` (likewise) at the rate
/// `image_rate`, with `publish_time`, the ns that its publishing took, as a frame.
class FleetRobot : public Component {
 public:
  explicit FleetRobot(ComponentOptions options)
      : Component(std::move(options)),
        state_rate_(parameters().declare<double>(
            "state_rate", 10.0,
            {.description = "states per second, Hz",
             .floating_point_range = pipescout::FloatingPointRange{0.1, 100.0}})),
        state_number_(parameters()
                          .declare<std::uint32_t>(
                              "first_number", 0,
                              {.description = "number of the first state", .read_only = true})
                          .get()),
        finding_rate_(parameters().declare<double>(
            "finding_rate", 1.0,
            {.description = "findings per second, Hz",
             .floating_point_range = pipescout::FloatingPointRange{0.1, 100.0}})),
        image_rate_(parameters().declare<double>(
            "image_rate", 0.0,
            {.description = "images per second, Hz; 0: none",
             .floating_point_range = pipescout::FloatingPointRange{0.0, 100.0}})) {}

 protected:
  CallbackReturn on_configure() override {
    states_ = create_publisher<nav_msgs::msg::Odometry>("state", QoS::reliable(1));
    findings_ = create_publisher<std_msgs::msg::Header>("finding", pipescout::topics::kEvents);
    batteries_ =
        create_publisher<sensor_msgs::msg::BatteryState>("battery_state", QoS::sensor_data(1));
    state_timer_ =
        create_timer(pipescout::from_seconds(1.0 / state_rate_.get()), [this] { publish_state(); });
    finding_timer_ = create_timer(pipescout::from_seconds(1.0 / finding_rate_.get()),
                                  [this] { publish_finding(); });
    if (image_rate_.get() > 0.0) {
      images_ = create_publisher<sensor_msgs::msg::Image>("image", QoS::sensor_data(1));
      publish_times_ = create_publisher<std_msgs::msg::Header>("publish_time", QoS::reliable(10));
      image_timer_ = create_timer(pipescout::from_seconds(1.0 / image_rate_.get()),
                                  [this] { publish_image(); });
    }
    return CallbackReturn::kSuccess;
  }
  CallbackReturn on_cleanup() override {
    state_timer_.reset();
    finding_timer_.reset();
    image_timer_.reset();
    states_ = {};
    findings_ = {};
    batteries_ = {};
    images_ = {};
    publish_times_ = {};
    return CallbackReturn::kSuccess;
  }

 private:
  void publish_state() {
    nav_msgs::msg::Odometry message;
    message.header.stamp = pipescout::to_message(now());
    message.header.frame_id = "odom";
    message.child_frame_id = "base_link";
    message.pose.pose.position.x = static_cast<double>(state_number_++);
    states_.publish(std::move(message));
  }
  void publish_finding() {
    std_msgs::msg::Header message;
    message.stamp = pipescout::to_message(now());
    message.frame_id = std::to_string(finding_number_++);
    findings_.publish(std::move(message));
    sensor_msgs::msg::BatteryState battery;
    battery.percentage = 0.5F;
    batteries_.publish(std::move(battery));
  }
  void publish_image() {
    constexpr std::uint32_t kWidth = 640;
    constexpr std::uint32_t kHeight = 512;
    sensor_msgs::msg::Image message;
    message.header.stamp = pipescout::to_message(now());
    message.header.frame_id = std::to_string(image_number_++);
    message.width = kWidth;
    message.height = kHeight;
    message.encoding = "mono8";
    message.step = kWidth;
    message.data.assign(std::size_t{kWidth} * kHeight, 7);
    const auto begin = pipescout::steady_now();
    images_.publish(std::move(message));
    const std::chrono::nanoseconds took = pipescout::steady_now() - begin;
    std_msgs::msg::Header time;
    time.stamp = pipescout::to_message(now());
    time.frame_id = std::to_string(took.count());
    publish_times_.publish(std::move(time));
  }

  pipescout::Parameter<double> state_rate_;
  std::uint64_t state_number_;
  pipescout::Parameter<double> finding_rate_;
  pipescout::Parameter<double> image_rate_;
  std::uint64_t finding_number_ = 0;
  std::uint64_t image_number_ = 0;
  pipescout::Publisher<nav_msgs::msg::Odometry> states_;
  pipescout::Publisher<std_msgs::msg::Header> findings_;
  pipescout::Publisher<sensor_msgs::msg::BatteryState> batteries_;
  pipescout::Publisher<sensor_msgs::msg::Image> images_;
  pipescout::Publisher<std_msgs::msg::Header> publish_times_;
  std::shared_ptr<pipescout::Timer> state_timer_;
  std::shared_ptr<pipescout::Timer> finding_timer_;
  std::shared_ptr<pipescout::Timer> image_timer_;
};

/// Repeats `state` on `~/state`.
class FleetFollower : public Component {
 public:
  explicit FleetFollower(ComponentOptions options) : Component(std::move(options)) {}

 protected:
  CallbackReturn on_configure() override {
    publisher_ = create_publisher<nav_msgs::msg::Odometry>("~/state", QoS::reliable(1));
    subscription_ = create_subscription<nav_msgs::msg::Odometry>(
        "state", QoS::reliable(1),
        [this](const nav_msgs::msg::Odometry& message) { publisher_.publish(message); });
    return CallbackReturn::kSuccess;
  }
  CallbackReturn on_cleanup() override {
    subscription_ = {};
    publisher_ = {};
    return CallbackReturn::kSuccess;
  }

 private:
  pipescout::Publisher<nav_msgs::msg::Odometry> publisher_;
  pipescout::Subscription<nav_msgs::msg::Odometry> subscription_;
};

}  // namespace pipescout_test

PIPESCOUT_REGISTER_COMPONENT(pipescout_test::FleetRobot)
PIPESCOUT_REGISTER_COMPONENT(pipescout_test::FleetFollower)
