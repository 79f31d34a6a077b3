// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <pipescout/estimation/state_estimator.hpp>
#include <pipescout/geometry/geodesy.hpp>
#include <string>
#include <utility>
#include <vector>

#include "pipescout/message_conversions/camera_mount.hpp"
#include "pipescout/runtime/bound_parameters.hpp"
#include "pipescout/runtime/parameters.hpp"
#include "pipescout/runtime/stamp_limits.hpp"
#include "pipescout/state_estimator/named_sources.hpp"

namespace pipescout {

/// Configuration of the component.
struct EstimatorSettings {
  std::string map_frame;
  std::string odom_frame;
  std::string base_frame;
  std::string rack_frame;
  bool publish_tf = true;
  Duration publish_period{};  ///< 0: at each reading of the IMU
  StampLimits stamp_limits;
  double silent_after = 0;  ///< s

  std::optional<geometry::GeodeticPosition> datum;  ///< nothing: the first fixes that agree
  bool earth = true;                                ///< the map lies on the Earth that turns
  double gps_deviation = 0;        ///< m, per axis, of fixes without covariance; 0: not used
  double least_gps_deviation = 0;  ///< m, per axis, lower bound
  bool heading_from_imu = false;   ///< from the orientation in imu/data
  double heading_deviation = 0;    ///< rad, of orientations without covariance
  double least_weld_probability = 0;
  double weld_deviation = 0;    ///< m, across the pipe
  Eigen::Vector3d weld_sensor;  ///< m, in the base frame
  Eigen::Vector3d imu;          ///< m, in the base frame
  CameraMount camera{geometry::SE3()};
  int camera_mounting = -1;  ///< as VisualPoseMeasurement::mounting
  std::optional<estimation::GivenPose> start;
  std::vector<NamedSource> sources;
  std::optional<std::size_t> implied_imu;  ///< the source that stands for an IMU

  estimation::StateEstimatorParameters estimator;  ///< valid
};

/// The parameters of the component: docs/components/state_estimator.md.
class EstimatorParameters {
 public:
  /// Declares them, with the defaults of the preset that parameter `preset` names. Throws
  /// ParameterError for an unknown preset.
  explicit EstimatorParameters(Parameters& parameters);

  /// `node` listens to transforms where they tell of the camera. Throws std::invalid_argument
  /// naming the parameter, CsvError for the centre line's file, and as Node::transforms.
  [[nodiscard]] EstimatorSettings read(Node& node) const;

 private:
  using Estimator = estimation::StateEstimatorParameters;
  void declare_frames(Parameters& parameters);
  void declare_messages(Parameters& parameters);
  void declare_sensors(Parameters& parameters);
  void declare_start(Parameters& parameters);
  void declare_smoother();
  void declare_use();
  void declare_watch(Parameters& parameters, const std::string& source,
                     estimation::SourceWatchParameters Estimator::*watch,
                     estimation::FactorKind kind);
  [[nodiscard]] std::optional<estimation::GivenPose> start() const;
  /// Makes the mounting of the camera a state of `estimator`, if it is to be one. Throws
  /// std::invalid_argument naming the parameters.
  [[nodiscard]] int camera_mounting(Estimator& estimator) const;
  /// Throws std::invalid_argument naming the parameter.
  [[nodiscard]] std::optional<std::size_t> implied_imu(
      const std::vector<NamedSource>& sources) const;

  Estimator defaults_;
  std::optional<BoundParameters<Estimator>> bound_;
  struct Kernel {
    estimation::FactorKind kind;
    Parameter<std::string> parameter;
  };
  std::vector<Kernel> kernels_;
  std::optional<NamedSourceParameters> sources_;

  Parameter<std::string> map_frame_;
  Parameter<std::string> odom_frame_;
  Parameter<std::string> base_frame_;
  Parameter<std::string> rack_frame_;
  Parameter<bool> publish_tf_;
  Parameter<double> publish_period_;
  Parameter<double> maximum_age_;
  Parameter<double> maximum_lead_;
  Parameter<double> silent_after_;
  Parameter<std::vector<double>> datum_;
  Parameter<bool> earth_;
  Parameter<double> gps_deviation_;
  Parameter<double> least_gps_deviation_;
  Parameter<bool> heading_from_imu_;
  Parameter<double> heading_deviation_;
  Parameter<double> least_weld_probability_;
  Parameter<double> weld_deviation_;
  Parameter<std::vector<double>> weld_sensor_;
  Parameter<std::vector<double>> gps_antenna_;
  Parameter<std::vector<double>> odometer_;
  Parameter<std::vector<double>> imu_position_;
  Parameter<std::string> imu_implied_by_;
  Parameter<std::vector<double>> imu_roll_pitch_yaw_;
  std::optional<CameraMountParameters> camera_;
  Parameter<double> camera_position_deviation_;
  Parameter<double> camera_rotation_deviation_;
  Parameter<std::vector<double>> rack_position_;
  Parameter<double> rack_heading_;
  Parameter<std::vector<double>> start_position_;
  Parameter<double> start_position_deviation_;
  Parameter<std::vector<double>> start_heading_;
  Parameter<std::string> tally_;
  Parameter<std::string> centre_line_;
  Parameter<double> centre_line_first_chainage_;
};

}  // namespace pipescout
