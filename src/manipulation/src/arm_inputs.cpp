// SPDX-License-Identifier: Apache-2.0
#include "arm_inputs.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace pipescout::manipulation::internal {
namespace {

constexpr double kQuaternionNorm = 1e-3;  // how far it may be off 1: as printed to 4 digits
constexpr double kLargestRate = 100;      // m/s or rad/s: no vehicle is as fast
constexpr double kLargestPixel = 1e5;     // pixels: no image is as large
constexpr double kLeastRange = 0.1;       // m: no arm brings its camera nearer to a pipe on purpose
constexpr double kLargestRange = 1e4;     // m

InputVerdict counted(ArmController::Counts& counts, InputVerdict verdict) noexcept {
  ++counts[static_cast<std::size_t>(verdict)];
  return verdict;
}

bool is_pixel(double value) {
  return std::abs(value) <= kLargestPixel;
}

bool is_number(const PipeSection& section) {
  if (section.state != TrackState::kLocked) {
    return true;  // nothing else of it is used
  }
  return is_pixel(section.u) && is_pixel(section.v) && is_pixel(section.length) &&
         section.length > 0 && std::isfinite(section.angle) &&
         (std::isnan(section.range) ||
          (section.range >= kLeastRange && section.range <= kLargestRange));
}

}  // namespace

ArmInputs::ArmInputs(const ArmControllerParameters& parameters) : parameters_(parameters) {}

void ArmInputs::set_camera(const geometry::Camera& camera) {
  if (camera_ && (camera_->parameters().width != camera.parameters().width ||
                  camera_->parameters().height != camera.parameters().height)) {
    forget_pipe();
  }
  camera_ = camera;
}

void ArmInputs::forget_pipe() noexcept {
  section_time_.reset();
  track_ = TrackState::kNone;
  seen_ = -std::numeric_limits<double>::infinity();
  plane_.forget();
}

void ArmInputs::forget() noexcept {
  joints_time_.reset();
  before_.fill(std::nullopt);
  latest_.fill(std::nullopt);
  R_base_camera_.clear();
  motion_time_.reset();
  R_map_base_.clear();
  forget_pipe();
}

InputVerdict ArmInputs::judge_time(double time, double now, double stale_after,
                                   const std::optional<double>& last) const noexcept {
  if (time > now + parameters_.future_tolerance) {
    return InputVerdict::kFromTheFuture;
  }
  if (now - time > stale_after) {
    return InputVerdict::kStale;
  }
  return last && time <= *last ? InputVerdict::kOutOfOrder : InputVerdict::kTaken;
}

InputVerdict ArmInputs::observe(const ArmModel& model, const JointReadings& readings, double now) {
  return counted(joint_counts, take(model, readings, now));
}

InputVerdict ArmInputs::observe(const PipeSection& section, double now) {
  return counted(section_counts, take(section, now));
}

InputVerdict ArmInputs::observe(const VehicleMotion& motion, double now) {
  return counted(motion_counts, take(motion, now));
}

InputVerdict ArmInputs::take(const ArmModel& model, const JointReadings& readings, double now) {
  if (!std::isfinite(now) || !std::isfinite(readings.time)) {
    return InputVerdict::kNotANumber;
  }
  std::array<std::optional<double>, kMostJoints> read;
  std::optional<double> last;
  bool is_of_arm = false;
  for (std::size_t i = 0; i < model.joints().size(); ++i) {
    const auto found = std::ranges::find(readings.names, model.joints()[i].name);
    const auto place = static_cast<std::size_t>(found - readings.names.begin());
    if (found == readings.names.end() || place >= readings.positions.size()) {
      continue;
    }
    if (!std::isfinite(readings.positions[place])) {
      return InputVerdict::kNotANumber;
    }
    is_of_arm = true;
    read[i] = readings.positions[place];
    last = latest_[i] ? std::max(last.value_or(latest_[i]->time), latest_[i]->time) : last;
  }
  if (!is_of_arm) {
    return InputVerdict::kOfOthers;
  }
  const InputVerdict verdict = judge_time(readings.time, now, parameters_.joints_stale_after, last);
  if (verdict != InputVerdict::kTaken) {
    return verdict;
  }
  for (std::size_t i = 0; i < model.joints().size(); ++i) {
    if (read[i]) {
      add_reading(i, readings.time, *read[i], std::isinf(model.joints()[i].upper));
    }
  }
  return merge(model);
}

