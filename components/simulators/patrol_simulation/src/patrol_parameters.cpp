// SPDX-License-Identifier: Apache-2.0
#include "pipescout/patrol_simulation/patrol_parameters.hpp"

#include <array>
#include <cmath>
#include <stdexcept>
#include <utility>

#include "pipescout/manipulation/arm_controller.hpp"
#include "pipescout/message_conversions/mounting_parameters.hpp"

namespace pipescout {
namespace {

using simulation::RoadClass;
using simulation::ThermalDecoy;
using simulation::ThermalDecoyKind;

constexpr double kRunIn = 14;   // m, to get to speed before the row
constexpr double kRunOut = 15;  // m
constexpr std::size_t kLeakValues = 3;
constexpr const char* kBaseLink = "base_link";

constexpr std::array kRoads{std::pair{"A", RoadClass::kA}, std::pair{"B", RoadClass::kB},
                            std::pair{"C", RoadClass::kC}, std::pair{"D", RoadClass::kD},
                            std::pair{"E", RoadClass::kE}};

void check_count(const std::string& parameter, const std::vector<double>& values,
                 std::size_t wanted) {
  if (values.size() != wanted) {
    throw std::invalid_argument("parameter '" + parameter + "' has " +
                                std::to_string(values.size()) + " values: must be " +
                                std::to_string(wanted));
  }
}

RoadClass road_of(const std::string& name) {
  for (const auto& [known, road] : kRoads) {
    if (name == known) {
      return road;
    }
  }
  throw std::invalid_argument("parameter 'terrain': '" + name + "' is not one of A, B, C, D, E");
}

/// One of its kind, as such things are.
ThermalDecoy typical(ThermalDecoyKind kind, double place) {
  ThermalDecoy decoy{.kind = kind, .place = place};
  switch (kind) {
    case ThermalDecoyKind::kBrightJoint:
      decoy.size = 0.16;
      decoy.rise = 120;
      break;
    case ThermalDecoyKind::kPassingReflection:
      decoy.size = 0.4;
      decoy.rise = 140;
      decoy.reach = 5;
      decoy.follow = 0.7;
      break;
    case ThermalDecoyKind::kHotPixels:
      decoy.size = 2;
      decoy.rise = 150;
      break;
    case ThermalDecoyKind::kWarmSupport:
      decoy.size = 0.2;
      decoy.rise = 90;
      break;
    case ThermalDecoyKind::kSunGlint:
      decoy.size = 0.3;
      decoy.rise = 600;
      decoy.reach = 0.6;
      decoy.follow = 1;
      break;
    case ThermalDecoyKind::kHotBody:
      decoy.size = 1.2;
      decoy.rise = 80;
      decoy.behind = 4;
      decoy.height = 1.5;
      decoy.foot = 0.5;
      break;
  }
  return decoy;
}

}  // namespace

PatrolParameters::PatrolParameters(Parameters& parameters) : plant_(parameters) {
  seed_ = parameters.declare<std::int64_t>(
      "seed", 1,
      {.description = "seed of all random numbers; the same seed gives the same run",
       .integer_range = IntegerRange{0, 1'000'000'000}});
  declare_row(parameters);
  declare_robot(parameters);
  declare_camera(parameters);
  declare_arm(parameters);
}

void PatrolParameters::declare_row(Parameters& parameters) {
  const simulation::ThermalSceneParameters scene;
  row_position_ = parameters.declare<std::vector<double>>(
      "row.position", {0.0, 10.0, 0.0},
      {.description = "m, x y z in the map of the ground below the beginning of the tube"});
  row_yaw_ =
      parameters.declare<double>("row.yaw", 0.0,
                                 {.description = "rad: direction of the tube, from map x towards "
                                                 "map y; the robot passes on its right side",
                                  .floating_point_range = FloatingPointRange{-7.0, 7.0}});
  length_ = parameters.declare<double>(
      "row.length", scene.length,
      {.description = "m, of the tube", .floating_point_range = FloatingPointRange{1.0, 5000.0}});
  tube_height_ =
      parameters.declare<double>("row.tube_height", scene.tube_height,
                                 {.description = "m, of the tube above the ground",
                                  .floating_point_range = FloatingPointRange{0.5, 10.0}});
  tube_temperature_ = parameters.declare<double>(
      "row.tube_temperature", scene.tube_temperature,
      {.description = "degrees Celsius", .floating_point_range = FloatingPointRange{20.0, 500.0}});
  leaks_ = parameters.declare<std::vector<double>>(
      "leaks", {40.0, 0.3, 80.0, 90.0, 1.5, 160.0},
      {.description =
           "position, length and temperature rise of each leak in turn: m along the tube, m, K"});
  const auto decoys = [&parameters](const char* name, const char* description) {
    return parameters.declare<std::vector<double>>(name, {}, {.description = description});
  };
  bright_joints_ = decoys("decoys.bright_joints",
                          "m along the tube: the joints nearest to these positions are bright");
  reflections_ =
      decoys("decoys.reflections", "m along the tube, of reflections that move with the robot");
  warm_supports_ = decoys("decoys.warm_supports", "m along the tube, of warm posts in front of it");
  sun_glints_ = decoys("decoys.sun_glints", "m along the tube, of short and bright reflections");
  hot_bodies_ = decoys("decoys.hot_bodies", "m along the tube, of warm bodies behind it");
}

void PatrolParameters::declare_robot(Parameters& parameters) {
  const simulation::ThermalPatrolParameters patrol;
  terrain_ = parameters.declare<std::string>(
      "terrain", "C", {.description = "class of the ground's roughness by ISO 8608, A to E"});
  speed_ = parameters.declare<double>(
      "speed", patrol.speed,
      {.description = "m/s, of the robot", .floating_point_range = FloatingPointRange{0.1, 20.0}});
  distance_ =
      parameters.declare<double>("distance", patrol.distance,
                                 {.description = "m, horizontal distance of its path from the tube",
                                  .floating_point_range = FloatingPointRange{1.0, 100.0}});
  standing_ = parameters.declare<double>("standing", 5.0,
                                         {.description = "s of standstill before the start",
                                          .floating_point_range = FloatingPointRange{0.0, 1000.0}});
  imu_ = parameters.declare<std::string>(
      "imu", "industrial",
      {.description = "errors of the IMU at base_link: tactical, industrial or consumer"});
  imu_rate_ = parameters.declare<double>("imu_rate", 250.0,
                                         {.description = "Hz; the period is rounded to 2 ms",
                                          .floating_point_range = FloatingPointRange{10.0, 500.0}});
  gps_rate_ = parameters.declare<double>(
      "gps.rate", 5.0,
      {.description = "Hz", .floating_point_range = FloatingPointRange{0.1, 50.0}});
  gps_deviation_ = parameters.declare<double>(
      "gps.deviation", 0.05,
      {.description = "m, standard deviation of fixes per horizontal axis, half of the variance "
                      "correlated over 30 s; twice that vertically",
       .floating_point_range = FloatingPointRange{0.001, 50.0}});
  datum_ = parameters.declare<std::vector<double>>(
      "datum", {36.66, -5.83, 60.0},
      {.description = "latitude, longitude (degrees) and height (m) of the map's origin"});
}

void PatrolParameters::declare_camera(Parameters& parameters) {
  const auto camera = simulation::ThermalCameraParameters::qvga();
  image_rate_ =
      parameters.declare<double>("image_rate", 25.0,
                                 {.description = "Hz; the period is rounded to 2 ms",
                                  .floating_point_range = FloatingPointRange{0.5, 200.0}});
  encoding_ = parameters.declare<std::string>(
      "camera.encoding", "mono16",
      {.description = "mono16: counts of the sensor; mono8: grey levels of camera.grey_range"});
  grey_range_ = parameters.declare<std::vector<double>>(
      "camera.grey_range", {100.0, 300.0},
      {.description = "degrees Celsius, of black and white in mono8"});
  width_ =
      parameters.declare<int>("camera.width", camera.camera.width,
                              {.description = "pixels", .integer_range = IntegerRange{16, 2048}});
  height_ =
      parameters.declare<int>("camera.height", camera.camera.height,
                              {.description = "pixels", .integer_range = IntegerRange{16, 2048}});
  focal_length_ = parameters.declare<double>(
      "camera.focal_length", 0.0, {.description = "pixels; 0: the image is 25 degrees wide"});
  camera_position_ = parameters.declare<std::vector<double>>(
      "camera.position", {0.2, 0.2, 1.2}, {.description = "m, x y z of the camera in base_link"});
  camera_roll_pitch_yaw_ = parameters.declare<std::vector<double>>(
      "camera.roll_pitch_yaw", {},
      {.description =
           "rad, of the optical frame in base_link; empty: to the left, towards the tube"});
  netd_ = parameters.declare<double>("camera.netd", camera.netd,
                                     {.description = "K, noise of a black body at 30 degC",
                                      .floating_point_range = FloatingPointRange{0.0, 5.0}});
  exposure_ = parameters.declare<double>("camera.exposure", camera.exposure,
                                         {.description = "s, causes motion blur",
                                          .floating_point_range = FloatingPointRange{0.0, 0.1}});
  dead_share_ = parameters.declare<double>("camera.dead_share", camera.dead_share,
                                           {.description = "share of dead pixels",
                                            .floating_point_range = FloatingPointRange{0.0, 0.2}});
}

void PatrolParameters::declare_arm(Parameters& parameters) {
  const simulation::ArmDynamicsParameters dynamics;
  arm_mounted_ =
      parameters.declare<bool>("arm.mounted", false,
                               {.description = "the camera is mounted on an arm; camera.position "
                                               "and camera.roll_pitch_yaw are not used"});
  arm_urdf_file_ = parameters.declare<std::string>(
      "arm.urdf_file", "",
      {.description =
           "robot description of the arm; empty: the six-joint arm of pipescout_manipulation"});
  arm_camera_frame_ = parameters.declare<std::string>("arm.camera_frame", "camera_optical_frame",
                                                      {.description = "link of the camera"});
  arm_start_ = parameters.declare<std::vector<double>>(
      "arm.start", manipulation::ArmControllerParameters{}.ready,
      {.description = "rad, one per joint: initial position"});
  arm_rate_ = parameters.declare<double>("arm.rate", 100.0,
                                         {.description = "Hz, of joint_states; the period is "
                                                         "rounded to 2 ms",
                                          .floating_point_range = FloatingPointRange{10.0, 500.0}});
  arm_delay_ = parameters.declare<double>("arm.delay", dynamics.delay,
                                          {.description = "s, latency of a command",
                                           .floating_point_range = FloatingPointRange{0.0, 0.5}});
  arm_acceleration_ =
      parameters.declare<double>("arm.largest_acceleration", dynamics.largest_acceleration,
                                 {.description = "rad/s^2, of each joint",
                                  .floating_point_range = FloatingPointRange{0.1, 1000.0}});
}

std::optional<PatrolArmParameters> PatrolParameters::arm() const {
  if (!arm_mounted_.get()) {
    return std::nullopt;
  }
  PatrolArmParameters result;
  result.urdf = arm_urdf_file_.share()->empty() ? std::string(manipulation::camera_arm_urdf())
                                                : file_content(arm_urdf_file_);
  result.base_link = kBaseLink;
  result.camera_link = arm_camera_frame_.get();
  result.start = arm_start_.get();
  result.dynamics.delay = arm_delay_.get();
  result.dynamics.largest_acceleration = arm_acceleration_.get();
  return result;
}

std::vector<simulation::ThermalLeak> PatrolParameters::leaks() const {
  const auto leaks = leaks_.share();
  if (leaks->size() % kLeakValues != 0) {
    throw std::invalid_argument("parameter 'leaks' has " + std::to_string(leaks->size()) +
                                " values: must be a multiple of three");
  }
  std::vector<simulation::ThermalLeak> result;
  for (std::size_t i = 0; i < leaks->size(); i += kLeakValues) {
    result.push_back({.place = (*leaks)[i], .length = (*leaks)[i + 1], .rise = (*leaks)[i + 2]});
  }
  return result;
}

void PatrolParameters::add_decoys(simulation::ThermalSceneParameters& scene) const {
  for (const auto& [kind, places] : {std::pair{ThermalDecoyKind::kBrightJoint, &bright_joints_},
                                     std::pair{ThermalDecoyKind::kPassingReflection, &reflections_},
                                     std::pair{ThermalDecoyKind::kWarmSupport, &warm_supports_},
                                     std::pair{ThermalDecoyKind::kSunGlint, &sun_glints_},
                                     std::pair{ThermalDecoyKind::kHotBody, &hot_bodies_}}) {
    for (const double place : *places->share()) {
      scene.decoys.push_back(typical(kind, place));
    }
  }
}

PatrolDriveParameters PatrolParameters::drive() const {
  PatrolDriveParameters result;
  result.seed = static_cast<std::uint64_t>(seed_.get());
  result.standing = standing_.get();
  result.imu = simulation::ImuParameters::of_grade(imu_.get());
  result.imu.period = 1 / imu_rate_.get();
  result.gps.period = 1 / gps_rate_.get();
  const double part = gps_deviation_.get() / std::sqrt(2.0);
  result.gps.white_deviation = {part, part, 2 * part};
  result.gps.correlated_deviation = result.gps.white_deviation;

  simulation::ThermalPatrolParameters& patrol = result.patrol;
  patrol.seed = result.seed;
  patrol.speed = speed_.get();
  patrol.distance = distance_.get();
  patrol.begin = -kRunIn;
  patrol.end = length_.get() + kRunOut;
  patrol.terrain.roughness = simulation::iso_8608_density(road_of(terrain_.get()));
  patrol.scene.seed = result.seed;
  const auto position = row_position_.share();
  check_count("row.position", *position, 3);
  patrol.scene.T_map_row = {geometry::SO3::about_z(row_yaw_.get()),
                            {(*position)[0], (*position)[1], (*position)[2]}};
  patrol.scene.length = length_.get();
  patrol.scene.tube_height = tube_height_.get();
  patrol.scene.tube_temperature = tube_temperature_.get();
  patrol.scene.object.distance = distance_.get();
  add_decoys(patrol.scene);
  if (plant_.given()) {
    result.plant = plant_.drive(result.seed, patrol.scene.length);
    plant_.lay_out(*result.plant, leaks(), patrol);
  } else {
    patrol.scene.leaks = leaks();
  }
  result.arm = arm();

  simulation::ThermalCameraParameters& camera = patrol.camera;
  camera.seed = result.seed;
  const double focal_length = focal_length_.get();
  camera.camera.focal_length =
      focal_length > 0 ? focal_length
                       : camera.camera.focal_length * width_.get() / camera.camera.width;
  camera.camera.width = width_.get();
  camera.camera.height = height_.get();
  camera.camera.centre_u = (width_.get() - 1) / 2.0;
  camera.camera.centre_v = (height_.get() - 1) / 2.0;
  camera.netd = netd_.get();
  camera.exposure = exposure_.get();
  camera.dead_share = dead_share_.get();
  const auto place = camera_position_.share();
  check_count("camera.position", *place, 3);
  const Eigen::Vector3d at((*place)[0], (*place)[1], (*place)[2]);
  const double above = tube_height_.get() - patrol.robot.ride_height - at.z();
  patrol.T_body_camera =
      camera_roll_pitch_yaw_.share()->empty()
          ? simulation::T_body_side_camera(at, std::atan2(above, patrol.distance - at.y()))
          : camera_mounting(camera_position_, camera_roll_pitch_yaw_);
  return result;
}

geometry::GeodeticPosition PatrolParameters::datum() const {
  const auto values = datum_.share();
  check_count("datum", *values, 3);
  return {.latitude = (*values)[0], .longitude = (*values)[1], .altitude = (*values)[2]};
}

bool PatrolParameters::grey() const {
  const std::string encoding = encoding_.get();
  if (encoding != "mono8" && encoding != "mono16") {
    throw std::invalid_argument("parameter 'camera.encoding': '" + encoding +
                                "' is neither mono16 nor mono8");
  }
  return encoding == "mono8";
}

std::vector<double> PatrolParameters::grey_range() const {
  std::vector<double> range = grey_range_.get();
  check_count("camera.grey_range", range, 2);
  return range;
}

}  // namespace pipescout
