// SPDX-License-Identifier: Apache-2.0
// What comes out.
#include <algorithm>
#include <cmath>
#include <locale>
#include <numbers>
#include <sstream>

#include "estimator_implementation.hpp"

namespace pipescout::estimation {

using geometry::SE3;
using geometry::SO3;

std::optional<Estimate> StateEstimator::Implementation::estimate() const noexcept {
  if (!reckons()) {
    return std::nullopt;
  }
  const std::optional<FixedLagSmoother::Propagated> now = smoother_.propagated();
  if (!now || !now->state.is_finite()) {
    return std::nullopt;
  }
  Estimate estimate;
  estimate.time = now->time;
  estimate.in_map = in_map();
  estimate.state = now->state;
  if (phase_ != Phase::kCoasting) {
    estimate.angular_rate =
        smoother_.globals().imu_scale.gyro * (last_rate_ - now->state.gyro_bias);
  }
  estimate.T_odom_body = odom_.smooth(now->time, now->state);
  if (!estimate.in_map) {
    const SE3 plain = odom_.plain(now->state);
    estimate.state.R_map_body = plain.rotation();
    estimate.state.position = plain.translation();
    estimate.state.velocity = SO3::about_z(-odom_.yaw()) * now->state.velocity;
  }
  estimate.T_map_odom = estimate.state.T_map_body() * estimate.T_odom_body.inverse();
  return estimate;
}

StateMatrix StateEstimator::Implementation::covariance() const noexcept {
  return reckons() && smoother_.initialised() ? smoother_.propagated_covariance()
                                              : StateMatrix::Zero();
}

EstimatorStatus StateEstimator::Implementation::status() const {
  EstimatorStatus status = status_;
  status.phase = phase_;
  for (const Source source : {Source::kGps, Source::kVisualPose, Source::kHeading, Source::kWeld}) {
    SourceStatus& one = status.sources[index_of(source)];
    // Welds are believed from the first on; until then there are none.
    const bool unheard = source == Source::kWeld && one.accepted + one.gated + one.held == 0;
    one.state = unheard ? SourceState::kAbsent : watch_of(source).state();
    one.correlation_time = watch_of(source).correlation_time();
    one.deviation_factor = watch_of(source).deviation_factor();
  }
  for (std::size_t i = 0; i < kSources; ++i) {
    status.sources[i].waiting = waiting(static_cast<Source>(i));
  }
  status.imu_gaps.behind = imu_lag_;
  const double now = reckons() ? newest_time() : imu_end_;
  for (const Source source : {Source::kImu, Source::kOdometer, Source::kRelativePose}) {
    SourceStatus& one = status.sources[index_of(source)];
    const bool there = now - one.last_accepted < parameters_.smoother.max_step;
    one.state = there ? SourceState::kTrusted : SourceState::kAbsent;
  }
  for (std::size_t i = 0; i < status.own_sources.size(); ++i) {
    SourceStatus& one = status.own_sources[i];
    one.waiting =
        static_cast<std::size_t>(std::ranges::count(own_pending_, own_kind(i), &AnyFactor::kind));
    const bool there = now - one.last_accepted < parameters_.smoother.max_step;
    one.state = there ? SourceState::kTrusted : SourceState::kAbsent;
  }
  if (in_map() && std::isfinite(last_position_)) {
    status.since_absolute_position = std::max(now - last_position_, 0.0);
  }
  std::ostringstream text;
  text.imbue(std::locale::classic());
  switch (phase_) {
    case Phase::kRunning:
      status.waits_for = WaitsFor::kNothing;
      // What is contradicted may be right, and the state wrong.
      for (const Source source : {Source::kGps, Source::kVisualPose, Source::kHeading}) {
        const SourceStatus& one = status.of(source);
        if ((one.state == SourceState::kDoubted || one.state == SourceState::kCandidate) &&
            std::isfinite(one.held_distance)) {
          text << (text.str().empty() ? "" : "; ") << to_string(source) << " is held out, "
               << std::round(10 * one.held_distance) / 10
               << (source == Source::kHeading ? " rad" : " m") << " from the state";
        }
      }
      break;
    case Phase::kCoasting:
      status.waits_for = WaitsFor::kImu;
      if (others_.newest() - others_at_imu_ > parameters_.imu_silence) {
        text << "the IMU is silent: coasting for " << parameters_.longest_coasting << " s at most";
      } else {
        text << "the IMU is more than " << parameters_.longest_wait
             << " s behind the other sources: coasting until it catches up";
      }
      break;
    case Phase::kFault:
      status.waits_for = WaitsFor::kMounting;
      text << fault_;
      break;
    case Phase::kStarting:
      if (levelling_.count == 0 && fault_.empty()) {
        status.waits_for = WaitsFor::kImu;
        text << "waits for readings of the IMU";
      } else {
        status.waits_for = WaitsFor::kLevel;
        text << "levelling: " << parameters_.start.levelling
             << " s of readings of the IMU, preferably at standstill";
      }
      break;
    case Phase::kAligning:
      if (const std::optional<Angle> yaw = start_yaw(); yaw) {
        status.waits_for = WaitsFor::kPlace;
        text << "waits for a position: GPS, a visual pose, a weld or a given pose";
      } else if (const AbsoluteSourceWatch& gps = watch_of(Source::kGps); gps.agreeing() == 0) {
        status.waits_for = WaitsFor::kPlace;
        text << "waits for a position and a heading: GPS and motion, a visual pose, or a given "
                "pose";
      } else if (in_motion_.begun()) {
        status.waits_for = WaitsFor::kHeading;
        constexpr double kDegrees = 180 / std::numbers::pi;
        text << "waits for a heading: GPS and IMU determine it ";
        if (std::isfinite(heading_deviation_)) {
          text << "to " << std::ceil(heading_deviation_ * kDegrees) << " degrees so far, ";
        } else {
          text << "not at all yet, ";
        }
        text << std::floor(parameters_.start.heading_deviation * kDegrees)
             << " are needed; change the speed or fly a curve, or give a heading, visual pose or "
                "given pose";
      } else {
        // Two fixes of this deviation tell the direction of so long a way well enough.
        const double needed = 1.5 * gps.first_deviation() / parameters_.start.heading_deviation;
        status.waits_for = WaitsFor::kHeading;
        text << "waits for a heading: needs about "
             << std::ceil(std::max(needed - gps.track().extent(), 1.0))
             << " m of motion with GPS, or a heading, visual pose, weld or given pose";
      }
      if (given_fault_ != nullptr) {
        text << "; the given pose is not used: " << given_fault_;
      }
      break;
  }
  status.text = text.str();
  return status;
}

}  // namespace pipescout::estimation
