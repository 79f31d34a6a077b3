// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <optional>
#include <string>
#include <vector>

#include "pipescout/estimator_sources/named_source.hpp"
#include "recording.hpp"

namespace pipescout::estimate {

/// Where the vehicle is at the start, in the map.
struct Start {
  Eigen::Vector3d position = Eigen::Vector3d::Zero();  ///< m
  double position_deviation = 1e-3;                    ///< m, per axis
  double heading = 0;                                  ///< degrees, from the map's x axis
  double heading_deviation = 0.006;                    ///< degrees
};

/// Which source is used as what. Format of the file: docs/estimate.md.
struct Configuration {
  std::string imu;       ///< name of a topic or source; empty: none
  std::string odometer;  ///< the same
  std::string gps;       ///< the same
  std::string base_frame = "base_link";
  /// degrees, roll, pitch, yaw of the IMU in the body; nothing: from /tf_static, else none.
  std::optional<Eigen::Vector3d> imu_rotation{};
  double specific_force_scale = 1;  ///< factor to m/s^2
  /// rad/s/sqrt(Hz) and m/s^2/sqrt(Hz)
  double gyro_noise = 0.01;
  double accelerometer_noise = 5e-2;
  double odometer_scale = 1;  ///< factor on the speed; -1 turns it round
  double odometer_delay = 0;  ///< s, of its stamps behind what they are of
  /// Joints of sensor_msgs/JointState that are wheels.
  std::optional<estimation::WheelDriveParameters> wheels{};
  double gps_deviation = 3;    ///< m, per axis, where a fix states no usable covariance
  double gps_factor = 1;       ///< on stated standard deviations
  double gps_correlation = 1;  ///< s, correlation time of the errors of GPS
  /// s; below `gps_correlation` it is found on line between both. Nothing: as stated with an
  /// odometer, from 0 on without one.
  std::optional<double> gps_shortest_correlation{};
  /// s, standard deviation of the delay of fixes against their stamps, which is estimated; 0: none
  double gps_time_offset_deviation = 0.1;
  /// m, of the antenna in the body; nothing: from /tf_static, else 0.
  std::optional<Eigen::Vector3d> antenna{};
  /// Without one and without GPS the map is where and how the vehicle starts.
  std::optional<Start> start{};
  std::vector<NamedSource> further{};  ///< sources besides these, by name
  std::string sources;  ///< YAML text of the column mapping, for folders of CSV files
};

struct Guess {
  Configuration configuration;
  std::vector<std::string> said;  ///< what was taken for what, and what was not used
};

/// Takes the streams that seem best; what `further` names is used anyway. Never throws: a kind
/// without a stream stays empty.
[[nodiscard]] Guess guess(const Recording& recording, const std::vector<NamedSource>& further);

/// Reads a configuration. Keys that are absent keep what `defaults` says. Throws YamlError.
[[nodiscard]] Configuration read_configuration(const std::string& path,
                                               const Configuration& defaults);
/// With comments for who edits it.
[[nodiscard]] std::string to_yaml(const Configuration& configuration);

}  // namespace pipescout::estimate
