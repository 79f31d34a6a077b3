// SPDX-License-Identifier: Apache-2.0
#include "odometer_monitor.hpp"

#include <algorithm>
#include <cmath>

namespace pipescout::odometry::internal {
namespace {

constexpr double kBadShareGain = 0.05;   // about 20 samples
constexpr double kClip = 3.0;            // sigmas that one window can pull the scale by
constexpr double kSmallestSigma = 1e-3;  // of the given one; odometers can agree to the bit
constexpr double kMad = 1.4826;          // standard deviation / median absolute deviation, normal

}  // namespace

double median(double* values, std::size_t count) {
  double* const middle = values + count / 2;
  std::nth_element(values, middle, values + count);
  return count % 2 == 1 ? *middle : 0.5 * (*middle + *std::max_element(values, middle));
}

void Hysteresis::update(bool evidence, bool clear) {
  if (on_) {
    row_ = evidence ? 0 : row_ + (clear ? 1 : 0);
    if (row_ >= leave_) {
      on_ = false;
      row_ = 0;
    }
  } else {
    row_ = clear ? 0 : row_ + (evidence ? 1 : 0);
    if (row_ >= enter_) {
      on_ = true;
      row_ = 0;
    }
  }
}

OdometerMonitor::OdometerMonitor(const OdometerParameters& odometer,
                                 const OdometerStreamParameters& stream)
    : limits_(stream.health),
      sigma_source_(stream.sigma_source),
      residual_windows_(stream.residual_windows),
      window_distance_(stream.window_distance),
      silent_after_(stream.silent_after),
      given_sigma_(odometer.sigma_per_sqrt_metre),
      sigma_(odometer.sigma_per_sqrt_metre),
      slipping_(stream.health.enter_windows, stream.health.leave_windows),
      stuck_(stream.health.enter_windows, stream.health.leave_windows) {}

void OdometerMonitor::note_sample(bool usable) {
  bad_share_ += kBadShareGain * ((usable ? 0.0 : 1.0) - bad_share_);
  bad_ = bad_share_ > (bad_ ? limits_.bad_share_leave : limits_.bad_share_enter);
}

void OdometerMonitor::note_time(double now, double last) {
  if (!(now - last <= silent_after_)) {
    silent_ = true;
    heard_ = false;
    return;
  }
  if (!heard_) {
    heard_ = true;
    heard_since_ = now;
  }
  silent_ = silent_ && ever_heard_ && now - heard_since_ < silent_after_;
  ever_heard_ = true;
}

void OdometerMonitor::note_window(const WindowEvidence& window) {
  estimate_sigma(window);
  if (!window.agreed) {
    return;
  }
  const double travelled = std::abs(window.fused);
  const bool moved = travelled >= 0.5 * window_distance_;
  const bool still = moved && std::abs(window.increment) <= limits_.stuck_ratio * travelled;
  const double allowed =
      std::max(limits_.slip_sigmas * std::hypot(window.deviation, window.fused_deviation),
               limits_.slip_ratio * travelled);
  const bool off = std::abs(window.increment - scale_ * window.fused) > allowed;
  stuck_.update(still, moved && !still);
  slipping_.update(off && !still, moved && !off);
  if (moved && !still) {
    estimate_scale(window);
  }
}

void OdometerMonitor::estimate_scale(const WindowEvidence& window) {
  const double limit = kClip * std::hypot(window.deviation, window.fused_deviation);
  const double error = std::clamp(window.increment - scale_ * window.fused, -limit, limit);
  const double travelled = std::abs(window.fused);
  scale_path_ = std::min(scale_path_ + travelled, limits_.scale_memory);
  scale_ += travelled / scale_path_ * error / window.fused;
}

void OdometerMonitor::estimate_sigma(const WindowEvidence& window) {
  if (sigma_source_ != SigmaSource::kResiduals || window.path < 0.5 * window_distance_) {
    return;
  }
  // Every window counts, whether the odometer was in the fusion set or not: without the others the
  // estimate would shrink with each one that is refused. The median bears the slips.
  residuals_[residual_count_ % residual_windows_] =
      std::abs(window.increment - window.fused) / std::sqrt(window.path);
  ++residual_count_;
  if (2 * residual_count_ < residual_windows_) {
    return;
  }
  std::array<double, 64> sorted = residuals_;
  const double spread = kMad * median(sorted.data(), std::min(residual_count_, residual_windows_));
  sigma_ = std::max(std::hypot(spread, window.fused_deviation / std::sqrt(window.path)),
                    kSmallestSigma * given_sigma_);
}

void OdometerMonitor::judge_wear(double reference) {
  const double off = std::abs(scale_ / reference - 1.0);
  worn_ = scale_known() && off > limits_.worn_tolerance * (worn_ ? limits_.worn_release : 1.0);
}

void OdometerMonitor::restart_scale() {
  scale_ = 1.0;
  scale_path_ = 0.0;
  worn_ = false;
}

OdometerHealth OdometerMonitor::health() const {
  if (silent_) {
    return OdometerHealth::kSilent;
  }
  if (bad_) {
    return OdometerHealth::kBadValues;
  }
  if (stuck_.on()) {
    return OdometerHealth::kStuck;
  }
  if (slipping_.on()) {
    return OdometerHealth::kSlipping;
  }
  return worn_ ? OdometerHealth::kWorn : OdometerHealth::kOk;
}

}  // namespace pipescout::odometry::internal
