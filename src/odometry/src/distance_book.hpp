// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstddef>
#include <span>

#include "pipescout/odometry/odometer_stream.hpp"

namespace pipescout::odometry::internal {

/// How the distance since the anchor came about.
struct WindowSum {
  double distance = 0.0;                          ///< m
  std::array<double, kMaxOdometers> weight{};     ///< of each odometer in it, sum 1, or all 0
  std::array<double, kMaxOdometers> increment{};  ///< m, 0 where the weight is
  std::array<double, kMaxOdometers> path{};       ///< m
  std::array<double, kMaxOdometers> random{};     ///< m^2, that grew with the path
  bool agreed = false;
  double bias = 0.0;          ///< m, standard deviation of an error that the next window repeats
  double gap_variance = 0.0;  ///< m^2, of distance that no odometer saw
};

/// Adds windows up and knows what the sum is worth. A value: copies do not allocate. Errors are
/// added as what they are:
/// - of the path: independent from window to window;
/// - of counting: at the anchors only, so that what one window ends with the next begins with; an
///   odometer of constant weight has its first and its last one left;
/// - of scales and offsets: the same all the time, so that they grow with the distance (not with
/// its
///   root) and vanish on the way back; one correction after the other of an odometer is learnt from
///   much the same data, so their errors are taken for one;
/// - of a fallback, or of a bend that may be a slip: the same until there is no doubt any more.
class DistanceBook {
 public:
  explicit DistanceBook(const OdometerStreamParameters& parameters);

  void commit(const WindowSum& window);
  void set_correction(std::size_t odometer, const OdometerCorrection& correction);
  void end_segment();

  [[nodiscard]] double distance(const WindowSum& window) const;
  [[nodiscard]] double random_variance(const WindowSum& window) const;
  [[nodiscard]] double variance(const WindowSum& window) const;

 private:
  struct Account {
    OdometerCorrection correction;
    double counting_variance = 0.0;  // m^2, of one reading
    double weight = 0.0;             // in the last window
    double measured = 0.0;           // m, weighted and raw, since the correction was set
    double offsets = 0.0;            // segments, weighted, since the correction was set
    double segment = 0.0;            // m, weighted path in this segment
    double former = 0.0;             // m, deviation by the corrections before
  };
  /// m, standard deviation of what the account's scale and offset did to the distance; negative
  /// backwards.
  [[nodiscard]] static double correction_deviation(const Account& account, double measured);
  [[nodiscard]] double path_variance(const WindowSum& window) const;

  [[nodiscard]] std::span<Account> accounts() { return std::span(accounts_).first(count_); }
  [[nodiscard]] std::span<const Account> accounts() const {
    return std::span(accounts_).first(count_);
  }

  std::size_t count_;
  std::array<Account, kMaxOdometers> accounts_{};
  double common_variance_;        // m, common_sigma_per_sqrt_metre^2
  double common_scale_variance_;  // 1
  double distance_ = 0.0;
  double path_variance_ = 0.0;
  double counting_variance_ = 0.0;
  double bias_ = 0.0;  // m, of windows in a row with a bias
};

}  // namespace pipescout::odometry::internal
