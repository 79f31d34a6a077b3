// SPDX-License-Identifier: Apache-2.0
#include "pipescout/rack_vision/rack_localization.hpp"

#include <algorithm>
#include <cmath>
#include <string_view>
#include <vector>

#include "flow_frame.hpp"
#include "pipescout/validation/check.hpp"
#include "pose_belief.hpp"

namespace pipescout::rack_vision {
namespace {

using geometry::Matrix6d;
using geometry::SE3;
using geometry::SO3;

// What the image alone does not say better, whatever its contours seem to say: one of them may be
// taken for another.
constexpr double kFoundDeviation = 0.03;  // m
constexpr double kFoundTurn = 0.03;       // rad

// Where the covariance of a pose, in the form of geometry_msgs/PoseWithCovariance, has these.
constexpr Eigen::Index kPlace = 0;
constexpr Eigen::Index kTilt = 3;
constexpr Eigen::Index kHeading = 5;

/// Covariance of T_rack_camera, form of geometry_msgs/PoseWithCovariance, after the camera went on
/// by `motion`, whose covariance perturbs it on the right.
Matrix6d moved(const Matrix6d& covariance, const SE3& T_rack_camera,
               const MotionPrediction& motion) {
  const Eigen::Vector3d step = T_rack_camera.rotation() * motion.T_previous_current.translation();
  Matrix6d turn = Matrix6d::Identity();
  turn.topRightCorner<3, 3>() = -geometry::skew(step);
  const Eigen::Matrix3d to_rack =
      (T_rack_camera.rotation() * motion.T_previous_current.rotation()).matrix();
  Matrix6d axes = Matrix6d::Zero();
  axes.topLeftCorner<3, 3>() = to_rack;
  axes.bottomRightCorner<3, 3>() = to_rack;
  return turn * covariance * turn.transpose() + axes * motion.covariance * axes.transpose();
}

/// One motion after another.
MotionPrediction chained(const MotionPrediction& first, const MotionPrediction& second) {
  const Matrix6d ad = second.T_previous_current.inverse().adjoint();
  return {first.T_previous_current * second.T_previous_current,
          ad * first.covariance * ad.transpose() + second.covariance};
}

/// From a perturbation in the rack frame of T_camera_rack, on the right, to the form of
/// geometry_msgs/PoseWithCovariance.
Matrix6d ros_form(const FirstPoseCandidate& candidate) {
  Matrix6d to = -Matrix6d::Identity();
  to.topRightCorner<3, 3>() = geometry::skew(candidate.T_camera_rack.inverse().translation());
  return to * candidate.covariance * to.transpose();
}

/// Angle of the camera's x axis about rack z, as FirstPoseHint::heading.
double heading(const SE3& T_rack_camera) {
  const Eigen::Vector3d x = T_rack_camera.rotation() * Eigen::Vector3d::UnitX();
  return std::atan2(x.y(), x.x());
}

bool usable(const MotionPrediction& motion) {
  return motion.T_previous_current.translation().allFinite() && motion.covariance.allFinite() &&
         (motion.covariance.diagonal().array() >= 0).all();
}

std::string_view why_not_started(FirstPoseStatus found) {
  switch (found) {
    case FirstPoseStatus::kAmbiguous:
      return "ambiguous: several poses explain the image";
    case FirstPoseStatus::kNotEnoughEdges:
      return "no pose explains the image";
    case FirstPoseStatus::kFound:
      break;
  }
  return "the pose found in an image was not confirmed";
}

const RackModel& checked(const RackModel& model) {
  model.validate();
  return model;
}

/// Except along the pipes, whose variance speaks for itself.
bool determined(const Matrix6d& covariance) {
  constexpr double kPosition = 0.1;  // m
  constexpr double kRotation = 0.1;  // rad
  const Matrix6d& c = covariance;
  return std::max(c(0, 0), c(2, 2)) <= kPosition * kPosition &&
         c.diagonal().tail<3>().maxCoeff() <= kRotation * kRotation;
}

/// What is said of a value twice: the more certain word.
void sharpen(std::optional<FirstPoseHint::Value>& known, double value, double deviation) {
  if (!known || known->standard_deviation > deviation) {
    known = FirstPoseHint::Value{value, deviation};
  }
}

}  // namespace

void RackLocalizationParameters::validate() const {
  tracker.validate();
  first_pose.validate();
  validation::check_within("RackLocalizationParameters.retry_period", retry_period, 0, 3600);
  validation::check_above("RackLocalizationParameters.drift_speed", drift_speed, 0, 100);
  validation::check_above("RackLocalizationParameters.drift_angular_speed", drift_angular_speed, 0,
                          100);
  validation::check_above("RackLocalizationParameters.hover_drift_speed", hover_drift_speed, 0,
                          100);
}

class RackLocalization::Implementation {
 public:
  Implementation(const RackModel& model, const geometry::Camera& camera,
                 const RackLocalizationParameters& parameters)
      : frame_(checked(model)),
        camera_(camera),
        parameters_(parameters),
        tracker_(frame_.model(), camera, parameters.tracker),
        finder_(parameters.first_pose) {
    parameters.validate();
    if (parameters.find_first_pose) {
      // Says now, not with some image, that this rack has too few pipes for it.
      FirstPoseFinder::check(frame_.model());
    }
  }

