// SPDX-License-Identifier: Apache-2.0
// Absolute measurements: which of them the smoother gets, and when it is moved by them.
#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <type_traits>
#include <utility>

#include "estimator_implementation.hpp"
#include "pipescout/linear_algebra/products.hpp"
#include "pipescout/statistics/chi_square.hpp"

namespace pipescout::estimation {
namespace {

using Eigen::Vector3d;
using geometry::SO3;

constexpr double kShakenBefore = 2;  // s, before the last position: it had not shown yet
/// Beyond it a visual pose says nothing of the place in the map.
constexpr double kUnknownRack = 10;  // m
/// A height with a larger standard deviation is none.
constexpr double kNoHeight = 1000;  // m

double square(double x) {
  return x * x;
}

double worst_deviation(const Eigen::Matrix3d& covariance) {
  return std::sqrt(covariance.diagonal().maxCoeff());
}

double spacing_between(double last, double time) {
  constexpr double kLeast = 1e-3;  // s
  return std::max(std::abs(time - last), kLeast);
}

/// s, of a measurement from the one that was used before it.
double spacing_of(double& last, double time) {
  const double spacing = spacing_between(last, time);
  last = time;
  return spacing;
}

/// s, after which the noise of the IMU has moved the position by this variance (m^2), whatever else
/// is known of the motion: of the accelerometer twice integrated, and of tilt and bias three times.
double forgotten_after(const FixedLagSmootherParameters& parameters, double variance) {
  const ImuNoise& noise = parameters.imu_noise;
  const double by_force = square(noise.accelerometer);
  const double by_tilt = square(parameters.gravity * noise.gyro) + square(noise.accelerometer_bias);
  return std::min(std::cbrt(3 * variance / by_force), std::pow(20 * variance / by_tilt, 0.2));
}

/// Of the body, by what is known of the mounting of the camera.
geometry::SE3 mounted_pose(const VisualPoseMeasurement& m, const GlobalStates& globals) {
  return m.mounting < 0 ? m.T_rack_body : m.T_rack_body * mounting_error(m, globals).inverse();
}

struct MountingVariances {
  double position = 0;  // m^2, of the body
  double rotation = 0;  // rad^2
};

MountingVariances mounting_variances(const VisualPoseMeasurement& m, const GlobalVector& known) {
  if (m.mounting < 0) {
    return {};
  }
  const double rotation = known.segment<3>(kOwnStates + m.mounting + 3).maxCoeff();
  return {.position = known.segment<3>(kOwnStates + m.mounting).maxCoeff() +
                      m.camera.squaredNorm() * rotation,
          .rotation = rotation};
}

}  // namespace

WatchedFix StateEstimator::Implementation::fix_of(double time, const Point& point,
                                                  double prediction_variance) const {
  const StateMatrix covariance = smoother_.covariance(smoother_.keyframes() - 1);
  Vector3d variances = covariance.diagonal().segment<3>(kPosition);
  WatchedFix fix;
  fix.time = time;
  fix.measured = point.measured;
  fix.deviation = point.deviation;
  fix.reckoned = point.reckoned;
  fix.velocity_deviation = worst_deviation(covariance.block<3, 3>(kVelocity, kVelocity));
  fix.predicted = SO3::about_z(odom_.yaw()) * point.reckoned + odom_.offset();
  if (!point.has_height || (in_map() && variances.z() > kNoHeight * kNoHeight)) {
    fix.measured.z() = fix.predicted.z();
    variances.z() = 0;
  }
  // Nothing is known of the place while aligning: all is within reach.
  constexpr double kAnywhere = 1e12;
  fix.predicted_deviation =
      in_map() ? std::sqrt(variances.maxCoeff() + prediction_variance) : kAnywhere;
  fix.yaw = odom_.yaw();
  fix.way = odom_.at(time).way;
  fix.witnessed = has_odometer(time);
  fix.shaken = fault_time_ > last_position_ - kShakenBefore;
  fix.borne_out = borne_out_;
  return fix;
}

StateEstimator::Implementation::Point StateEstimator::Implementation::point_of(
    const GpsMeasurement& m) const {
  Point point = {m.position, odom_.at(m.time).T_odom_body * smoother_.globals().gps_lever_arm,
                 worst_deviation(m.covariance)};
  if (m.covariance(2, 2) > kNoHeight * kNoHeight) {
    point.has_height = false;
    point.measured.z() = point.reckoned.z() + odom_.offset().z();
    point.deviation = std::sqrt(m.covariance.diagonal().head<2>().maxCoeff());
  }
  return point;
}

StateEstimator::Implementation::Point StateEstimator::Implementation::point_of(
    const VisualPoseMeasurement& m) const {
  const GlobalStates& globals = smoother_.globals();
  return {globals.R_map_rack * mounted_pose(m, globals).translation() + globals.rack_position,
          odom_.at(m.time).T_odom_body.translation(),
          worst_deviation(m.covariance.topLeftCorner<3, 3>())};
}

WatchedFix StateEstimator::Implementation::fix_of(const GpsMeasurement& m) const {
  return fix_of(m.time, point_of(m), 0);
}

WatchedFix StateEstimator::Implementation::fix_of(const VisualPoseMeasurement& m) const {
  const GlobalVector known = smoother_.global_covariance().diagonal();
  const double rack =
      known.segment<3>(kRackPosition).maxCoeff() +
      m.T_rack_body.translation().squaredNorm() * known.segment<3>(kRackRotation).maxCoeff();
  return fix_of(m.time, point_of(m), rack + mounting_variances(m, known).position);
}

WatchedFix StateEstimator::Implementation::fix_of(const WeldMeasurement& m) const {
  const Point point = {m.position, odom_.at(m.time).T_odom_body * m.sensor,
                       std::max(m.along_deviation, m.across_deviation)};
  return fix_of(m.time, point, 0);
}

WatchedFix StateEstimator::Implementation::fix_of(const HeadingMeasurement& m) const {
  const double in_odom = yaw_of(odom_.at(m.time).T_odom_body.rotation());
  // Angles about the yaw of odom, so that those of one heading are near each other.
  const double claimed = std::remainder(m.heading - in_odom - odom_.yaw(), 2 * std::numbers::pi);
  const StateMatrix covariance = smoother_.covariance(smoother_.keyframes() - 1);
  const double variance = covariance.block<3, 3>(kRotation, kRotation).diagonal().maxCoeff();
  WatchedFix fix;
  fix.time = m.time;
  fix.measured.x() = claimed;
  fix.deviation = m.standard_deviation;
  fix.predicted_deviation = in_map() ? std::sqrt(variance) : std::numbers::pi;
  fix.borne_out = borne_out_;
  return fix;
}

bool StateEstimator::Implementation::another_agrees(Source source) const {
  const auto claim = [&](Source which) -> std::optional<TrackAlignment::Result> {
    const AbsoluteSourceWatch& watch = watch_of(which);
    const double needed =
        which == Source::kGps ? parameters_.gps.takeover : parameters_.visual_pose.takeover;
    return watch.agreed_for() >= needed ? watch.track().solve(odom_.yaw()) : std::nullopt;
  };
  if (source != Source::kGps && source != Source::kVisualPose) {
    return false;
  }
  const auto one = claim(Source::kGps);
  const auto other = claim(Source::kVisualPose);
  constexpr double kSigmas = 4;
  return one && other &&
         (one->offset - other->offset).norm() <=
             kSigmas * std::hypot(one->offset_deviation, other->offset_deviation);
}

bool StateEstimator::Implementation::contested(Source source, double time) const {
  for (const Source other : {Source::kGps, Source::kVisualPose}) {
    const AbsoluteSourceWatch& watch = watch_of(other);
    if (other != source && watch.state() == SourceState::kTrusted &&
        time - watch.last_accepted() < parameters_.gps.outage) {
      return true;
    }
  }
  return false;
}

void StateEstimator::Implementation::widen(const WatchedFix& fix,
                                           const AbsoluteSourceWatch& watch) {
  // What made dead reckoning go wrong has gone through the velocity and the rotation.
  constexpr double kSpeed = 0.2;     // m/s
  constexpr double kRotated = 0.05;  // rad
  const double moved = watch.drift(fix);
  const double off = (fix.measured - fix.predicted).norm();
  const double elapsed = fix.time - watch.last_accepted();
  const double speed = std::max(kSpeed, elapsed > 1 ? off / elapsed : off);
  StateMatrix covariance = smoother_.covariance(smoother_.keyframes() - 1);
  covariance.diagonal().segment<3>(kPosition).array() += moved * moved + off * off;
  covariance.diagonal().segment<3>(kVelocity).array() += speed * speed;
  covariance.diagonal().segment<3>(kRotation).array() += kRotated * kRotated;
  anchor(newest_time(), NavState(newest_state()), covariance, RestartReason::kReacquired);
}

void StateEstimator::Implementation::turn(const Angle& by, RestartReason reason) {
  NavState mean = newest_state();
  StateMatrix covariance = smoother_.covariance(smoother_.keyframes() - 1);
  const Vector3d up = mean.R_map_body.inverse() * Vector3d::UnitZ();
  mean.R_map_body = SO3::about_z(by.value) * mean.R_map_body;
  covariance.block<3, 3>(kRotation, kRotation) += by.deviation * by.deviation * up * up.transpose();
  // Whether the velocity is to be turned with it, others have to tell.
  const double turned = std::min(std::hypot(by.value, by.deviation), 2.0);
  covariance.diagonal().segment<3>(kVelocity).array() +=
      turned * turned * mean.velocity.squaredNorm();
  anchor(newest_time(), mean, covariance, reason);
}

std::optional<StateEstimator::Implementation::Placement>
StateEstimator::Implementation::placement_of(const TrackAlignment& track) const {
  constexpr double kMostMisfit = 4;  // chi-square by degrees; dead reckoning is part of it
  constexpr double kSigmas = 4;
  const auto fits = [&](const std::optional<TrackAlignment::Result>& r) {
    return r && r->chi_square <= kMostMisfit * std::max(r->degrees, 1);
  };
  const auto placement = [](const TrackAlignment::Result& r, double yaw_deviation) {
    return Placement{.yaw = r.yaw,
                     .yaw_deviation = yaw_deviation,
                     .offset = r.offset,
                     .offset_deviation = r.offset_deviation,
                     .drift = r.drift,
                     .drift_deviation = r.drift_deviation};
  };
  const auto turned = track.solve();
  if (fits(turned) && turned->yaw_deviation <= parameters_.start.heading_deviation &&
      std::abs(turned->scale - 1) <= kSigmas * turned->scale_deviation) {
    return placement(*turned, turned->yaw_deviation);
  }
  const auto straight = track.solve(odom_.yaw());
  if (fits(straight)) {
    return placement(*straight, 0);
  }
  return std::nullopt;
}

void StateEstimator::Implementation::place(const Placement& placement, RestartReason reason) {
  const NavState& old = newest_state();
  const geometry::SE3 in_odom = odom_.plain(old);
  const SO3 turn = SO3::about_z(placement.yaw - odom_.yaw());
  NavState mean = old;
  mean.R_map_body = turn * old.R_map_body;
  mean.position = SO3::about_z(placement.yaw) * in_odom.translation() + placement.offset;
  mean.velocity = turn * old.velocity + placement.drift;

  StateMatrix to_map = StateMatrix::Identity();
  to_map.block<3, 3>(kVelocity, kVelocity) = turn.matrix();
  StateMatrix covariance =
      linear_algebra::propagate(to_map, smoother_.covariance(smoother_.keyframes() - 1));
  covariance.middleRows<3>(kPosition).setZero();
  covariance.middleCols<3>(kPosition).setZero();
  covariance.diagonal().segment<3>(kPosition).setConstant(placement.offset_deviation *
                                                          placement.offset_deviation);
  if (!height_is_known_) {
    covariance(kPosition + 2, kPosition + 2) = kNoHeight * kNoHeight;
  }
  covariance.diagonal().segment<3>(kVelocity).array() +=
      placement.drift_deviation * placement.drift_deviation;
  StateVector by_yaw = StateVector::Zero();
  by_yaw.segment<3>(kRotation) = mean.R_map_body.inverse() * Vector3d::UnitZ();
  by_yaw.segment<3>(kVelocity) = Vector3d::UnitZ().cross(mean.velocity);
  covariance += placement.yaw_deviation * placement.yaw_deviation * by_yaw * by_yaw.transpose();
  anchor(newest_time(), mean, covariance, reason);
}

bool StateEstimator::Implementation::take_over(Source source, const WatchedFix& fix) {
  if (source == Source::kHeading) {
    turn({fix.measured.x(), fix.deviation}, RestartReason::kTakenOver);
  } else {
    const std::optional<Placement> placement = placement_of(watch_of(source).track());
    if (!placement) {
      return false;
    }
    place(*placement, RestartReason::kTakenOver);
    for (const Source other : {Source::kGps, Source::kVisualPose, Source::kWeld}) {
      watch_of(other).distrust(fix.time, odom_.way());
    }
    borne_out_ = 0;
  }
  watch_of(source).trust(fix.time, odom_.way());
  return true;
}

void StateEstimator::Implementation::see(const VisualPoseMeasurement& m, const WatchedFix& fix) {
  const GlobalVector known = smoother_.global_covariance().diagonal();
  const double rack = std::sqrt(known.segment<3>(kRackPosition).maxCoeff());
  if (rack > kUnknownRack) {
    return;
  }
  // The rack's own error is in what follows too: as it was at the start, so that it is not counted
  // for less than it is.
  // The mounting of the camera is to be learnt from what follows: a state that is placed by it must
  // not count as another witness of it.
  constexpr double kNoWitness = 9;  // times its variance
  const MountingVariances mounting = mounting_variances(m, known);
  seen_place_ = Point{
      fix.measured, fix.reckoned,
      std::sqrt(fix.deviation * fix.deviation + rack * rack + kNoWitness * mounting.position)};
  const GlobalStates& globals = smoother_.globals();
  const SO3 body = globals.R_map_rack * mounted_pose(m, globals).rotation();
  const Eigen::Matrix3d turn = (body * odom_.at(m.time).T_odom_body.rotation().inverse()).matrix();
  const double variance = m.covariance.bottomRightCorner<3, 3>().diagonal().maxCoeff() +
                          known.segment<3>(kRackRotation).maxCoeff() +
                          kNoWitness * mounting.rotation;
  seen_yaw_ =
      Angle{std::atan2(turn(1, 0) - turn(0, 1), turn(0, 0) + turn(1, 1)), std::sqrt(variance)};
}

void StateEstimator::Implementation::see(const WeldMeasurement& m, const WatchedFix& fix) {
  passed_place_ = Point{fix.measured, fix.reckoned, fix.deviation};
  if (parameters_.start.heading_from_weld && m.direction.head<2>().norm() > 0.1) {
    const double in_odom = yaw_of(odom_.at(m.time).T_odom_body.rotation());
    passed_yaw_ = Angle{std::atan2(m.direction.y(), m.direction.x()) - in_odom,
                        parameters_.start.weld_heading_deviation};
  }
}

void StateEstimator::Implementation::reassign(const WeldMeasurement& m) {
  if (parameters_.tally.empty()) {
    return;
  }
  const PipeCentreLine& line = *parameters_.centre_line;
  const WatchedFix fix = fix_of(m);
  const double chainage = line.chainage_of(fix.predicted, chainage_);
  constexpr int kDegrees = 3;
  const double gate = statistics::chi_square_quantile(parameters_.weld.gate_probability, kDegrees);
  const double reach = std::sqrt(gate) * std::hypot(fix.predicted_deviation, m.along_deviation);
  const auto weld = std::ranges::lower_bound(parameters_.tally, chainage - reach);
  const auto next = std::ranges::upper_bound(parameters_.tally, chainage + reach);
  if (next - weld != 1) {
    return;
  }
  const auto passed = line.weld(m.time, *weld, m.along_deviation, m.across_deviation, m.sensor);
  // That is the one it was said to be: then it is something else that is wrong.
  if (!passed || (passed->position - m.position).norm() <= reach) {
    return;
  }
  if (smoother_.add(*passed) == Outcome::kWaiting) {
    reassigned_time_ = m.time;
  }
}

double StateEstimator::Implementation::covariance_factor_of(Source source, double time) noexcept {
  const double spacing = spacing_of(last_used_[index_of(source)], time);
  return watch_of(source).covariance_scale(spacing);
}

double StateEstimator::Implementation::covariance_factor_of(const GpsMeasurement& m) {
  const double elapsed = std::max(m.time - last_used_[index_of(Source::kGps)], 0.0);
  const double factor = covariance_factor_of(Source::kGps, m.time);
  // Of those that come together each but the first would find the state as the first did.
  const bool first = std::exchange(gps_used_at_, updates_ + 1) != updates_ + 1;
  const AbsoluteSourceWatch& watch = watch_of(Source::kGps);
  if (!first || !in_map() || watch.correlation_time() == 0) {
    return factor;
  }
  const double scale = watch.deviation_factor() * watch.deviation_factor();
  const StateMatrix covariance = smoother_.covariance(smoother_.keyframes() - 1);
  double surplus = std::numeric_limits<double>::infinity();
  for (int axis = 0; axis < 3; ++axis) {
    if (m.covariance(axis, axis) < kNoHeight * kNoHeight) {
      surplus = std::min(surplus, covariance(kPosition + axis, kPosition + axis) /
                                      (scale * m.covariance(axis, axis)));
    }
  }
  // By its own share a fix is worth what is new in it.
  const double own_share = scale / factor;
  const double wanted = surplus > 1 ? (surplus - 1) / surplus : 0;
  const double worst = scale * square(point_of(m).deviation);
  const double kept = std::exp(-elapsed / forgotten_after(parameters_.smoother, worst));
  gps_counted_ = std::max(kept * gps_counted_ - own_share, 0.0);
  const double share = std::max(own_share, std::min(wanted, 1 - gps_counted_));
  gps_counted_ += share;
  return scale / share;
}

double StateEstimator::Implementation::height_factor_of(const GpsMeasurement& m, double factor,
                                                        double spacing) const {
  const AbsoluteSourceWatch& watch = watch_of(Source::kGps);
  const double time = parameters_.gps.height_correlation_time;
  if (!(time > watch.correlation_time())) {
    return 1;
  }
  const double scale = square(watch.deviation_factor());
  double wanted = scale * covariance_factor(time, spacing);
  // As of positions: a state that is less sure becomes as sure as the fix.
  const StateMatrix covariance = smoother_.covariance(smoother_.keyframes() - 1);
  const double known = covariance(kPosition + 2, kPosition + 2);
  const double stated = scale * m.covariance(2, 2);
  if (known > stated) {
    wanted = std::min(wanted, scale * known / (known - stated));
  }
  return std::max(wanted / factor, 1.0);
}

template <class Measurement>
void StateEstimator::Implementation::use(Measurement m) noexcept {
  if constexpr (std::is_same_v<Measurement, GpsMeasurement>) {
    const double spacing = spacing_between(last_used_[index_of(Source::kGps)], m.time);
    const double factor = covariance_factor_of(m);
    const double height = std::sqrt(height_factor_of(m, factor, spacing));
    m.covariance *= factor;
    m.covariance.row(2) *= height;
    m.covariance.col(2) *= height;
  } else if constexpr (!std::is_same_v<Measurement, RelativePoseMeasurement>) {
    const double factor = covariance_factor_of(source_of(m), m.time);
    if constexpr (std::is_same_v<Measurement, HeadingMeasurement>) {
      m.standard_deviation *= std::sqrt(factor);
    } else if constexpr (std::is_same_v<Measurement, WeldMeasurement>) {
      m.along_deviation *= std::sqrt(factor);
      m.across_deviation *= std::sqrt(factor);
      claimed_weld_ = m;
    } else {
      m.covariance *= factor;
    }
  }
  const Outcome outcome = smoother_.add(m);
  if (outcome != Outcome::kWaiting) {
    refuse(source_of(m), outcome);
  }
}

void StateEstimator::Implementation::hear_in_motion(GpsMeasurement m) {
  if (!in_motion_.begun()) {
    return;
  }
  std::optional<InMotionAlignment::Standstill> standstill;
  if (status_.standing_still) {
    standstill = {parameters_.standstill.velocity_deviation, window_.sums().mean_rate(),
                  parameters_.standstill.rate_deviation};
  }
  m.covariance *= covariance_factor_of(Source::kGps, m.time);
  const auto verdict = in_motion_.add(m, smoother_.globals().gps_lever_arm, standstill);
  told_in_motion_ |= verdict == InMotionAlignment::Verdict::kUsed;
  contradicted_in_motion_ |= verdict == InMotionAlignment::Verdict::kContradicts;
}

template <class Measurement>
void StateEstimator::Implementation::offer(const Measurement& m) noexcept {
  if constexpr (std::is_same_v<Measurement, GpsMeasurement> ||
                std::is_same_v<Measurement, VisualPoseMeasurement>) {
    const Point point = point_of(m);
    constexpr bool kGps = std::is_same_v<Measurement, GpsMeasurement>;
    const GlobalStates& globals = smoother_.globals();
    const double late = kGps ? globals.gps_time_offset : globals.visual_pose_time_offset;
    const Vector3d predicted = SO3::about_z(odom_.yaw()) * point.reckoned + odom_.offset() +
                               late * newest_state().velocity;
    watch_of(source_of(m))
        .offer({.time = m.time,
                .measured = point.measured,
                .reckoned = point.reckoned,
                .deviation = point.deviation,
                .way = odom_.at(m.time).way},
               odom_.yaw(), (point.measured - predicted).head<2>());
  }
}

template <class Measurement>
void StateEstimator::Implementation::judge(const Measurement& m) {
  const Source source = source_of(m);
  AbsoluteSourceWatch& watch = watch_of(source);
  if (phase_ == Phase::kAligning) {
    if (watch.agreed_for() > parameters_.start.longest_alignment) {
      watch.distrust(m.time, odom_.way());
    }
    const std::size_t before = watch.agreeing();
    const WatchedFix fix = fix_of(m);
    watch.compare(fix);
    ++status_of(source).held;
    if (watch.agreeing() != before) {
      see(m, fix);
    }
    if constexpr (std::is_same_v<Measurement, GpsMeasurement>) {
      height_is_known_ |= m.covariance(2, 2) <= kNoHeight * kNoHeight;
    } else {
      height_is_known_ |= source != Source::kHeading;
    }
    if constexpr (std::is_same_v<Measurement, GpsMeasurement>) {
      hear_in_motion(m);
    }
    return;
  }
  watch.expire(m.time);
  if (watch.state() == SourceState::kTrusted) {
    offer(m);
    use(m);
    return;
  }
  WatchedFix fix = fix_of(m);
  fix.contested = contested(source, m.time);
  if (another_agrees(source)) {
    fix.borne_out = 0;
    fix.contested = false;
  }
  const Verdict verdict = watch.judge(fix);
  if (verdict == Verdict::kHold || (verdict == Verdict::kTakeOver && !take_over(source, fix))) {
    SourceStatus& status = status_of(source);
    ++status.held;
    status.held_distance = (fix.measured - fix.predicted).norm();
    if constexpr (std::is_same_v<Measurement, WeldMeasurement>) {
      reassign(m);
    }
    return;
  }
  if (verdict == Verdict::kAcquire) {
    // Beyond that the smoother's gate could refuse what is within reach. Not what another source
    // has made sure of: there it is the rack, or the new source, that is off.
    constexpr double kNear = 4;
    const double expected =
        fix.deviation * fix.deviation + fix.predicted_deviation * fix.predicted_deviation;
    const double off = (fix.measured - fix.predicted).squaredNorm();
    const bool state_is_off = contradicted_[index_of(source)] || !contested(source, m.time);
    if (off > kNear * expected && state_is_off) {
      if (source == Source::kHeading) {
        turn({0, std::sqrt(off)}, RestartReason::kReacquired);
      } else {
        widen(fix, watch);
      }
    }
  }
  contradicted_[index_of(source)] = false;
  offer(m);
  use(m);
}

void StateEstimator::Implementation::feed(const Pending& pending) {
  std::visit(
      [&](const auto& m) {
        if constexpr (std::is_same_v<std::decay_t<decltype(m)>, RelativePoseMeasurement>) {
          use(m);
        } else {
          judge(m);
        }
      },
      pending.measurement);
}

void StateEstimator::Implementation::feed(const AnyFactor& factor) {
  SourceStatus& status = *status_of(factor.kind());
  if (factor.needs_map() && !in_map()) {
    ++status.held;
    return;
  }
  const std::size_t source = own_index_of(factor.kind());
  AnyFactor used = factor;
  if (const double correlation = parameters_.own_sources[source].correlation_time;
      correlation > 0) {
    used.scale_covariance(
        covariance_factor(correlation, spacing_of(own_last_used_[source], factor.to_time())));
  }
  const Outcome outcome = smoother_.add(used);
  if (outcome != Outcome::kWaiting) {
    refuse(status, outcome);
  }
}

}  // namespace pipescout::estimation
