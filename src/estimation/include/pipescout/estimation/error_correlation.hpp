// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstddef>
#include <limits>
#include <optional>

namespace pipescout::estimation {

/// For how long the errors of a source stay alike, learnt from its innovations.
///
/// The variance of the mean of m = 1, 2, 4, ... innovations, times m and over that of one, is 1 for
/// white errors and rises to (1 + a) / (1 - a) for errors that are correlated by a from one to the
/// next: what `covariance_factor` multiplies covariances with. (Flyvbjerg and Petersen, 1989,
/// "Error estimates on averages of correlated data".) What m measurements leave open is taken for
/// as bad as it can be: the share of the errors that is correlated is then one that stays alike for
/// the longest time that was stated. So the result comes down from that as measurements accumulate.
///
/// Errors that stay alike for longer than the filter needs to follow them do not show in the
/// innovations: it follows them as it follows a motion. Then the time found is that for which it
/// takes, and the stated covariance about that of one measurement.
///
/// Horizontal only. Constant memory; pure.
class ErrorCorrelation {
 public:
  /// An innovation over the stated standard deviation, per axis. Those that are not newer than the
  /// last one are ignored.
  void add(double time, const Eigen::Vector2d& innovation) noexcept;
  /// s, correlation time of errors that are no less correlated than those seen so far, in
  /// [shortest, longest]; `longest` before any. `shortest` not above `longest`; not checked.
  [[nodiscard]] double time(double shortest, double longest) const noexcept;

 private:
  static constexpr std::size_t kLevels = 12;

  /// Of the means of 2^i innovations.
  struct Level {
    Eigen::Vector2d first = Eigen::Vector2d::Zero();  // of a pair that is not complete
    bool has_first = false;
    double square = 0;  // mean per axis
    double count = 0;
  };

  /// Largest factor on covariances by a share of the errors that stays alike for that time (s), as
  /// far as it agrees with what was seen; nothing if none does.
  [[nodiscard]] std::optional<double> possible_factor(double correlation_time) const noexcept;

  std::array<Level, kLevels> levels_{};
  double newest_ = -std::numeric_limits<double>::infinity();  // s
  double spacing_ = 0;                                        // s, mean
};

}  // namespace pipescout::estimation
