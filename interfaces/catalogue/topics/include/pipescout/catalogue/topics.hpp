// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "pipescout/runtime/standard_topics.hpp"
#include "pipescout/runtime/topic.hpp"

namespace geometry_msgs::msg {
struct PoseStamped;
struct PoseWithCovarianceStamped;
struct TwistStamped;
}  // namespace geometry_msgs::msg
namespace nav_msgs::msg {
struct Odometry;
}
namespace pipescout_msgs::msg {
struct ArmState;
struct EddyCurrentSamples;
struct EstimatorState;
struct FusedOdometer;
struct LeakDetections;
struct LeakEvent;
struct OdometerReadings;
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
struct NavSatFix;
}  // namespace sensor_msgs::msg
namespace std_msgs::msg {
struct String;
}
namespace trajectory_msgs::msg {
struct JointTrajectory;
}

/// The catalogue: the one place where a topic of this domain has its name, type and QoS written
/// down; those of every node are in pipescout/runtime/standard_topics.hpp, which comes with it. The
/// types are only declared here; include the message's own header to use them.
namespace pipescout::topics {

/// Raw readings of all odometers of a robot, from the driver.
inline constexpr Topic<pipescout_msgs::msg::OdometerReadings> kOdometerReadings{"odometer/readings",
                                                                                QoS::reliable(100)};
/// One distance from all odometers that agree.
inline constexpr Topic<pipescout_msgs::msg::FusedOdometer> kOdometerFused{"odometer/fused",
                                                                          QoS::reliable(100)};
/// The signal of an eddy-current probe, from the driver.
inline constexpr Topic<pipescout_msgs::msg::EddyCurrentSamples> kEddyCurrent{"eddy_current",
                                                                             QoS::reliable(100)};
/// Girth welds that the probe has passed.
inline constexpr Topic<pipescout_msgs::msg::WeldDetection> kWeld{"weld", QoS::reliable(100)};
/// Where the crawler is in the pipe: joint and distance into it.
inline constexpr Topic<pipescout_msgs::msg::PipePosition> kPipePosition{"pipe/position",
                                                                        QoS::reliable(100)};
/// Where it really is, from a simulator. Never published by a robot.
inline constexpr Topic<pipescout_msgs::msg::PipePosition> kTruePipePosition{
    "ground_truth/pipe_position", QoS::reliable(100)};
/// Images of the camera that looks at the rack, 8-bit grey or colour, and its calibration.
inline constexpr Topic<sensor_msgs::msg::Image> kCameraImage{
    .name = "camera/image_raw", .qos = QoS::reliable(5), .requested = QoS::sensor_data(5)};
inline constexpr Topic<sensor_msgs::msg::CameraInfo> kCameraInfo{
    .name = "camera/camera_info", .qos = QoS::reliable(5), .requested = QoS::sensor_data(5)};
/// Pose of the camera in the rack frame. Not published while it is not known.
inline constexpr Topic<geometry_msgs::msg::PoseWithCovarianceStamped> kRackPose{"rack/pose",
                                                                                QoS::reliable(100)};
/// How far to trust it, and where the pipes are. Published for each image.
inline constexpr Topic<pipescout_msgs::msg::RackState> kRackState{"rack/state", QoS::reliable(100)};
/// Where the camera really is, from a simulator. Never published by a robot.
inline constexpr Topic<geometry_msgs::msg::PoseStamped> kTrueRackPose{"ground_truth/rack_pose",
                                                                      QoS::reliable(100)};
/// A pose of the camera in the rack frame to start from or to go on from, with its covariance: from
/// an operator, GPS or the estimator.
inline constexpr Topic<geometry_msgs::msg::PoseWithCovarianceStamped> kRackPoseHint{
    .name = "rack/pose_hint", .qos = QoS::reliable(10), .while_inactive = WhileInactive::kDrop};
/// Velocity that a flying robot shall take, in its levelled body frame.
inline constexpr Topic<geometry_msgs::msg::TwistStamped> kVelocityCommand{
    .name = "cmd_vel_stamped", .qos = QoS::reliable(10), .while_inactive = WhileInactive::kDrop};
/// Pictures of the thermal camera, `mono16`, and its calibration.
inline constexpr Topic<sensor_msgs::msg::Image> kThermalImage{
    .name = "thermal/image_raw", .qos = QoS::reliable(5), .requested = QoS::sensor_data(5)};
inline constexpr Topic<sensor_msgs::msg::CameraInfo> kThermalCameraInfo{
    .name = "thermal/camera_info", .qos = QoS::reliable(5), .requested = QoS::sensor_data(5)};
/// Pipes and leaks in each of them.
inline constexpr Topic<pipescout_msgs::msg::LeakDetections> kLeakDetections{"leak/detections",
                                                                            QoS::reliable(100)};
/// Leaks that are raised, updated and cleared, from all pictures. Kept for late joiners.
inline constexpr Topic<pipescout_msgs::msg::LeakEvent> kLeakEvents{"leak/events",
                                                                   QoS::latched(1000)};
/// The leaks that there are, from a simulator, one message each. Never published by a robot.
inline constexpr Topic<pipescout_msgs::msg::LeakEvent> kTrueLeaks{"ground_truth/leaks",
                                                                  QoS::latched(1000)};
/// The pipe that is tracked, for each picture, and the particles that track it, to look at.
inline constexpr Topic<pipescout_msgs::msg::PipeTrack> kPipeTrack{"track/pipe", QoS::reliable(100)};
inline constexpr Topic<pipescout_msgs::msg::PipeTrackParticles> kPipeTrackParticles{
    "track/particles", QoS::reliable(10)};
/// Where the pipe really is in each picture, from a simulator. Never published by a robot.
inline constexpr Topic<pipescout_msgs::msg::PipeTrack> kTruePipeTrack{"ground_truth/pipe_track",
                                                                      QoS::reliable(100)};
/// Joints of the camera arm: where the driver says they are, and where they shall go. Only the last
/// command counts.
inline constexpr Topic<sensor_msgs::msg::JointState> kJointStates{
    .name = "joint_states", .qos = QoS::reliable(100), .requested = QoS::sensor_data(100)};
inline constexpr Topic<trajectory_msgs::msg::JointTrajectory> kArmCommand{
    .name = "arm/command", .qos = QoS::reliable(1), .while_inactive = WhileInactive::kDrop};
/// The robot as a URDF text, for those that come later too.
inline constexpr Topic<std_msgs::msg::String> kRobotDescription{"robot_description",
                                                                QoS::latched(1)};
/// What the camera arm does and why, in each cycle.
inline constexpr Topic<pipescout_msgs::msg::ArmState> kArmState{"arm/state", QoS::reliable(100)};
/// Angular rate and specific force, from the driver, and the position of the GPS antenna.
inline constexpr Topic<sensor_msgs::msg::Imu> kImu{
    .name = "imu/data", .qos = QoS::reliable(200), .requested = QoS::sensor_data(200)};
inline constexpr Topic<sensor_msgs::msg::NavSatFix> kGpsFix{
    .name = "gps/fix", .qos = QoS::reliable(50), .requested = QoS::sensor_data(20)};
/// The one state of the robot in the map, from the estimator.
inline constexpr Topic<nav_msgs::msg::Odometry> kOdometryFiltered{"odometry/filtered",
                                                                  QoS::reliable(100)};
/// Why it believes that, once per keyframe.
inline constexpr Topic<pipescout_msgs::msg::EstimatorState> kEstimatorState{"estimator/state",
                                                                            QoS::reliable(100)};
/// Pose of the robot in the map, to start from: from an operator. The name is that of rviz.
inline constexpr Topic<geometry_msgs::msg::PoseWithCovarianceStamped> kInitialPose{
    .name = "initialpose", .qos = QoS::reliable(10), .while_inactive = WhileInactive::kDrop};
/// Where the robot really is, from a simulator, in the map. Never published by a robot.
inline constexpr Topic<nav_msgs::msg::Odometry> kTrueOdometry{"ground_truth/odometry",
                                                              QoS::reliable(100)};

}  // namespace pipescout::topics
