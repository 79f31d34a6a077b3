// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "pipescout/runtime/standard_topics.hpp"
#include "pipescout/runtime/topic.hpp"

namespace geometry_msgs::msg {
struct PoseStamped;
struct PoseWithCovarianceStamped;
struct Twist;
struct TwistStamped;
}  // namespace geometry_msgs::msg
namespace nav_msgs::msg {
struct OccupancyGrid;
struct Odometry;
struct Path;
}  // namespace nav_msgs::msg
namespace pipescout_msgs::msg {
struct ArmState;
struct BendDetection;
struct EddyCurrentSamples;
struct EstimatorState;
struct FusedOdometer;
struct LeakDetections;
struct LeakEvent;
struct NavigatorState;
struct OdometerReadings;
struct PipeCoverage;
struct PipePosition;
struct PipeTrack;
struct PipeTrackParticles;
struct RackState;
struct WeldDetection;
}  // namespace pipescout_msgs::msg
namespace sensor_msgs::msg {
struct CameraInfo;
struct Image;
struct Imu;
struct JointState;
struct LaserScan;
struct NavSatFix;
}  // namespace sensor_msgs::msg
namespace std_msgs::msg {
struct String;
}
namespace trajectory_msgs::msg {
struct JointTrajectory;
}

/// The catalogue of this domain's topics with name, type and QoS. Topics common to all nodes are in
/// pipescout/runtime/standard_topics.hpp, which this header includes. The types are only declared
/// here; include the message's own header to use them.
namespace pipescout::topics {

/// What happens once is kept for those that come later, or were out of reach: as many events as a
/// mission has. Welds are the most frequent; of joints of 12 m these are 60 km.
inline constexpr QoS kEvents = QoS::latched(5000);

/// Raw readings of all odometers of a robot, from the driver.
inline constexpr Topic<pipescout_msgs::msg::OdometerReadings> kOdometerReadings{"odometer/readings",
                                                                                QoS::reliable(100)};
/// Fused distance of all odometers that agree.
inline constexpr Topic<pipescout_msgs::msg::FusedOdometer> kOdometerFused{"odometer/fused",
                                                                          QoS::reliable(100)};
/// The signal of an eddy-current probe, from the driver.
inline constexpr Topic<pipescout_msgs::msg::EddyCurrentSamples> kEddyCurrent{"eddy_current",
                                                                             QoS::reliable(100)};
/// Girth welds that the probe has passed. Components that compute with them begin with the welds of
/// their own time, whose other measurements they have; who records or shows them gets the former
/// ones.
inline constexpr Topic<pipescout_msgs::msg::WeldDetection> kWeld{
    .name = "weld", .qos = kEvents, .requested = QoS::reliable(100)};
/// Bends of the pipe that the wheels have passed, from the fusion of odometers; kept like welds.
inline constexpr Topic<pipescout_msgs::msg::BendDetection> kBend{
    .name = "bend", .qos = kEvents, .requested = QoS::reliable(100)};
/// Position of the crawler in the pipe: joint and distance into it.
inline constexpr Topic<pipescout_msgs::msg::PipePosition> kPipePosition{"pipe/position",
                                                                        QoS::reliable(100)};
/// True position, from a simulator. Never published by a robot.
inline constexpr Topic<pipescout_msgs::msg::PipePosition> kTruePipePosition{
    "ground_truth/pipe_position", QoS::reliable(100)};
/// Images of the camera that looks at the rack, 8-bit grey or colour, and its calibration.
inline constexpr Topic<sensor_msgs::msg::Image> kCameraImage{
    .name = "camera/image_raw", .qos = QoS::reliable(5), .requested = QoS::sensor_data(5)};
inline constexpr Topic<sensor_msgs::msg::CameraInfo> kCameraInfo{
    .name = "camera/camera_info", .qos = QoS::reliable(5), .requested = QoS::sensor_data(5)};
/// Pose of the camera in the rack frame. Not published while it is unknown.
inline constexpr Topic<geometry_msgs::msg::PoseWithCovarianceStamped> kRackPose{"rack/pose",
                                                                                QoS::reliable(100)};
/// Quality of the pose and offsets of the pipes. Published for each image.
inline constexpr Topic<pipescout_msgs::msg::RackState> kRackState{"rack/state", QoS::reliable(100)};
/// True pose of the camera, from a simulator. Never published by a robot.
inline constexpr Topic<geometry_msgs::msg::PoseStamped> kTrueRackPose{"ground_truth/rack_pose",
                                                                      QoS::reliable(100)};
/// Prior pose of the camera in the rack frame with its covariance, for initialisation or recovery:
/// from an operator, GPS or the estimator.
inline constexpr Topic<geometry_msgs::msg::PoseWithCovarianceStamped> kRackPoseHint{
    .name = "rack/pose_hint", .qos = QoS::reliable(10), .while_inactive = WhileInactive::kDrop};
/// Commanded velocity of a flying robot, in its levelled body frame.
inline constexpr Topic<geometry_msgs::msg::TwistStamped> kVelocityCommand{
    .name = "cmd_vel_stamped", .qos = QoS::reliable(10), .while_inactive = WhileInactive::kDrop};
/// Images of the thermal camera, `mono16`, and its calibration.
inline constexpr Topic<sensor_msgs::msg::Image> kThermalImage{
    .name = "thermal/image_raw", .qos = QoS::reliable(5), .requested = QoS::sensor_data(5)};
inline constexpr Topic<sensor_msgs::msg::CameraInfo> kThermalCameraInfo{
    .name = "thermal/camera_info", .qos = QoS::reliable(5), .requested = QoS::sensor_data(5)};
/// Pipes and leaks in each of them.
inline constexpr Topic<pipescout_msgs::msg::LeakDetections> kLeakDetections{"leak/detections",
                                                                            QoS::reliable(100)};
/// Leaks that are raised, updated and cleared, from all images. Kept for late joiners.
inline constexpr Topic<pipescout_msgs::msg::LeakEvent> kLeakEvents{"leak/events", kEvents};
/// The true leaks, from a simulator, one message each. Never published by a robot.
inline constexpr Topic<pipescout_msgs::msg::LeakEvent> kTrueLeaks{"ground_truth/leaks", kEvents};
/// The tracked pipe, for each image, and the particles of the filter, for display.
inline constexpr Topic<pipescout_msgs::msg::PipeTrack> kPipeTrack{"track/pipe", QoS::reliable(100)};
inline constexpr Topic<pipescout_msgs::msg::PipeTrackParticles> kPipeTrackParticles{
    "track/particles", QoS::reliable(10)};
/// True position of the pipe in each image, from a simulator. Never published by a robot.
inline constexpr Topic<pipescout_msgs::msg::PipeTrack> kTruePipeTrack{"ground_truth/pipe_track",
                                                                      QoS::reliable(100)};
/// Joints of the camera arm: measured by the driver, and commanded. Only the last command counts.
inline constexpr Topic<sensor_msgs::msg::JointState> kJointStates{
    .name = "joint_states", .qos = QoS::reliable(100), .requested = QoS::sensor_data(100)};
inline constexpr Topic<trajectory_msgs::msg::JointTrajectory> kArmCommand{
    .name = "arm/command", .qos = QoS::reliable(1), .while_inactive = WhileInactive::kDrop};
/// The robot as a URDF text, for those that come later too.
inline constexpr Topic<std_msgs::msg::String> kRobotDescription{"robot_description",
                                                                QoS::latched(1)};
/// State of the camera arm with its reason, in each cycle.
inline constexpr Topic<pipescout_msgs::msg::ArmState> kArmState{"arm/state", QoS::reliable(100)};
/// Angular rate and specific force, from the driver, and the position of the GPS antenna.
inline constexpr Topic<sensor_msgs::msg::Imu> kImu{
    .name = "imu/data", .qos = QoS::reliable(200), .requested = QoS::sensor_data(200)};
inline constexpr Topic<sensor_msgs::msg::NavSatFix> kGpsFix{
    .name = "gps/fix", .qos = QoS::reliable(50), .requested = QoS::sensor_data(20)};
/// State of the robot in the map, from the estimator.
inline constexpr Topic<nav_msgs::msg::Odometry> kOdometryFiltered{"odometry/filtered",
                                                                  QoS::reliable(100)};
/// Factors and sources of that estimate, once per keyframe.
inline constexpr Topic<pipescout_msgs::msg::EstimatorState> kEstimatorState{"estimator/state",
                                                                            QoS::reliable(100)};
/// Initial pose of the robot in the map, from an operator. The name is that of rviz.
inline constexpr Topic<geometry_msgs::msg::PoseWithCovarianceStamped> kInitialPose{
    .name = "initialpose", .qos = QoS::reliable(10), .while_inactive = WhileInactive::kDrop};
/// True pose of the robot in the map, from a simulator. Never published by a robot.
inline constexpr Topic<nav_msgs::msg::Odometry> kTrueOdometry{"ground_truth/odometry",
                                                              QoS::reliable(100)};
/// Distances of a lidar that scans in a plane, from the driver.
inline constexpr Topic<sensor_msgs::msg::LaserScan> kScan{
    .name = "scan", .qos = QoS::reliable(5), .requested = QoS::sensor_data(5)};
/// Occupied cells around the robot that other sensors see, in the map.
inline constexpr Topic<nav_msgs::msg::OccupancyGrid> kLocalCostmap{"local_costmap",
                                                                   QoS::reliable(5)};
/// Where the robot is to go, from an operator. The name is that of rviz.
inline constexpr Topic<geometry_msgs::msg::PoseStamped> kGoalPose{
    .name = "goal_pose", .qos = QoS::reliable(10), .while_inactive = WhileInactive::kDrop};
/// Commanded velocity of a robot on wheels, in each control cycle. Only the last command counts.
inline constexpr Topic<geometry_msgs::msg::Twist> kGroundVelocityCommand{
    .name = "cmd_vel", .qos = QoS::reliable(1), .while_inactive = WhileInactive::kDrop};
/// The path that the robot drives, each time it is planned.
inline constexpr Topic<nav_msgs::msg::Path> kPlan{"plan", QoS::latched(1)};
/// What the navigator does and why, in each control cycle.
inline constexpr Topic<pipescout_msgs::msg::NavigatorState> kNavigatorState{"navigator/state",
                                                                            QoS::reliable(100)};
/// What the navigator takes for free and occupied around the robot, for display.
inline constexpr Topic<nav_msgs::msg::OccupancyGrid> kNavigatorCostmap{"navigator/costmap",
                                                                       QoS::reliable(5)};
/// What was seen sharp of the row that is being inspected, as it grows.
inline constexpr Topic<pipescout_msgs::msg::PipeCoverage> kPipeCoverage{"navigator/coverage",
                                                                        QoS::reliable(100)};

}  // namespace pipescout::topics
