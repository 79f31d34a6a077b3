// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "pipescout/interfaces/topic.hpp"

namespace diagnostic_msgs::msg {
class DiagnosticArray;
}
namespace geometry_msgs::msg {
class PoseStamped;
class PoseWithCovarianceStamped;
class TwistStamped;
}  // namespace geometry_msgs::msg
namespace nav_msgs::msg {
class Odometry;
}
namespace pipescout_msgs::msg {
class ArmState;
class EddyCurrentSamples;
class EstimatorState;
class FusedOdometer;
class LeakDetections;
class LeakEvent;
class MissionStatus;
class OdometerReadings;
class PipePosition;
class PipeTrack;
class PipeTrackParticles;
class RackState;
class WeldDetection;
}  // namespace pipescout_msgs::msg
namespace rcl_interfaces::msg {
class Log;
class ParameterEvent;
}  // namespace rcl_interfaces::msg
namespace rosgraph_msgs::msg {
class Clock;
}
namespace sensor_msgs::msg {
class CameraInfo;
class Image;
class Imu;
class JointState;
class NavSatFix;
}  // namespace sensor_msgs::msg
namespace tf2_msgs::msg {
class TFMessage;
}
namespace trajectory_msgs::msg {
class JointTrajectory;
}

/// The catalogue: the one place where a topic's name, type and QoS are written down. The types are
/// only declared here; include the message's own header to use them.
namespace pipescout::topics {

/// Raw readings of all odometers of a robot, from the driver.
inline const Topic<pipescout_msgs::msg::OdometerReadings> kOdometerReadings{"odometer/readings",
                                                                            QoS::reliable(100)};
/// One distance from all odometers that agree.
inline const Topic<pipescout_msgs::msg::FusedOdometer> kOdometerFused{"odometer/fused",
                                                                      QoS::reliable(100)};
/// The signal of an eddy-current probe, from the driver.
inline const Topic<pipescout_msgs::msg::EddyCurrentSamples> kEddyCurrent{"eddy_current",
                                                                         QoS::reliable(100)};
/// Girth welds that the probe has passed.
inline const Topic<pipescout_msgs::msg::WeldDetection> kWeld{"weld", QoS::reliable(100)};
/// Where the crawler is in the pipe: joint and distance into it.
inline const Topic<pipescout_msgs::msg::PipePosition> kPipePosition{"pipe/position",
                                                                    QoS::reliable(100)};
/// Where it really is, from a simulator. Never published by a robot.
inline const Topic<pipescout_msgs::msg::PipePosition> kTruePipePosition{
    "ground_truth/pipe_position", QoS::reliable(100)};
/// Images of the camera that looks at the rack, 8-bit grey or colour, and its calibration.
inline const Topic<sensor_msgs::msg::Image> kCameraImage{"camera/image_raw", QoS::reliable(5)};
inline const Topic<sensor_msgs::msg::CameraInfo> kCameraInfo{"camera/camera_info",
                                                             QoS::reliable(5)};
/// Pose of the camera in the rack frame. Not published while it is not known.
inline const Topic<geometry_msgs::msg::PoseWithCovarianceStamped> kRackPose{"rack/pose",
                                                                            QoS::reliable(100)};
/// How far to trust it, and where the pipes are. Published for each image.
inline const Topic<pipescout_msgs::msg::RackState> kRackState{"rack/state", QoS::reliable(100)};
/// Where the camera really is, from a simulator. Never published by a robot.
inline const Topic<geometry_msgs::msg::PoseStamped> kTrueRackPose{"ground_truth/rack_pose",
                                                                  QoS::reliable(100)};
/// A pose of the camera in the rack frame to start from or to go on from, with its covariance: from
/// an operator, GPS or the estimator.
inline const Topic<geometry_msgs::msg::PoseWithCovarianceStamped> kRackPoseHint{"rack/pose_hint",
                                                                                QoS::reliable(10)};
/// Velocity that a flying robot shall take, in its levelled body frame.
inline const Topic<geometry_msgs::msg::TwistStamped> kVelocityCommand{"cmd_vel_stamped",
                                                                      QoS::reliable(10)};
/// Pictures of the thermal camera, `mono16`, and its calibration.
inline const Topic<sensor_msgs::msg::Image> kThermalImage{"thermal/image_raw", QoS::reliable(5)};
inline const Topic<sensor_msgs::msg::CameraInfo> kThermalCameraInfo{"thermal/camera_info",
                                                                    QoS::reliable(5)};
/// Pipes and leaks in each of them.
inline const Topic<pipescout_msgs::msg::LeakDetections> kLeakDetections{"leak/detections",
                                                                        QoS::reliable(100)};
/// Leaks that are raised, updated and cleared, from all pictures. Kept for late joiners.
inline const Topic<pipescout_msgs::msg::LeakEvent> kLeakEvents{"leak/events", QoS::latched(1000)};
/// The leaks that there are, from a simulator, one message each. Never published by a robot.
inline const Topic<pipescout_msgs::msg::LeakEvent> kTrueLeaks{"ground_truth/leaks",
                                                              QoS::latched(1000)};
/// The pipe that is tracked, for each picture, and the particles that track it, to look at.
inline const Topic<pipescout_msgs::msg::PipeTrack> kPipeTrack{"track/pipe", QoS::reliable(100)};
inline const Topic<pipescout_msgs::msg::PipeTrackParticles> kPipeTrackParticles{"track/particles",
                                                                                QoS::reliable(10)};
/// Where the pipe really is in each picture, from a simulator. Never published by a robot.
inline const Topic<pipescout_msgs::msg::PipeTrack> kTruePipeTrack{"ground_truth/pipe_track",
                                                                  QoS::reliable(100)};
/// Joints of the camera arm: where the driver says they are, and where they shall go. Only the last
/// command counts.
inline const Topic<sensor_msgs::msg::JointState> kJointStates{"joint_states", QoS::reliable(100)};
inline const Topic<trajectory_msgs::msg::JointTrajectory> kArmCommand{"arm/command",
                                                                      QoS::reliable(1)};
/// What the camera arm does and why, in each cycle.
inline const Topic<pipescout_msgs::msg::ArmState> kArmState{"arm/state", QoS::reliable(100)};
/// Angular rate and specific force, from the driver, and the position of the GPS antenna.
inline const Topic<sensor_msgs::msg::Imu> kImu{"imu/data", QoS::reliable(200)};
inline const Topic<sensor_msgs::msg::NavSatFix> kGpsFix{"gps/fix", QoS::reliable(50)};
/// The one state of the robot in the map, from the estimator.
inline const Topic<nav_msgs::msg::Odometry> kOdometryFiltered{"odometry/filtered",
                                                              QoS::reliable(100)};
/// Why it believes that, once per keyframe.
inline const Topic<pipescout_msgs::msg::EstimatorState> kEstimatorState{"estimator/state",
                                                                        QoS::reliable(100)};
/// Pose of the robot in the map, to start from: from an operator. The name is that of rviz.
inline const Topic<geometry_msgs::msg::PoseWithCovarianceStamped> kInitialPose{"initialpose",
                                                                               QoS::reliable(10)};
/// Where the robot really is, from a simulator, in the map. Never published by a robot.
inline const Topic<nav_msgs::msg::Odometry> kTrueOdometry{"ground_truth/odometry",
                                                          QoS::reliable(100)};
/// Progress and completion of components, for the host and the operator. Kept for late joiners: the
/// last word of a component must not be lost because it was said before they were discovered.
inline const Topic<pipescout_msgs::msg::MissionStatus> kMissionStatus{"mission/status",
                                                                      QoS::latched(10)};

/// Simulated time, for nodes with `use_sim_time`.
inline const Topic<rosgraph_msgs::msg::Clock> kClock{"/clock", QoS::reliable(10)};
/// Transforms between frames, from whoever knows them; those that never change kept for late
/// joiners.
inline const Topic<tf2_msgs::msg::TFMessage> kTf{"/tf", QoS::reliable(100)};
inline const Topic<tf2_msgs::msg::TFMessage> kTfStatic{"/tf_static", QoS::latched(1)};
inline const Topic<diagnostic_msgs::msg::DiagnosticArray> kDiagnostics{"/diagnostics",
                                                                       QoS::reliable(10)};
/// As rcl: kept for late joiners, forgotten after ten seconds.
inline const Topic<rcl_interfaces::msg::Log> kRosout{"/rosout",
                                                     QoS{.depth = 1000,
                                                         .durability = Durability::kTransientLocal,
                                                         .lifespan = std::chrono::seconds(10)}};
inline const Topic<rcl_interfaces::msg::ParameterEvent> kParameterEvents{"/parameter_events",
                                                                         QoS::parameters()};

}  // namespace pipescout::topics
