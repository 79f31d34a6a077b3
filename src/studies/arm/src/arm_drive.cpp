// SPDX-License-Identifier: Apache-2.0
#include "pipescout/arm_study/arm_drive.hpp"

#include <cmath>
#include <memory>

#include "drive_loop.hpp"
#include "pipescout/validation/check.hpp"

namespace pipescout::arm_study {
namespace {

using internal::CameraArm;

}  // namespace

void TrackErrors::validate() const {
  using validation::check_within;
  check_within("track.rate", rate, 1, 100);
  check_within("track.latency", latency, 0, 1);
  check_within("track.position_deviation", position_deviation, 0, 100);
  check_within("track.angle_deviation", angle_deviation, 0, 1);
  check_within("track.range_deviation", range_deviation, 0, 1);
  check_within("track.gap_spacing", gap_spacing, 1e-3, 1e6);
  check_within("track.gap_time", gap_time, 0, 10);
}

void OdometryErrors::validate() const {
  using validation::check_within;
  check_within("odometry.rate", rate, 10, 500);
  check_within("odometry.latency", latency, 0, 0.1);
  check_within("odometry.tilt_deviation", tilt_deviation, 0, 1);
  check_within("odometry.tilt_time", tilt_time, 0.1, 1e5);
  check_within("odometry.velocity_deviation", velocity_deviation, 0, 10);
  check_within("odometry.velocity_time", velocity_time, 0.1, 1e5);
  check_within("odometry.rate_deviation", rate_deviation, 0, 1);
}

void DriveSettings::validate() const {
  using validation::check_within;
  check_within("hill_height", hill_height, 0, 10);
  check_within("length", length, 10, 1e5);
  check_within("speed", speed, 0.1, 5.56);
  check_within("distance", distance, 2, 100);
  check_within("pipe_height", pipe_height, 0.5, 20);
  check_within("pipe_radius", pipe_radius, 1e-3, 1);
  check_within("settling", settling, 0, 1000);
  check_within("arm_delay", arm_delay, 0, 0.5);
  check_within("joint_zero_deviation", joint_zero_deviation, 0, 0.1);
  robot.validate();
  track.validate();
  odometry.validate();
}

std::vector<ArmRule> arm_rules() {
  // Without odometry what an image showed holds in the vehicle's frame, which turns: only the last
  // image is of use.
  manipulation::ArmControllerParameters image_only{.feed_forward = false, .image_time = 0};
  manipulation::ArmControllerParameters paper = image_only;
  paper.centring = manipulation::Centring::kAtEdge;
  return {{.name = "fixed camera", .fixed = true},
          {.name = "moves at the edge (paper)", .controller = paper},
          {.name = "always centred, image only", .controller = image_only},
          {.name = "always centred, feed-forward", .controller = {}}};
}

double DriveScore::in_view_percent() const {
  return samples == 0 ? 0 : 100 * static_cast<double>(whole) / static_cast<double>(samples);
}
double DriveScore::centre_rms() const {
  return samples == 0 ? 0 : std::sqrt(centre_square / static_cast<double>(samples));
}
double DriveScore::angle_rms() const {
  return samples == 0 ? 0 : std::sqrt(angle_square / static_cast<double>(samples));
}

std::vector<DriveScore> run_drive(const DriveSettings& settings, const std::vector<ArmRule>& rules,
                                  std::uint64_t seed) {
  settings.validate();
  std::vector<std::unique_ptr<CameraArm>> arms;
  for (const ArmRule& rule : rules) {
    arms.push_back(std::make_unique<CameraArm>(rule, settings, internal::usual_camera(),
                                               internal::collector_of(settings), seed));
  }
  internal::drive(settings, seed, arms, {});
  std::vector<DriveScore> scores;
  for (const auto& arm : arms) {
    scores.push_back(arm->score());
  }
  return scores;
}

}  // namespace pipescout::arm_study
