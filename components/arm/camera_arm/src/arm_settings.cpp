// SPDX-License-Identifier: Apache-2.0
#include "pipescout/camera_arm/arm_settings.hpp"

#include <stdexcept>

#include "pipescout/message_conversions/mounting_parameters.hpp"

namespace pipescout {

namespace {

using manipulation::ArmControllerParameters;
using manipulation::Centring;

Centring centring(const Parameter<std::string>& parameter) {
  const std::string name = parameter.get();
  if (name == "always") {
    return Centring::kAlways;
  }
  if (name == "at_edge") {
    return Centring::kAtEdge;
  }
  throw std::invalid_argument("parameter 'centring': '" + name +
                              "' is not one of 'always', 'at_edge'");
}

}  // namespace

ArmParameters::ArmParameters(Parameters& parameters)
    : controller_(parameters, ArmControllerParameters{}) {
  declare_arm(parameters);
  declare_law();
  declare_watch();
  declare_search();
}

void ArmParameters::declare_arm(Parameters& parameters) {
  const ArmControllerParameters defaults;
  urdf_file_ = parameters.declare<std::string>(
      "urdf_file", "",
      {.description =
           "robot description of the arm; empty: the six-joint arm of pipescout_manipulation"});
  const manipulation::ArmModelOptions model;
  mesh_radius_ = parameters.declare<double>(
      "mesh_radius", model.mesh_radius,
      {.description = "m, radius of the links whose collision geometry is a mesh; 0: such "
                      "descriptions are refused",
       .floating_point_range = FloatingPointRange{0, 10}});
  continuous_velocity_ = parameters.declare<double>(
      "continuous_velocity", model.continuous_velocity,
      {.description = "rad/s, largest rate of continuous joints without a velocity limit",
       .floating_point_range = FloatingPointRange{1e-3, 100}});
  base_frame_ = parameters.declare<std::string>("base_frame", "base_link",
                                                {.description = "base link of the arm"});
  camera_frame_ = parameters.declare<std::string>(
      "camera_frame", "camera_optical_frame",
      {.description = "link of the camera, x right and y down in the image, z forward"});
  map_frame_ =
      parameters.declare<std::string>("map_frame", "map", {.description = "frame of the odometry"});
  publish_tf_ = parameters.declare<bool>(
      "publish_tf", true,
      {.description = "publish the pose of the camera in base_frame on /tf for each joint_states"});
  ready_ = parameters.declare<std::vector<double>>(
      "ready", defaults.ready,
      {.description = "rad, one per joint: posture with the camera towards the pipes"});
  stow_ = parameters.declare<std::vector<double>>(
      "stow", defaults.stow, {.description = "rad, one per joint: posture for driving"});
  centring_ = parameters.declare<std::string>(
      "centring", "always",
      {.description =
           "always: keeps the pipe in the middle of the image; at_edge: the arm moves only when "
           "the pipe comes near the border, as in Ibarguren and others, 2013"});
}

void ArmParameters::declare_law() {
  controller_.real(
      "period", [](auto& p) -> double& { return p.period; }, {1e-3, 0.1}, "s, control period");
  controller_.boolean(
      "feed_forward", [](auto& p) -> bool& { return p.feed_forward; },
      "compensate the motion of the robot with its odometry; when false, odometry is not needed");
  controller_.real(
      "move_speed", [](auto& p) -> double& { return p.move_speed; }, {1e-3, 10},
      "rad/s, speed of a joint between ready and stow and in the search");
  controller_.real(
      "rotation_gain", [](auto& p) -> double& { return p.rotation_gain; }, {1e-3, 50},
      "1/s, of the image error");
  controller_.real(
      "position_gain", [](auto& p) -> double& { return p.position_gain; }, {1e-3, 50},
      "1/s, of the position of the camera");
  controller_.real(
      "image_time", [](auto& p) -> double& { return p.image_time; }, {0, 5},
      "s, averaging time of image measurements");
  controller_.real(
      "response_time", [](auto& p) -> double& { return p.response_time; }, {0, 0.5},
      "s, response time of the arm");
  controller_.real(
      "largest_acceleration", [](auto& p) -> double& { return p.largest_acceleration; },
      {1e-3, 200}, "rad/s^2, of each joint");
  controller_.real(
      "damping", [](auto& p) -> double& { return p.damping; }, {0, 1},
      "of least squares, where the arm is singular");
  controller_.real(
      "least_manipulability", [](auto& p) -> double& { return p.least_manipulability; }, {1e-6, 1},
      "below which least squares are damped");
  controller_.real(
      "rotation_weight", [](auto& p) -> double& { return p.rotation_weight; }, {1e-3, 100},
      "m/rad, of errors of rotation against those of position");
  controller_.real(
      "nearest", [](auto& p) -> double& { return p.nearest; }, {1e-3, 1000},
      "m to the pipe; the camera moves back when nearer");
  controller_.real(
      "farthest", [](auto& p) -> double& { return p.farthest; }, {1e-3, 1000},
      "m to the pipe; the camera reaches out when farther");
  controller_.real(
      "usual_range", [](auto& p) -> double& { return p.usual_range; }, {1e-3, 1000},
      "m to the pipe, if the track has no range");
  controller_.real(
      "reach", [](auto& p) -> double& { return p.reach; }, {0, 2},
      "m, largest motion of the camera along the view direction");
  controller_.real(
      "edge_share", [](auto& p) -> double& { return p.edge_share; }, {1e-3, 0.49},
      "share of the image, distance from its border at which at_edge begins to move");
  controller_.real(
      "centred_share", [](auto& p) -> double& { return p.centred_share; }, {1e-3, 0.49},
      "share of the image, distance from its middle at which at_edge stops");
}

void ArmParameters::declare_watch() {
  controller_.real(
      "joints_stale_after", [](auto& p) -> double& { return p.joints_stale_after; }, {1e-3, 10},
      "s without joint_states, after which the arm holds");
  controller_.real(
      "track_stale_after", [](auto& p) -> double& { return p.track_stale_after; }, {1e-3, 10},
      "s without track/pipe, after which the arm holds");
  controller_.real(
      "odometry_stale_after", [](auto& p) -> double& { return p.odometry_stale_after; }, {1e-3, 10},
      "s without odometry/filtered, after which the arm holds, with feed_forward");
  controller_.real(
      "future_tolerance", [](auto& p) -> double& { return p.future_tolerance; }, {0, 1},
      "s, how far a stamp may be ahead of the clock");
  controller_.real(
      "least_clearance", [](auto& p) -> double& { return p.least_clearance; }, {0, 1},
      "m, smallest distance between links, and above the ground");
  controller_.real(
      "ground", [](auto& p) -> double& { return p.ground; }, {-10, 10},
      "m, height of the ground in base_frame");
  controller_.real(
      "largest_following_error", [](auto& p) -> double& { return p.largest_following_error; },
      {1e-3, 3}, "rad, deviation of a joint from its command; a larger one is a fault");
}

void ArmParameters::declare_search() {
  controller_.real(
      "hold_time", [](auto& p) -> double& { return p.hold_time; }, {0, 3600},
      "s at rest after a loss of the pipe, before the search");
  controller_.real(
      "search_time", [](auto& p) -> double& { return p.search_time; }, {0, 3600},
      "s, duration of the search before stowing");
  controller_.real(
      "search_period", [](auto& p) -> double& { return p.search_period; }, {0.5, 60},
      "s of a sweep up and down");
  controller_.real(
      "search_amplitude", [](auto& p) -> double& { return p.search_amplitude; }, {1e-3, 1.5},
      "rad, of the last sweep; the first ones are smaller");
}

ArmSettings ArmParameters::read() const {
  ArmSettings result;
  result.urdf = urdf_file_.share()->empty() ? std::string(manipulation::camera_arm_urdf())
                                            : file_content(urdf_file_);
  result.model.mesh_radius = mesh_radius_.get();
  result.model.continuous_velocity = continuous_velocity_.get();
  result.base_frame = base_frame_.get();
  result.camera_frame = camera_frame_.get();
  result.map_frame = map_frame_.get();
  result.controller = controller_.read();
  result.controller.centring = centring(centring_);
  result.controller.ready = ready_.get();
  result.controller.stow = stow_.get();
  result.publish_tf = publish_tf_.get();
  return result;
}

}  // namespace pipescout