  // Poses here are in the flow frame.

  [[nodiscard]] const FlowFrame& frame() const noexcept { return frame_; }

  bool set_pose(const SE3& T_rack_camera, const Matrix6d& covariance) {
    if (!tracker_.set_pose(T_rack_camera, covariance)) {
      return false;
    }
    ++counts_.given;
    has_start_ = true;
    found_.reset();
    // Where one image does not bear it out, others are tried.
    last_pose_ = LastPose{T_rack_camera, covariance};
    velocity_.setZero();
    measured_.reset();
    unmeasured_ = 0;
    turning_ = 0;
    return true;
  }

  bool suggest_pose(const SE3& T_rack_camera, const Matrix6d& covariance) {
    if (!T_rack_camera.matrix().allFinite() || !is_covariance(covariance)) {
      return false;
    }
    const LastPose suggested{T_rack_camera, covariance};
    if (near_enough(suggested)) {
      return set_pose(T_rack_camera, covariance);
    }
    if (!tracking_) {
      complete(suggested);
    }
    return true;
  }

  void set_hint(const FirstPoseHint& hint) { hint_ = hint; }

  RackTrackerResult track(const ImageView& image, double stamp,
                          const std::optional<MotionPrediction>& motion) {
    const bool good_motion = motion && usable(*motion);
    remember_motion(good_motion ? motion : std::nullopt, stamp);
    if (!has_start_ && !tracking_ && std::isfinite(stamp) && image.valid() &&
        image.width == camera_.parameters().width && image.height == camera_.parameters().height) {
      propose(image, stamp);
    }
    // The tracker has the count of motions that cannot be used.
    RackTrackerResult result =
        tracker_.track(image, stamp, motion && !good_motion ? motion : measured_);
    follow(result);
    if (found_ &&
        (result.status == TrackStatus::kNotStarted ||
         (result.status == TrackStatus::kLost && found_ == FirstPoseStatus::kAmbiguous))) {
      result.reason = why_not_started(*found_);
    } else if (result.status == TrackStatus::kTracking && !determined(result.covariance)) {
      result.reason = "what is in view does not determine the pose";
    }
    return result;
  }

  [[nodiscard]] const RackTracker& tracker() const noexcept { return tracker_; }
  [[nodiscard]] const RackLocalizationCounts& counts() const noexcept { return counts_; }

 private:
  struct LastPose {
    SE3 T_rack_camera;
    Matrix6d covariance = Matrix6d::Zero();
  };

  /// Moves the last pose on to this image.
  void remember_motion(const std::optional<MotionPrediction>& motion, double stamp) {
    double interval = 0;
    if (std::isfinite(stamp)) {
      interval = last_stamp_ ? std::max(0.0, stamp - *last_stamp_) : 0;
      last_stamp_ = stamp;
    }
    if (!motion) {
      measured_.reset();  // a chain with a missing link measures nothing
    } else if (measured_) {
      measured_ = chained(*measured_, *motion);
    }
    if (!last_pose_) {
      return;
    }
    const MotionPrediction step = motion ? *motion : drift(interval);
    last_pose_->covariance = moved(last_pose_->covariance, last_pose_->T_rack_camera, step);
    last_pose_->T_rack_camera = last_pose_->T_rack_camera * step.T_previous_current;
  }

  /// What may have happened in an interval that nothing measured: on at the same speed. What is
  /// unknown of the speed does not change much: deviations, not variances, add up with time. The
  /// tilt of a vehicle goes to and fro, and does not grow.
  MotionPrediction drift(double interval) {
    constexpr double kLongestTurn = 0.5;  // s
    const double still_turning = std::min(turning_ + interval, kLongestTurn);
    const double speed = tracked_stamp_ ? parameters_.drift_speed : parameters_.hover_drift_speed;
    const double turn_speed = parameters_.drift_angular_speed;
    const auto grown = [](double from, double to) { return to * to - from * from; };
    MotionPrediction step;
    step.T_previous_current =
        SE3(SO3(), last_pose_->T_rack_camera.rotation().inverse() * (interval * velocity_));
    step.covariance.setZero();
    step.covariance.diagonal().head<3>().setConstant(speed * speed *
                                                     grown(unmeasured_, unmeasured_ + interval));
    step.covariance.diagonal().tail<3>().setConstant(turn_speed * turn_speed *
                                                     grown(turning_, still_turning));
    unmeasured_ += interval;
    turning_ = still_turning;
    return step;
  }

