// SPDX-License-Identifier: Apache-2.0
// From nothing to a level body, and from there to its place and heading in the map.
#include <algorithm>
#include <array>
#include <cmath>
#include <iomanip>
#include <locale>
#include <numbers>
#include <sstream>

#include "direction_of_travel.hpp"
#include "estimator_implementation.hpp"
#include "pipescout/linear_algebra/products.hpp"

namespace pipescout::estimation {
namespace {

using Eigen::Vector3d;
using geometry::SE3;
using geometry::SO3;

// Beyond them, those of GivenPose, it tells nothing.
constexpr double kLargestGivenDeviation = 1e4;  // m
constexpr double kLargestGivenAngle = 1;        // rad

constexpr double kKnown = 1e-3;  // m and rad of the yaw, where the axes are those of the body

/// "+x", "-z": the axis that is nearest to a direction.
std::string axis_of(const Vector3d& direction) {
  Eigen::Index which = 0;
  direction.cwiseAbs().maxCoeff(&which);
  constexpr std::array<char, 3> kAxes = {'x', 'y', 'z'};
  return std::string(direction[which] < 0 ? "-" : "+") + kAxes[static_cast<std::size_t>(which)];
}

}  // namespace

std::string StateEstimator::Implementation::fault_of(const Vector3d& mean_force, bool still) const {
  constexpr double kInG = 0.2;      // what a sound IMU in g may be off by
  constexpr double kRemoved = 0.1;  // of gravity, and less: no scale does that
  const double gravity = parameters_.smoother.gravity;
  const double norm = mean_force.norm();
  const double reading = norm / parameters_.specific_force_scale;
  const bool sound = std::abs(norm - gravity) <= parameters_.start.gravity_tolerance * gravity;
  const bool in_g = !sound && std::abs(reading - 1) < kInG;
  const Vector3d up = mean_force / norm;
  const double tilt = std::acos(std::clamp(up.z(), -1.0, 1.0));
  const bool turned = sound && tilt > parameters_.start.largest_tilt;
  // What moves may show any force for a while.
  if (!turned && !in_g && (sound || !still)) {
    return {};
  }
  std::ostringstream text;
  text.imbue(std::locale::classic());
  text << std::setprecision(3);
  if (turned) {
    const std::string axis = axis_of(parameters_.R_body_imu.inverse() * up);
    text << "gravity shows the IMU's " << axis << " axis up, "
         << std::round(tilt * 180 / std::numbers::pi) << " degrees from the body's z axis by "
         << "R_body_imu: " << (tilt > 0.75 * std::numbers::pi ? "upside down" : "turned")
         << "; set R_body_imu so that it maps the IMU's " << axis
         << " axis to the body's +z, or put the vehicle upright";
  } else if (in_g) {
    text << "the IMU shows gravity as " << reading
         << ": it measures in g; set specific_force_scale to 9.80665";
  } else if (norm < kRemoved * gravity) {
    text << "the accelerometer shows " << norm
         << " m/s^2 and no gravity: it has been taken out of the readings; use those of the sensor "
            "itself, which show it";
  } else {
    text << "the IMU shows gravity as " << norm << " m/s^2 instead of " << gravity
         << ": set specific_force_scale to " << parameters_.specific_force_scale * gravity / norm
         << ", or have the accelerometer checked";
  }
  return text.str();
}

void StateEstimator::Implementation::gather(const ImuSample& sample) {
  constexpr double kLongestGap = 0.2;  // s
  constexpr double kStep = 1e-9;
  constexpr double kLongest = 2;  // times the levelling
  if (levelling_.count > 0 && sample.time - levelling_end_ > kLongestGap) {
    levelling_ = {};
  }
  trail_.add(sample);
  levelling_.add(sample);
  levelling_end_ = sample.time + sample.duration;
  if (levelling_.duration < parameters_.start.levelling - kStep) {
    return;
  }
  const StartParameters& start = parameters_.start;
  const bool still = levelling_.rate_deviation() <= start.still_rate &&
                     levelling_.force_deviation() <= start.still_force &&
                     levelling_.mean_rate().norm() <= start.largest_gyro_bias &&
                     !wheels_turn(levelling_end_ - levelling_.duration, levelling_end_);
  const Vector3d force = levelling_.mean_force();
  const double gravity = parameters_.smoother.gravity;
  fault_ = fault_of(force, still);
  phase_ = fault_.empty() ? Phase::kStarting : Phase::kFault;
  // An odometer that is there, but does not tell the motion yet, is worth some more of it: to begin
  // without one makes a pose that was given as unsure as a robot of that kind is quick.
  const bool odometer_is_to_tell = has_odometer(levelling_end_) && !motion_at(levelling_end_);
  if (fault_.empty() && odometer_is_to_tell && levelling_.duration < kLongest * start.levelling) {
    return;
  }
  if (fault_.empty() && std::abs(force.norm() - gravity) <= start.gravity_tolerance * gravity) {
    begin_reckoning(levelling_end_, still);
  }
  levelling_ = {};
}

std::optional<OdometerIntake::Motion> StateEstimator::Implementation::motion_at(
    double time) const noexcept {
  // The part of the levelling that the odometer may be expected to cover.
  const double covered = 0.5 * parameters_.start.levelling;
  return has_odometer(time) ? odometer_.motion(std::min(odometer_.newest(), time), covered)
                            : std::nullopt;
}

void StateEstimator::Implementation::begin_reckoning(double time, bool still) {
  constexpr double kStillSpeed = 0.05;
  const StartParameters& start = parameters_.start;
  const Vector3d rate = levelling_.mean_rate();
  Vector3d force = levelling_.mean_force();
  NavState mean;
  StateVector deviations;
  double tilt = start.accelerometer_bias_deviation / parameters_.smoother.gravity;
  double speed = kStillSpeed;
  double gyro_bias = 2 * start.still_rate / std::sqrt(static_cast<double>(levelling_.count));
  const auto motion = motion_at(time);
  const bool moving = motion && std::abs(motion->speed) > kStillSpeed;
  seems_still_ = still && !motion && !parameters_.standstill.by_imu;
  Vector3d velocity = Vector3d::Zero();
  if (still && !moving) {
    mean.gyro_bias = rate;
  } else {
    still = false;
    tilt = start.moving_tilt_deviation;
    gyro_bias = start.largest_gyro_bias;
    speed = start.largest_speed + kStillSpeed;
    if (motion) {
      velocity.x() = motion->speed;
      speed = kStillSpeed + 0.1 * std::abs(motion->speed);
      force -= Vector3d(motion->acceleration, rate.z() * motion->speed, 0);
    }
  }
  mean.R_map_body = *estimation::level(force);
  const Eigen::Matrix3d to_travel = DirectionOfTravel(smoother_.globals()).R_travel_body;
  const double unknown_speed = start.hover_speed > 0 ? start.hover_speed : start.largest_speed;
  StartTrail::Motion moved = {
      .gyro_bias = mean.gyro_bias,
      .gyro_bias_deviation = gyro_bias,
      .speed_deviation = motion ? speed : unknown_speed,
      .odometer_scale = smoother_.globals().odometer_scale,
      .travel = to_travel.transpose() * Vector3d::UnitX(),
      .sensor = parameters_.odometer.sensor,
  };
  if (still && !seems_still_) {
    moved.stands_from = time - levelling_.duration;
  }
  if (motion) {
    moved.speed = motion->speed;
  }
  trail_.settle(SE3(mean.R_map_body, Vector3d::Zero()), moved, odometer_);
  const SE3 shown = continue_odom();
  const SE3 begin = trail_.at(trail_.ends())->pose;
  mean.R_map_body = begin.rotation();
  mean.position = begin.translation();
  mean.velocity = mean.R_map_body * velocity;
  deviations << Vector3d::Constant(kKnown), tilt, tilt, kKnown, Vector3d::Constant(speed),
      Vector3d::Constant(gyro_bias), Vector3d::Constant(start.accelerometer_bias_deviation);
  StateMatrix covariance = deviations.cwiseAbs2().asDiagonal();
  // Tilt and yaw are about the axes of the map; a rotation is perturbed in the body.
  const Eigen::Matrix3d to_body = mean.R_map_body.inverse().matrix();
  covariance.block<3, 3>(kRotation, kRotation) =
      to_body * covariance.block<3, 3>(kRotation, kRotation) * to_body.transpose();

  if (!motion) {
    begin_in_motion(time, mean, deviations, still);
  }
  smoother_.restart(time, mean, covariance);
  odom_.forget();
  odom_.record(time, mean, true);
  odom_.make_up(time, mean, shown);
  good_time_ = time;
  good_state_ = mean;
  good_covariance_ = covariance;
  odometer_until_ = time;
  reckons_since_ = time;
  still_since_start_ = still;
  window_.forget();
  pending_.clear();
  for (AbsoluteSourceWatch& watch : watches_) {
    watch.distrust(time, 0);
  }
  phase_ = Phase::kAligning;
  place_given();
}

SE3 StateEstimator::Implementation::continue_odom() {
  const SE3 first = trail_.at(trail_.begins())->pose;
  const SE3 last = trail_.at(trail_.ends())->pose;
  if (!last_odom_) {
    return last;
  }
  const SO3 turn = SO3::about_z(yaw_of(last_odom_->rotation()) - yaw_of(first.rotation()));
  trail_.move(SE3(turn, last_odom_->translation() - turn * first.translation()));
  if (given_ && given_->T_odom_body) {
    if (const auto since = trail_.at(odom_ended_)) {
      widen_given(since->position_deviation, since->heading_deviation);
    }
  }
  return *last_odom_ * first.inverse() * last;
}

void StateEstimator::Implementation::place_given() {
  if (!given_ || given_->T_odom_body) {
    return;
  }
  const double time = given_->pose.time;
  if (time > newest_time()) {
    if (time > newest_time() + parameters_.longest_wait) {
      give_up_given("its stamp is ahead of the IMU by more than longest_wait");
    }
    return;
  }
  const OdomFrame::Place oldest = odom_.at(odom_.begins());
  if (time >= odom_.begins()) {
    given_->T_odom_body = odom_.at(time).T_odom_body;
  } else if (const auto place = trail_.at(time)) {
    given_->T_odom_body = place->pose;
    widen_given(place->position_deviation, place->heading_deviation);
  } else {
    // Between the levelling and what is remembered: it may have been anywhere on that way.
    given_->T_odom_body = oldest.T_odom_body;
    const SO3 begin = trail_.at(trail_.ends())->pose.rotation();
    widen_given(oldest.way, (begin.inverse() * oldest.T_odom_body.rotation()).log().norm());
  }
}

void StateEstimator::Implementation::widen_given(double position, double heading) {
  GivenPose& pose = given_->pose;
  pose.position_deviation = std::hypot(pose.position_deviation, position);
  pose.heading_deviation = std::hypot(pose.heading_deviation, heading);
  if (!(pose.position_deviation <= kLargestGivenDeviation)) {
    pose.position.reset();
  }
  if (!(pose.heading_deviation <= kLargestGivenAngle)) {
    pose.heading.reset();
  }
  if (!pose.position && !pose.heading) {
    give_up_given("how the vehicle has moved since its stamp is not known");
  }
}

void StateEstimator::Implementation::give_up_given(const char* why) noexcept {
  given_.reset();
  given_fault_ = why;
}

void StateEstimator::Implementation::begin_in_motion(double time, const NavState& seeming,
                                                     const StateVector& deviations, bool still) {
  const StartParameters& start = parameters_.start;
  const StartHypothesis stands = {.mean = seeming,
                                  .tilt_deviation = deviations[kRotation],
                                  .velocity_deviation = deviations[kVelocity],
                                  .gyro_bias_deviation = deviations[kGyroBias],
                                  .accelerometer_bias_deviation = deviations[kAccelerometerBias],
                                  .stands = still};
  StartHypothesis moves = stands;
  moves.mean.gyro_bias.setZero();
  moves.tilt_deviation = start.moving_tilt_deviation;
  moves.velocity_deviation = start.largest_speed;
  moves.gyro_bias_deviation = start.largest_gyro_bias;
  moves.stands = false;
  const std::array<StartHypothesis, 2> either = {stands, moves};
  in_motion_.begin(time, either.data(), seems_still_ ? 2 : 1);
  told_in_motion_ = contradicted_in_motion_ = false;
  heading_deviation_ = std::numeric_limits<double>::quiet_NaN();
}

std::optional<StateEstimator::Implementation::Angle> StateEstimator::Implementation::start_yaw()
    const {
  std::optional<Angle> best;
  const auto offer = [&](double value, double deviation) {
    if (!best || deviation < best->deviation) {
      best = Angle{value, deviation};
    }
  };
  const double enough = parameters_.start.heading_deviation;
  if (given_ && given_->T_odom_body && given_->pose.heading) {
    offer(*given_->pose.heading - yaw_of(given_->T_odom_body->rotation()),
          given_->pose.heading_deviation);
  }
  const AbsoluteSourceWatch& headings = watch_of(Source::kHeading);
  if (headings.agreeing() >= parameters_.heading.agreeing) {
    if (const auto turned = headings.track().solve(0);
        turned && turned->offset_deviation <= enough) {
      offer(odom_.yaw() + turned->offset.x(), turned->offset_deviation);
    }
  }
  if (seen_yaw_ && seen_yaw_->deviation <= enough &&
      watch_of(Source::kVisualPose).agreeing() >= parameters_.visual_pose.agreeing) {
    offer(seen_yaw_->value, seen_yaw_->deviation);
  }
  if (passed_yaw_) {
    offer(passed_yaw_->value, passed_yaw_->deviation);
  }
  const AbsoluteSourceWatch& gps = watch_of(Source::kGps);
  if (!in_motion_.begun() && gps.agreeing() >= parameters_.start.position_fixes) {
    const auto placement = placement_of(gps.track());
    if (placement && placement->yaw_deviation > 0) {
      offer(placement->yaw, placement->yaw_deviation);
    }
  }
  return best;
}

std::optional<StateEstimator::Implementation::Placement>
StateEstimator::Implementation::start_place(const Angle& yaw) const {
  std::optional<Placement> best;
  const auto offer = [&](const Placement& placement) {
    if (!best || placement.offset_deviation < best->offset_deviation) {
      best = placement;
    }
  };
  const Vector3d here = odom_.plain(newest_state()).translation();
  const auto offer_point = [&](const Point& point) {
    const double moved = (here - point.reckoned).norm();
    const double turned = yaw.deviation * moved;
    offer({.yaw = yaw.value,
           .yaw_deviation = yaw.deviation,
           .offset = point.measured - SO3::about_z(yaw.value) * point.reckoned,
           .offset_deviation = std::sqrt(point.deviation * point.deviation + turned * turned +
                                         parameters_.gps.drift_share * parameters_.gps.drift_share *
                                             moved * moved)});
  };
  const AbsoluteSourceWatch& gps = watch_of(Source::kGps);
  if (!in_motion_.begun() && gps.agreeing() >= parameters_.start.position_fixes) {
    if (const auto track = gps.track().solve(yaw.value)) {
      offer({.yaw = yaw.value,
             .yaw_deviation = yaw.deviation,
             .offset = track->offset,
             .offset_deviation =
                 std::hypot(track->offset_deviation, yaw.deviation * gps.track().extent()),
             .drift = track->drift,
             .drift_deviation = track->drift_deviation});
    }
  }
  if (seen_place_ && watch_of(Source::kVisualPose).agreeing() >= parameters_.visual_pose.agreeing) {
    offer_point(*seen_place_);
  }
  if (passed_place_) {
    offer_point(*passed_place_);
  }
  if (given_ && given_->T_odom_body && given_->pose.position) {
    offer_point({*given_->pose.position, given_->T_odom_body->translation(),
                 given_->pose.position_deviation});
  }
  return best;
}

bool StateEstimator::Implementation::align_in_motion() {
  if (!told_in_motion_) {
    return false;
  }
  told_in_motion_ = false;
  const double time = newest_time();
  std::optional<InMotionAlignment::Heading> heading;
  if (const std::optional<Angle> yaw = start_yaw(); yaw) {
    heading = {yaw->value + yaw_of(odom_.plain(newest_state()).rotation()), yaw->deviation};
  }
  const auto result = in_motion_.solve(time, heading);
  heading_deviation_ =
      result ? result->heading_deviation : std::numeric_limits<double>::quiet_NaN();
  if (!result || result->positions < parameters_.start.position_fixes ||
      result->heading_deviation > parameters_.start.heading_deviation) {
    return false;
  }
  anchor(time, result->state, result->covariance, RestartReason::kNone);
  return true;
}

void StateEstimator::Implementation::align() {
  place_given();
  if (!status_.standing_still &&
      newest_time() - reckons_since_ > 2 * parameters_.standstill.window) {
    still_since_start_ = false;
  }
  if (in_motion_.begun() && (contradicted_in_motion_ || has_odometer(newest_time()))) {
    level_again();
    return;
  }
  if (align_in_motion()) {
    run();
    watch_of(Source::kGps).trust(newest_time(), odom_.way());
    return;
  }
  const std::optional<Angle> yaw = start_yaw();
  if (!yaw) {
    return;
  }
  const std::optional<Placement> placement = start_place(*yaw);
  if (!placement) {
    return;
  }
  height_is_known_ |= given_ && given_->T_odom_body && given_->pose.position;
  place(*placement, RestartReason::kNone);
  if (seems_still_) {
    const StartParameters& start = parameters_.start;
    StateVector deviations = StateVector::Zero();
    deviations.segment<3>(kRotation).setConstant(start.moving_tilt_deviation);
    deviations.segment<3>(kVelocity).setConstant(start.largest_speed);
    deviations.segment<3>(kGyroBias).setConstant(start.largest_gyro_bias);
    StateMatrix covariance = smoother_.covariance(smoother_.keyframes() - 1);
    covariance.diagonal() += deviations.cwiseAbs2();
    anchor(newest_time(), NavState(newest_state()), covariance, RestartReason::kNone);
  }
  run();
}

void StateEstimator::Implementation::run() {
  phase_ = Phase::kRunning;
  const double time = newest_time();
  for (const Source source : {Source::kGps, Source::kVisualPose, Source::kHeading, Source::kWeld}) {
    AbsoluteSourceWatch& watch = watch_of(source);
    if (watch.agreeing() > 0 || source == Source::kWeld) {
      watch.trust(time, odom_.way());
    } else {
      watch.distrust(time, odom_.way());
    }
  }
  in_motion_.end();
  given_.reset();
  given_fault_ = nullptr;
  borne_out_ = 0;
}

void StateEstimator::Implementation::forget_heading() {
  constexpr double kLargest = 0.1;  // rad, deviation for which turning is still linear
  StateMatrix covariance = good_covariance_;
  const NavState mean = good_state_;
  StateVector by_yaw = StateVector::Zero();
  by_yaw.segment<3>(kRotation) = mean.R_map_body.inverse() * Vector3d::UnitZ();
  by_yaw.segment<3>(kVelocity) = Vector3d::UnitZ().cross(mean.velocity);
  StateVector to_yaw = StateVector::Zero();
  to_yaw.segment<3>(kRotation) = by_yaw.segment<3>(kRotation);
  if (to_yaw.dot(covariance * to_yaw) < kLargest * kLargest) {
    return;
  }
  const StateMatrix without_yaw = StateMatrix::Identity() - by_yaw * to_yaw.transpose();
  covariance = linear_algebra::propagate(without_yaw, covariance);
  covariance.middleRows<3>(kPosition).setZero();
  covariance.middleCols<3>(kPosition).setZero();
  covariance.diagonal().segment<3>(kPosition).setConstant(kKnown * kKnown);
  covariance += kKnown * kKnown * by_yaw * by_yaw.transpose();
  anchor(good_time_, mean, covariance, RestartReason::kNone);
}

void StateEstimator::Implementation::level_again() noexcept {
  const FixedLagSmoother::Propagated shown = *smoother_.propagated();
  last_odom_ = odom_.smooth(shown.time, shown.state);
  odom_ended_ = shown.time;
  in_motion_.end();
  levelling_ = {};
  phase_ = Phase::kStarting;
}

}  // namespace pipescout::estimation
