// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

#include "pipescout/estimation/factors.hpp"
#include "pipescout/estimation/imu_timeline.hpp"

/// Initialisation from IMU and GPS of a vehicle that may be moving.
namespace pipescout::estimation {

/// Hypothesis on the motion of the body while its IMU was levelled.
struct StartHypothesis {
  /// Rotation: of a level frame of any heading; position is not used; velocity in that frame.
  NavState mean{};
  double tilt_deviation = 0.1;                ///< rad
  double velocity_deviation = 1;              ///< m/s
  double gyro_bias_deviation = 0.02;          ///< rad/s
  double accelerometer_bias_deviation = 0.1;  ///< m/s^2
  bool stands = false;                        ///< `stand_still` applies to this hypothesis
};

/// A Gaussian sum filter: a bank of extended Kalman filters, one for each of `kHeadings` initial
/// headings and each StartHypothesis, weighted by the likelihood of the positions (Sorenson and
/// Alspach, "Recursive Bayesian estimation using Gaussian sums", Automatica 7(4), 1971). Over tens
/// of seconds the error of dead reckoning grows with the square of the time for a tilt error, with
/// its cube for a bias, and both resemble a rotated track. Here they are states, so that the
/// standard deviation of the heading is consistent. Neighbouring headings are close enough (15
/// degrees) for each filter to be nearly linear.
///
/// Frames and units as NavState. Deterministic; nothing allocates after construction.
class InMotionAlignment {
 public:
  static constexpr int kHeadings = 24;
  static constexpr std::size_t kMostStarts = 2;

  /// `how` is not checked. Capacity for `samples` of the IMU.
  InMotionAlignment(const ImuIntegration& how, std::size_t samples);

  /// From `time` on; readings before it are not used. At most kMostStarts hypotheses; further ones
  /// are ignored.
  void begin(double time, const StartHypothesis* starts, std::size_t count);
  [[nodiscard]] bool begun() const noexcept { return begun_; }
  void end() noexcept { begun_ = false; }

  void add(const ImuSample& sample) noexcept { imu_.push(sample); }
  /// Standstill was detected at the next position; `rate` as ZeroAngularRateMeasurement.
  struct Standstill {
    double velocity_deviation = 0;                   ///< m/s
    Eigen::Vector3d rate = Eigen::Vector3d::Zero();  ///< rad/s, as the gyro has it
    double rate_deviation = 0;                       ///< rad/s
  };
  enum class Verdict : std::uint8_t {
    kUsed,
    kLate,         ///< older than the previous one
    kGated,        ///< inconsistent with all hypotheses
    kContradicts,  ///< several in a row are inconsistent: start again from a new levelling
  };
  /// In order of time; the IMU must have been added up to it. `lever_arm` m, in the body.
  /// `covariance` within what `check` allows.
  Verdict add(const GpsMeasurement& m, const Eigen::Vector3d& lever_arm,
              const std::optional<Standstill>& standstill);

  struct Heading {
    double value = 0;  ///< rad, of the body in the map
    double deviation = 0;
  };
  struct Result {
    NavState state{};  ///< in the map
    StateMatrix covariance = StateMatrix::Zero();
    double heading_deviation = 0;  ///< rad
    std::size_t positions = 0;     ///< that were used
  };
  /// The mean of all hypotheses at `time`, up to which the IMU must have been added; the covariance
  /// includes their spread. `heading`, when given, is another measurement of it at that time.
  /// Nothing before the first position, and while the innovations are inconsistent.
  [[nodiscard]] std::optional<Result> solve(double time, const std::optional<Heading>& heading);

 private:
  struct Hypothesis {
    NavState state{};
    StateMatrix covariance = StateMatrix::Zero();
    double log_weight = 0;  // up to a constant
    double misfit = 0;      // chi-square of its recent innovations
    double degrees = 0;
    bool stands = false;
  };

  void carry(Hypothesis& h, const ImuPreintegration& motion) const;
  [[nodiscard]] ImuPreintegration motion_between(double from, double to) const;
  [[nodiscard]] const Hypothesis& best() const noexcept;
  void place(const GpsMeasurement& m, const Eigen::Vector3d& lever_arm);
  void drop_unlikely();

  ImuIntegration how_;
  ImuTimeline imu_;
  double gate_;  // chi-square of a position
  std::vector<Hypothesis> hypotheses_{};
  std::vector<Hypothesis> told_{};  // storage for those of `solve`
  bool begun_ = false;
  double time_ = 0;
  std::size_t positions_ = 0;
  std::size_t gated_running_ = 0;
};

}  // namespace pipescout::estimation
