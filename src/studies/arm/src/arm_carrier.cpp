// SPDX-License-Identifier: Apache-2.0
#include "pipescout/arm_study/arm_carrier.hpp"

#include <array>
#include <optional>
#include <vector>

#include "drive_loop.hpp"
#include "pipescout/validation/check.hpp"

namespace pipescout::arm_study {
namespace {

using geometry::SE3;
using tracking::PipeShape;
using tracking::PipeTrack;

manipulation::TrackState state_of(const PipeTrack& track) {
  switch (track.state) {
    case tracking::TrackState::kLocked:
      return manipulation::TrackState::kLocked;
    case tracking::TrackState::kCoasting:
      return manipulation::TrackState::kCoasting;
    case tracking::TrackState::kLost:
      return manipulation::TrackState::kLost;
    case tracking::TrackState::kDetecting:
      break;
  }
  return manipulation::TrackState::kNone;
}

}  // namespace

void CarrierSettings::validate() const {
  validation::check_within("distance", distance, 1, 1000);
  shape.validate();
  tracker.validate();
  drive.validate();
}

class ArmCarrier::Implementation {
 public:
  Implementation(const CarrierSettings& settings, const geometry::Camera& camera,
                 std::uint64_t seed)
      : distance_(settings.distance),
        camera_(camera),
        tracker_(settings.shape, settings.tracker, seed),
        loop_(settings.drive, seed) {
    arm_[0] = std::make_unique<internal::CameraArm>(
        ArmRule{.name = "on patrol", .controller = settings.controller}, settings.drive, camera,
        internal::collector_of(settings.drive), seed);
  }

  void step(simulation::ThermalPatrol& patrol) {
    loop_.step(patrol.robot().motion(), arm_, {});
    now_ = patrol.robot().motion().time;
    patrol.move_camera(arm_[0]->T_body_camera(), arm_[0]->camera_velocity());
  }

  [[nodiscard]] SE3 T_base_camera() const { return arm_[0]->T_body_camera_shown(); }

  void see(const leak_findings::Frame& frame, const thermal::Detections& detections) {
    regions_.clear();
    for (const thermal::PipeSection& pipe : detections.pipes) {
      regions_.push_back({.start = pipe.start,
                          .end = pipe.end,
                          .half_width = pipe.half_width,
                          .cut_along = pipe.cut_along});
    }
    const geometry::CameraParameters& image = camera_.parameters();
    const PipeTrack& track = tracker_.update({.time = frame.time,
                                              .image = {image.width, image.height},
                                              .regions = regions_,
                                              .motion = motion(frame)});
    manipulation::PipeSection section{
        .time = frame.time, .state = state_of(track), .width = image.width, .height = image.height};
    section.u = track.estimate[PipeShape::kX];
    section.v = track.estimate[PipeShape::kY];
    section.length = track.estimate[PipeShape::kLength];
    section.angle = track.estimate[PipeShape::kAngle];
    if (const auto ray = camera_.ray(track.estimate.head<2>())) {
      section.range = distance_ * ray->norm();
    }
    arm_[0]->take_section(section, now_);
  }

 private:
  /// Of the picture since the last one, by what the robot knows of its pose and of its arm.
  std::optional<tracking::ImageMotion> motion(const leak_findings::Frame& frame) {
    if (!frame.pose || !frame.T_base_camera) {
      last_camera_.reset();
      return std::nullopt;
    }
    const SE3 T_map_camera = frame.pose->T_map_base * *frame.T_base_camera;
    std::optional<tracking::ImageMotion> result;
    if (last_camera_ && frame.time > last_time_) {
      const PipeTrack& track = tracker_.track();
      const Eigen::Vector2d middle(camera_.parameters().centre_u, camera_.parameters().centre_v);
      const Eigen::Vector2d at =
          track.number > 0 ? Eigen::Vector2d(track.estimate.head<2>()) : middle;
      const geometry::Vector6d velocity =
          (last_camera_->inverse() * T_map_camera).log() / (frame.time - last_time_);
      result = tracking::image_motion(camera_, at, distance_, velocity);
    }
    last_camera_ = T_map_camera;
    last_time_ = frame.time;
    return result;
  }

  double distance_;  // m
  geometry::Camera camera_;
  tracking::PipeTracker tracker_;
  internal::ArmLoop loop_;
  std::array<std::unique_ptr<internal::CameraArm>, 1> arm_;
  std::vector<tracking::PipeRegion> regions_;
  std::optional<SE3> last_camera_;
  double last_time_ = 0;  // s
  double now_ = 0;        // s
};

ArmCarrier::ArmCarrier(const CarrierSettings& settings, const geometry::Camera& camera,
                       std::uint64_t seed) {
  settings.validate();
  implementation_ = std::make_unique<Implementation>(settings, camera, seed);
}

ArmCarrier::~ArmCarrier() = default;

void ArmCarrier::step(simulation::ThermalPatrol& patrol) {
  implementation_->step(patrol);
}

SE3 ArmCarrier::T_base_camera() const {
  return implementation_->T_base_camera();
}

void ArmCarrier::see(const leak_findings::Frame& frame, const thermal::Detections& detections) {
  implementation_->see(frame, detections);
}

}  // namespace pipescout::arm_study
