// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

#include "pipescout/estimation/factors.hpp"
#include "pipescout/estimation/imu_timeline.hpp"

/// The start of a vehicle of which nobody knows whether it stands: from IMU and GPS to a state.
namespace pipescout::estimation {

/// What the body may have been doing when its IMU was levelled.
struct StartHypothesis {
  /// Rotation: of a level frame of any heading; position is not used; velocity in that frame.
  NavState mean{};
  double tilt_deviation = 0.1;                ///< rad
  double velocity_deviation = 1;              ///< m/s
  double gyro_bias_deviation = 0.02;          ///< rad/s
  double accelerometer_bias_deviation = 0.1;  ///< m/s^2
  bool stands = false;                        ///< `stand_still` is for this one
};

/// A Gaussian sum filter: extended Kalman filters side by side, one for each of `kHeadings`
/// headings that the body may begin with and for each StartHypothesis, weighted by how well they
/// predict the positions (Sorenson and Alspach, "Recursive Bayesian estimation using Gaussian
/// sums", Automatica 7(4), 1971). Dead reckoning over tens of seconds is off by the square of the
/// time for a wrong tilt, by its cube for a wrong bias, and both look like a turned track; here
/// they are states, so that the deviation of the heading is what is really known of it. Neighbours
/// are so near (15 degrees) that each is as good as linear.
///
/// Frames and units as NavState. Deterministic; nothing allocates after construction.
class InMotionAlignment {
 public:
  static constexpr int kHeadings = 24;
  static constexpr std::size_t kMostStarts = 2;

  /// `how` is not checked. Room for `samples` of the IMU.
  InMotionAlignment(const ImuIntegration& how, std::size_t samples);

  /// From `time` on; readings before it are not used. At most kMostStarts; the rest is left out.
  void begin(double time, const StartHypothesis* starts, std::size_t count);
  [[nodiscard]] bool begun() const noexcept { return begun_; }
  void end() noexcept { begun_ = false; }

  void add(const ImuSample& sample) noexcept { imu_.push(sample); }
  /// The body seems to stand at the next position; `rate` as ZeroAngularRateMeasurement.
  struct Standstill {
    double velocity_deviation = 0;                   ///< m/s
    Eigen::Vector3d rate = Eigen::Vector3d::Zero();  ///< rad/s, as the gyro has it
    double rate_deviation = 0;                       ///< rad/s
  };
  enum class Verdict : std::uint8_t {
    kUsed,
    kLate,         ///< older than the one before
    kGated,        ///< nothing that it may have been doing leads there
    kContradicts,  ///< nor to several before it: to be begun again, from a new levelling
  };
  /// In order of time; the IMU has been added up to it. `lever_arm` m, in the body. `covariance`
  /// within what `check` allows.
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
  /// The mean of all hypotheses at `time`, up to which the IMU has been added, with what they
  /// differ by in the covariance. `heading`, when given, is what something else says of it then.
  /// Nothing before the first position, and while the residuals are larger than they can be by
  /// chance.
  [[nodiscard]] std::optional<Result> solve(double time, const std::optional<Heading>& heading);

 private:
  struct Hypothesis {
    NavState state{};
    StateMatrix covariance = StateMatrix::Zero();
    double log_weight = 0;  // up to a constant
    double misfit = 0;      // chi-square of its innovations lately
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
  std::vector<Hypothesis> told_{};  // room for those of `solve`
  bool begun_ = false;
  double time_ = 0;
  std::size_t positions_ = 0;
  std::size_t gated_running_ = 0;
};

}  // namespace pipescout::estimation
