// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstddef>

#include "pipescout/odometry/odometer_stream.hpp"

namespace pipescout::odometry::internal {

/// A state that is entered after some pieces of evidence in a row and left after others in a row.
class Hysteresis {
 public:
  Hysteresis(int enter, int leave) : enter_(enter), leave_(leave) {}

  /// Neither: nothing can be said, and the rows go on.
  void update(bool evidence, bool clear);
  [[nodiscard]] bool on() const { return on_; }

 private:
  int enter_;
  int leave_;
  int row_ = 0;
  bool on_ = false;
};

/// What an odometer and the consensus said of one window.
struct WindowEvidence {
  double increment = 0.0;        ///< m, the odometer's
  double deviation = 0.0;        ///< m, its standard deviation
  double path = 0.0;             ///< m
  double fused = 0.0;            ///< m
  double fused_deviation = 0.0;  ///< m
  bool agreed = false;           ///< the fused distance is a consensus
};

/// One odometer's health, its scale relative to the consensus, its noise from residuals.
class OdometerMonitor {
 public:
  OdometerMonitor(const OdometerParameters& odometer, const OdometerStreamParameters& stream);

  void note_sample(bool usable);
  /// `last` sample, s, -inf for none. Silence ends when samples have come for as long as it took to
  /// be noticed.
  void note_time(double now, double last);
  void note_window(const WindowEvidence& window);
  /// `reference`: scale of the median odometer.
  void judge_wear(double reference);
  /// Forgets the scale: the odometer has another correction now.
  void restart_scale();

  [[nodiscard]] OdometerHealth health() const;
  [[nodiscard]] bool silent() const { return silent_; }
  [[nodiscard]] double sigma_per_sqrt_metre() const { return sigma_; }
  [[nodiscard]] double scale() const { return scale_; }
  /// The scale has seen half of `scale_memory`.
  [[nodiscard]] bool scale_known() const { return scale_path_ >= 0.5 * limits_.scale_memory; }

 private:
  void estimate_scale(const WindowEvidence& window);
  void estimate_sigma(const WindowEvidence& window);

  OdometerHealthParameters limits_;
  SigmaSource sigma_source_;
  std::size_t residual_windows_;
  double window_distance_;
  double silent_after_;
  double given_sigma_;
  double sigma_;

  double bad_share_ = 0.0;
  bool bad_ = false;
  bool worn_ = false;
  bool silent_ = true;
  bool heard_ = false;
  bool ever_heard_ = false;
  double heard_since_ = 0.0;  // s
  Hysteresis slipping_;
  Hysteresis stuck_;
  double scale_ = 1.0;
  double scale_path_ = 0.0;  // m
  std::array<double, 64> residuals_{};
  std::size_t residual_count_ = 0;
};

/// Median of `values`, which it reorders; `count` > 0.
[[nodiscard]] double median(double* values, std::size_t count);

}  // namespace pipescout::odometry::internal