void ArmInputs::add_reading(std::size_t joint, double time, double position, bool is_continuous) {
  constexpr double kTurn = 2 * std::numbers::pi;
  before_[joint] = latest_[joint];
  if (is_continuous && latest_[joint]) {
    // Some drivers count turns, and some do not.
    position += kTurn * std::round((latest_[joint]->position - position) / kTurn);
  }
  latest_[joint] = JointReading{time, position};
}

InputVerdict ArmInputs::merge(const ArmModel& model) {
  double common = std::numeric_limits<double>::infinity();
  for (std::size_t i = 0; i < model.joints().size(); ++i) {
    if (!latest_[i]) {
      return InputVerdict::kPartial;
    }
    common = std::min(common, latest_[i]->time);
  }
  if (joints_time_ && common <= *joints_time_) {
    return InputVerdict::kPartial;
  }
  joints_.resize(model.size());
  for (std::size_t i = 0; i < model.joints().size(); ++i) {
    const JointReading& to = *latest_[i];
    const JointReading& from = before_[i].value_or(to);
    const double span = to.time - from.time;
    const double share = span > 0 ? std::clamp((common - from.time) / span, 0.0, 1.0) : 1;
    joints_[static_cast<Eigen::Index>(i)] = std::lerp(from.position, to.position, share);
  }
  joints_time_ = common;
  R_base_camera_.add(common, model.T_base_camera(joints_).rotation(), Eigen::Vector3d::Zero(),
                     parameters_.period / 2);
  return InputVerdict::kTaken;
}

InputVerdict ArmInputs::take(const VehicleMotion& motion, double now) {
  const double norm = motion.R_map_base.norm();
  if (!std::isfinite(now) || !std::isfinite(motion.time) || !std::isfinite(norm) ||
      !(motion.velocity.norm() <= kLargestRate) || !(motion.angular_rate.norm() <= kLargestRate)) {
    return InputVerdict::kNotANumber;
  }
  if (std::abs(norm - 1) > kQuaternionNorm) {
    return InputVerdict::kNoRotation;
  }
  const InputVerdict verdict =
      judge_time(motion.time, now, parameters_.odometry_stale_after, motion_time_);
  if (verdict == InputVerdict::kTaken) {
    motion_time_ = motion.time;
    motion_ = motion;
    R_map_base_.add(motion.time, geometry::SO3::from_quaternion(motion.R_map_base.normalized()),
                    motion.angular_rate, parameters_.period / 2);
  }
  return verdict;
}

InputVerdict ArmInputs::take(const PipeSection& section, double now) {
  if (!std::isfinite(now) || !std::isfinite(section.time) || !is_number(section)) {
    return InputVerdict::kNotANumber;
  }
  const InputVerdict verdict =
      judge_time(section.time, now, parameters_.track_stale_after, section_time_);
  if (verdict != InputVerdict::kTaken) {
    return verdict;
  }
  if (!camera_ || camera_->parameters().width != section.width ||
      camera_->parameters().height != section.height) {
    return InputVerdict::kOtherImageSize;
  }
  if (section.state == TrackState::kLocked) {
    const auto view = view_of(section, *camera_);
    if (!view) {
      return InputVerdict::kNotANumber;
    }
    const auto R_rest_base_then = R_rest_base(section.time);
    const auto R_base_camera_then = R_base_camera_.at(section.time);
    if (!R_rest_base_then || !R_base_camera_then) {
      return InputVerdict::kStale;  // from before the first joint readings or odometry
    }
    const double since = section.time - seen_;
    const double share = parameters_.image_time > 0 && since < parameters_.track_stale_after
                             ? 1 - std::exp(-since / parameters_.image_time)
                             : 1;
    plane_.observe(*R_rest_base_then * (*R_base_camera_then * view->normal),
                   std::isnan(section.range) ? parameters_.usual_range : section.range, share);
    view_ = *view;
    seen_ = section.time;
  }
  section_time_ = section.time;
  track_ = section.state;
  return InputVerdict::kTaken;
}

bool ArmInputs::joints_fresh(double now) const noexcept {
  return joints_time_ && now - *joints_time_ <= parameters_.joints_stale_after;
}

bool ArmInputs::motion_fresh(double now) const noexcept {
  return motion_time_ && now - *motion_time_ <= parameters_.odometry_stale_after &&
         R_map_base_.at(now).has_value();  // a first one may be from the future, a little
}

bool ArmInputs::section_fresh(double now) const noexcept {
  return section_time_ && now - *section_time_ <= parameters_.track_stale_after;
}

std::optional<geometry::SO3> ArmInputs::R_rest_base(double time) const {
  return parameters_.feed_forward ? R_map_base_.at(time) : geometry::SO3();
}

}  // namespace pipescout::manipulation::internal
