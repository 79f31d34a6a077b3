// SPDX-License-Identifier: Apache-2.0
// What an operator's program hears of the robots robot_1 to robot_N, N being the first argument.
// Prints a line for each message: the time on the steady clock in s, the robot, the topic, the
// number in the message, and its age in s. Runs until it is stopped.
#include <cstdlib>
#include <iomanip>
#include <iostream>
#include <nav_msgs/msg/odometry.hpp>
#include <sensor_msgs/msg/image.hpp>
#include <std_msgs/msg/header.hpp>
#include <string>
#include <vector>

#include "pipescout/catalogue/topics.hpp"
#include "pipescout/dds/dds_transport.hpp"
#include "pipescout/runtime/conversions.hpp"
#include "pipescout/runtime/executor.hpp"
#include "pipescout/runtime/node.hpp"
#include "pipescout/runtime/stop_signals.hpp"

namespace {

using pipescout::QoS;

class Station {
 public:
  Station(pipescout::Node& node, int robots) : node_(node) {
    for (int robot = 1; robot <= robots; ++robot) {
      const std::string name = "robot_" + std::to_string(robot);
      states_.push_back(node.create_subscription<nav_msgs::msg::Odometry>(
          "/" + name + "/state", QoS::reliable(1),
          [this, name](const nav_msgs::msg::Odometry& message) {
            print(name, "state", std::to_string(static_cast<long>(message.pose.pose.position.x)),
                  message.header.stamp);
          }));
      findings_.push_back(node.create_subscription<std_msgs::msg::Header>(
          "/" + name + "/finding", pipescout::topics::kEvents,
          [this, name](const std_msgs::msg::Header& message) {
            print(name, "finding", message.frame_id, message.stamp);
          }));
      publish_times_.push_back(node.create_subscription<std_msgs::msg::Header>(
          "/" + name + "/publish_time", QoS::reliable(10),
          [this, name](const std_msgs::msg::Header& message) {
            print(name, "publish_time", message.frame_id, message.stamp);
          }));
      images_.push_back(node.create_subscription<sensor_msgs::msg::Image>(
          "/" + name + "/image", QoS::sensor_data(1),
          [this, name](const sensor_msgs::msg::Image& message) {
            print(name, "image", message.header.frame_id, message.header.stamp);
          }));
    }
  }

 private:
  void print(const std::string& robot, const char* topic, const std::string& number,
             const builtin_interfaces::msg::Time& stamp) {
    std::cout << pipescout::to_seconds(pipescout::steady_now().time_since_epoch()) << ' ' << robot
              << ' ' << topic << ' ' << number << ' '
              << pipescout::to_seconds(node_.now() - pipescout::from_message(stamp)) << std::endl;
  }

  pipescout::Node& node_;
  std::vector<pipescout::Subscription<nav_msgs::msg::Odometry>> states_;
  std::vector<pipescout::Subscription<std_msgs::msg::Header>> findings_;
  std::vector<pipescout::Subscription<std_msgs::msg::Header>> publish_times_;
  std::vector<pipescout::Subscription<sensor_msgs::msg::Image>> images_;
};

}  // namespace

int main(int argc, char** argv) {
  if (argc != 2) {
    std::cerr << "fleet_station ROBOTS\n";
    return EXIT_FAILURE;
  }
  pipescout::StopSignals::block();
  pipescout::Executor executor;
  pipescout::StopSignals signals(
      std::chrono::seconds(2), [&](int) { executor.stop(); }, [] {});
  auto options = pipescout::DdsOptions::from_environment();
  options.name = "fleet station";
  const auto context = pipescout::Context::create(pipescout::create_dds_transport(options));
  pipescout::Node node({.context = context, .executor = &executor, .name = {"/", "station"}});
  std::cout << std::fixed << std::setprecision(6);
  const Station station(node, std::atoi(argv[1]));
  executor.spin();
  return EXIT_SUCCESS;
}
