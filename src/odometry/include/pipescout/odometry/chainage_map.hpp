// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <limits>
#include <span>
#include <vector>

/// Maps distances of one odometer to another by the welds that both runs have detected.
///
/// Chainage: the distance along the pipe by one odometer, m. Pure values: any number of threads may
/// read one map at once.
namespace pipescout::odometry {

/// One weld, detected by both.
struct ChainageKnot {
  double from = std::numeric_limits<double>::quiet_NaN();  ///< m, finite
  double to = std::numeric_limits<double>::quiet_NaN();    ///< m, finite
  /// m, standard deviation of `to` given `from`; finite, not negative.
  double standard_deviation = 0.0;
};

/// Error model of the odometers between two welds.
struct ChainageMapParameters {
  double length_noise = 0.01;  ///< m / sqrt(m), random walk of the difference; finite, not negative
  double scale_sigma = 0.02;   ///< of the ratio of the odometers beyond the ends; finite, >= 0

  /// Throws std::invalid_argument naming the field, the value and the range.
  void validate() const;
};

/// A chainage and its uncertainty, m. NaN when not available.
struct MappedChainage {
  double chainage = std::numeric_limits<double>::quiet_NaN();
  double standard_deviation = std::numeric_limits<double>::quiet_NaN();
  bool between_welds = false;  ///< false: beyond the ends, by the local ratio of the odometers
};

/// Monotone and piecewise linear: exact at the knots, linear between neighbours. A decreasing map
/// means that the runs went in opposite directions.
///
/// Uncertainty between the neighbouring knots 0 and 1, distance L apart, at the fraction t:
///   (1-t)^2 sigma_0^2 + t^2 sigma_1^2 + (length_noise^2 L + D^2) t (1-t)
/// where D is the deviation of the joint's length from the ratio of its neighbours: a slip happened
/// at one unknown position, which gives the variance D^2 t (1-t). At a distance d beyond the ends:
/// sigma^2 + length_noise^2 d + scale_sigma^2 d^2.
class ChainageMap {
 public:
  ChainageMap() = default;  ///< without knots: maps everything to NaN

  /// Throws std::invalid_argument when `from` is not strictly increasing, `to` is not strictly
  /// monotone, or a value is outside its range. One knot: ratio 1.
  explicit ChainageMap(std::vector<ChainageKnot> knots, ChainageMapParameters parameters = {});

  /// NaN for a chainage that is not finite.
  [[nodiscard]] MappedChainage map(double from) const noexcept;

  /// The inverse map; standard deviations are scaled by the local ratio.
  [[nodiscard]] ChainageMap inverse() const;

  /// D of the segment between the knots `segment` and `segment` + 1, m: positive when it is longer
  /// in `to` than expected from its neighbours. Not checked: segment + 1 < knots().size().
  [[nodiscard]] double slip(std::size_t segment) const noexcept;

  [[nodiscard]] std::span<const ChainageKnot> knots() const noexcept { return knots_; }

 private:
  [[nodiscard]] double ratio_around(std::size_t segment, bool with_itself) const noexcept;

  std::vector<ChainageKnot> knots_;
  ChainageMapParameters parameters_;
};

}  // namespace pipescout::odometry