  /// Takes over what is more certain: place, tilt and heading, each as a whole.
  void complete(const LastPose& suggested) {
    if (!last_pose_) {
      ++counts_.suggested;
      last_pose_ = suggested;
      return;
    }
    const LastPose& known = *last_pose_;
    const auto better = [&](Eigen::Index first, Eigen::Index size) {
      return suggested.covariance.diagonal().segment(first, size).sum() <
             known.covariance.diagonal().segment(first, size).sum();
    };
    const LastPose& place = better(kPlace, 3) ? suggested : known;
    const LastPose& tilt = better(kTilt, 2) ? suggested : known;
    const LastPose& heading_source = better(kHeading, 1) ? suggested : known;
    if (&place == &known && &tilt == &known && &heading_source == &known) {
      return;
    }
    ++counts_.suggested;
    turning_ = &tilt == &suggested ? 0 : turning_;
    const double turn = heading(heading_source.T_rack_camera) - heading(tilt.T_rack_camera);
    LastPose result{
        SE3(SO3::about_z(turn) * tilt.T_rack_camera.rotation(), place.T_rack_camera.translation())};
    result.covariance.topLeftCorner<3, 3>() = place.covariance.topLeftCorner<3, 3>();
    // About axes that turned with the heading: as uncertain about each as about the worse one.
    result.covariance.diagonal().segment<2>(kTilt).setConstant(
        tilt.covariance.diagonal().segment<2>(kTilt).maxCoeff());
    result.covariance(kHeading, kHeading) = heading_source.covariance(kHeading, kHeading);
    last_pose_ = result;
  }

  void propose(const ImageView& image, double stamp) {
    if (last_try_ && stamp >= *last_try_ && stamp - *last_try_ < parameters_.retry_period) {
      return;
    }
    last_try_ = stamp;
    constexpr unsigned kImageEvery = 3;
    const bool image_is_next = ++tries_ % kImageEvery == 0;
    if (last_pose_ && near_enough(*last_pose_) && !(image_is_next && parameters_.find_first_pose)) {
      ++counts_.from_last_pose;
      found_.reset();
      has_start_ = tracker_.set_pose(last_pose_->T_rack_camera, last_pose_->covariance);
      return;
    }
    if (parameters_.find_first_pose) {
      find_in_image(image);
    }
  }

  /// Whether the tracker, which searches around a start, has a chance there.
  [[nodiscard]] bool near_enough(const LastPose& pose) const {
    const auto deviation = pose.covariance.diagonal().cwiseMax(0).cwiseSqrt().eval();
    // Not along the pipes, where a tracker of edges alone knows nothing either.
    return deviation(0) < 3 * parameters_.tracker.start_range_m &&
           deviation(2) < 3 * parameters_.tracker.start_range_m &&
           deviation.tail<3>().maxCoeff() < 3 * parameters_.tracker.start_range_rad;
  }

  void find_in_image(const ImageView& image) {
    ++counts_.from_image;
    FirstPoseHint hint = hint_;
    if (last_pose_) {
      const auto deviation = last_pose_->covariance.diagonal().cwiseMax(1e-12).cwiseSqrt().eval();
      const Eigen::Vector3d& place = last_pose_->T_rack_camera.translation();
      sharpen(hint.x, place.x(), deviation(0));
      sharpen(hint.y, place.y(), deviation(1));
      sharpen(hint.z, place.z(), deviation(2));
      sharpen(hint.heading, heading(last_pose_->T_rack_camera), deviation(5));
    }
    const FirstPose found = finder_.find(image, frame_.model(), offsets_, camera_, hint);
    found_ = found.status;
    if (found.status == FirstPoseStatus::kAmbiguous) {
      ++counts_.image_ambiguous;
    } else if (found.status == FirstPoseStatus::kNotEnoughEdges) {
      ++counts_.image_unclear;
    } else {
      const FirstPoseCandidate& best = found.candidates.front();
      Matrix6d covariance = ros_form(best);
      covariance.diagonal().head<3>().array() += kFoundDeviation * kFoundDeviation;
      covariance.diagonal().tail<3>().array() += kFoundTurn * kFoundTurn;
      has_start_ = tracker_.set_pose(best.T_camera_rack.inverse(), covariance);
    }
  }

