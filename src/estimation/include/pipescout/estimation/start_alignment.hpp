// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <optional>

#include "pipescout/geometry/so3.hpp"

/// Initial attitude of a vehicle: roll and pitch from gravity, heading from motion.
namespace pipescout::estimation {

/// The rotation with zero yaw that is consistent with `specific_force` (m/s^2, in the body, without
/// acceleration). Nothing when the force is not finite or below 1e-3.
[[nodiscard]] std::optional<geometry::SO3> level(const Eigen::Vector3d& specific_force) noexcept;

/// Yaw and translation between a track by dead reckoning in a level frame and the same track
/// measured by an absolute source: least squares for
///
///     measured = [c -s; s c] reckoned + offset + drift * (time - first time)
///
/// with c, s, offset and drift free except for a prior on the drift, the velocity error of the
/// dead-reckoned track. Linear, closed form, by sums: constant memory. c^2 + s^2 is 1 for tracks of
/// the same motion, which is a consistency check. Heights have an offset and a drift too.
class TrackAlignment {
 public:
  /// `drift_deviation` m/s, 0: the reckoned track does not drift. `reckoning_share`: its error, as
  /// a share of its length; added to the covariance.
  explicit TrackAlignment(double drift_deviation = 0, double reckoning_share = 0)
      : drift_deviation_(drift_deviation), reckoning_share_(reckoning_share) {}

  /// Both m; `deviation` m, > 0, of both together, per axis. Not checked: finite values.
  void add(double time, const Eigen::Vector3d& measured, const Eigen::Vector3d& reckoned,
           double deviation) noexcept;

  struct Result {
    double yaw = 0;            ///< rad: measured frame from reckoned frame, about z
    double yaw_deviation = 0;  ///< rad; pi when the track is too short
    Eigen::Vector3d offset = Eigen::Vector3d::Zero();  ///< m: measured = Rz(yaw) reckoned + offset,
                                                       ///< at the newest pair
    double offset_deviation = 0;  ///< m, per axis, at the newest pair with the yaw known
    Eigen::Vector3d drift = Eigen::Vector3d::Zero();  ///< m/s, in the measured frame
    double drift_deviation = 0;                       ///< m/s, per axis
    double scale = 1;                                 ///< hypot(c, s)
    double scale_deviation = 0;
    double chi_square = 0;  ///< of the residuals, with degrees of freedom:
    int degrees = 0;
  };
  /// Nothing with fewer than 3 pairs.
  [[nodiscard]] std::optional<Result> solve() const noexcept;
  /// The same with a known yaw: offset and chi-square only; one pair is sufficient.
  [[nodiscard]] std::optional<Result> solve(double yaw) const noexcept;

  [[nodiscard]] std::size_t pairs() const noexcept { return pairs_; }
  [[nodiscard]] double first_time() const noexcept { return first_time_; }
  [[nodiscard]] double newest_time() const noexcept { return newest_time_; }
  /// m, extent of the dead-reckoned track along x and y.
  [[nodiscard]] double extent() const noexcept;

 private:
  using Vector6 = Eigen::Matrix<double, 6, 1>;
  using Matrix6 = Eigen::Matrix<double, 6, 6>;

  /// Translation, drift and height at the newest pair, given [c; s; offset; drift].
  [[nodiscard]] Result at_newest(const Vector6& x, double yaw) const noexcept;
  [[nodiscard]] double drift_information() const noexcept;

  double drift_deviation_;
  double reckoning_share_;
  std::size_t pairs_ = 0;
  double first_time_ = 0;
  double newest_time_ = 0;
  // Sums are relative to the first pair, for numerical accuracy.
  Eigen::Vector3d first_measured_ = Eigen::Vector3d::Zero();
  Eigen::Vector3d first_reckoned_ = Eigen::Vector3d::Zero();
  Eigen::Vector3d newest_reckoned_ = Eigen::Vector3d::Zero();
  Eigen::Vector2d low_ = Eigen::Vector2d::Zero();
  Eigen::Vector2d high_ = Eigen::Vector2d::Zero();
  Matrix6 information_ = Matrix6::Zero();  // of [c; s; offset; drift]
  Vector6 vector_ = Vector6::Zero();
  double sum_ = 0;  // of the squares of the whitened measurements
  // Heights: [offset; drift].
  Eigen::Matrix2d height_information_ = Eigen::Matrix2d::Zero();
  Eigen::Vector2d height_vector_ = Eigen::Vector2d::Zero();
};

}  // namespace pipescout::estimation