  /// Of the camera, rack frame: a mean over some images, of a pose that was tracked through.
  void learn_velocity(const SE3& T_rack_camera) {
    constexpr double kMemory = 0.3;  // s
    const double interval = tracked_stamp_ ? *last_stamp_ - *tracked_stamp_ : 0;
    if (interval > 0 && interval < kMemory && tracking_) {
      const Eigen::Vector3d speed = (T_rack_camera.translation() - tracked_place_) / interval;
      velocity_ += std::min(1.0, interval / kMemory) * (speed - velocity_);
    } else {
      velocity_.setZero();
    }
    tracked_stamp_ = last_stamp_;
    tracked_place_ = T_rack_camera.translation();
  }

  void follow(const RackTrackerResult& result) {
    if (result.status == TrackStatus::kBadImage || result.status == TrackStatus::kBadStamp) {
      return;  // nothing has changed, a start that waits for an image included
    }
    has_start_ = false;
    if (result.status == TrackStatus::kTracking) {
      counts_.recoveries += lost_ ? 1U : 0U;
      lost_ = false;
      learn_velocity(result.T_rack_camera);
      last_pose_ = LastPose{result.T_rack_camera, result.covariance};
      offsets_.assign(result.offsets.begin(), result.offsets.end());
      measured_ = MotionPrediction{.T_previous_current = SE3(), .covariance = Matrix6d::Zero()};
      unmeasured_ = 0;
      turning_ = 0;
      tries_ = 0;
      last_try_.reset();
    }
    lost_ = lost_ || result.status == TrackStatus::kLost;
    tracking_ = result.status == TrackStatus::kTracking || result.status == TrackStatus::kCoasting;
  }

  FlowFrame frame_;
  geometry::Camera camera_;
  RackLocalizationParameters parameters_;
  RackTracker tracker_;
  FirstPoseFinder finder_;
  FirstPoseHint hint_;
  RackLocalizationCounts counts_;

  bool has_start_ = false;  ///< the tracker was given a pose that no image has confirmed
  bool tracking_ = false;
  bool lost_ = false;
  unsigned tries_ = 0;  ///< to find a pose, since the last one
  std::optional<double> tracked_stamp_;
  Eigen::Vector3d tracked_place_ = Eigen::Vector3d::Zero();
  Eigen::Vector3d velocity_ = Eigen::Vector3d::Zero();  ///< m/s, rack frame
  std::optional<LastPose> last_pose_;                   ///< moved on to the last image
  std::optional<MotionPrediction> measured_;  ///< since the last tracked image, without a gap
  double unmeasured_ = 0;  ///< s since the last tracked image without a measured motion
  double turning_ = 0;     ///< s, the same of the tilt, which is sometimes told meanwhile
  std::optional<double> last_stamp_;
  std::optional<double> last_try_;
  std::optional<FirstPoseStatus> found_;  ///< by the last search in an image alone
  std::vector<double> offsets_;
};

RackLocalization::RackLocalization(const RackModel& model, const geometry::Camera& camera,
                                   const RackLocalizationParameters& parameters)
    : implementation_(std::make_unique<Implementation>(model, camera, parameters)) {}

RackLocalization::~RackLocalization() = default;
RackLocalization::RackLocalization(RackLocalization&&) noexcept = default;
RackLocalization& RackLocalization::operator=(RackLocalization&&) noexcept = default;

bool RackLocalization::set_pose(const SE3& T_rack_camera, const Matrix6d& covariance) {
  const FlowFrame& frame = implementation_->frame();
  return implementation_->set_pose(frame.from_rack(T_rack_camera), frame.from_rack(covariance));
}

bool RackLocalization::suggest_pose(const SE3& T_rack_camera, const Matrix6d& covariance) {
  const FlowFrame& frame = implementation_->frame();
  return implementation_->suggest_pose(frame.from_rack(T_rack_camera), frame.from_rack(covariance));
}

void RackLocalization::set_hint(const FirstPoseHint& hint) {
  hint.validate();
  implementation_->set_hint(implementation_->frame().from_rack(hint));
}

RackTrackerResult RackLocalization::track(const ImageView& image, double stamp,
                                          const std::optional<MotionPrediction>& motion) {
  const FlowFrame& frame = implementation_->frame();
  RackTrackerResult result = implementation_->track(image, stamp, motion);
  result.T_rack_camera = frame.to_rack(result.T_rack_camera);
  result.covariance = frame.to_rack(result.covariance);
  return result;
}

const RackTracker& RackLocalization::tracker() const noexcept {
  return implementation_->tracker();
}

const RackLocalizationCounts& RackLocalization::counts() const noexcept {
  return implementation_->counts();
}

}  // namespace pipescout::rack_vision
