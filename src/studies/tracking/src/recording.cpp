// SPDX-License-Identifier: Apache-2.0
#include "pipescout/tracking_study/recording.hpp"

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <string>

#include "pipescout/leak_study/campaign.hpp"
#include "pipescout/statistics/draw.hpp"
#include "pipescout/thermal/leak_detector.hpp"
#include "pipescout/thermal/temperature_table.hpp"
#include "pipescout/validation/check.hpp"

namespace pipescout::tracking_study {
namespace {

using geometry::Vector6d;
using simulation::ThermalPatrol;
using tracking::PipeRegion;
using tracking::PipeShape;

constexpr double kVelocityStep = 0.01;    // s, of the mean of the velocity
constexpr std::uint64_t kPurpose = 0x7d;  // of the draws of the recording
constexpr double kSpare = 30;             // m, of a row beyond what is driven
constexpr double kFirstShare = 0.5;       // of the picture's width

/// Linear, then angular, with these deviations.
Vector6d draw_velocity(statistics::Draw& draw, double linear, double angular) {
  Vector6d velocity;
  velocity << linear * draw.normals(), angular * draw.normals();
  return velocity;
}

/// From counts to regions, by who knows nothing of the scene but the paper's settings.
class Pictures {
 public:
  explicit Pictures(const simulation::ThermalPatrolParameters& patrol)
      : width_(patrol.camera.camera.width),
        height_(patrol.camera.camera.height),
        table_(thermal::Radiometry(patrol.camera.constants, thermal::ibarguren2013_object())),
        detector_(thermal::LeakDetectorParameters{}),
        counts_(static_cast<std::size_t>(width_) * static_cast<std::size_t>(height_)) {}

  void look(ThermalPatrol& patrol, std::uint64_t frame, std::vector<PipeRegion>& regions) {
    patrol.render(frame, counts_);
    const thermal::Detections& detections = detector_.detect(
        thermal::CountView{counts_.data(), width_, height_, width_}, table_.degrees());
    for (const thermal::PipeSection& pipe : detections.pipes) {
      regions.push_back({.start = pipe.start,
                         .end = pipe.end,
                         .half_width = pipe.half_width,
                         .cut_along = pipe.cut_along});
    }
  }

 private:
  int width_;
  int height_;
  thermal::TemperatureTable table_;
  thermal::LeakDetector detector_;
  std::vector<std::uint16_t> counts_;
};

std::optional<PipeShape::State> truth_of(const ThermalPatrol& patrol,
                                         const simulation::ThermalView& view,
                                         simulation::ThermalTruth& truth) {
  patrol.renderer().truth(view, truth);
  if (!truth.tube) {
    return std::nullopt;
  }
  return PipeShape::state_of({.start = truth.tube->from, .end = truth.tube->to});
}

/// m, along the camera's axis to the tube abreast of it.
double true_depth(const ThermalPatrol& patrol, const simulation::ThermalView& view) {
  const Eigen::Vector3d tube = patrol.scene().on_tube(patrol.place());
  return (view.T_map_camera.inverse() * tube).z();
}

}  // namespace

void RecordingSettings::validate() const {
  validation::check_within("frames", static_cast<double>(frames), 1, 100000);
  validation::check_within("frame_rate", frame_rate, 1, 200);
  validation::check_within("gap_spacing", gap_spacing, 0.1, 1e6);
  validation::check_within("gap", gap, 0, 10);
  validation::check_within("velocity_deviation", velocity_deviation, 0, 10);
  validation::check_within("angular_deviation", angular_deviation, 0, 1);
  validation::check_within("depth_deviation", depth_deviation, 0, 1);
}

Recording record(const simulation::ThermalPatrolParameters& parameters,
                 const RecordingSettings& settings, std::uint64_t seed) {
  settings.validate();
  ThermalPatrol patrol(parameters);
  Pictures pictures(parameters);
  statistics::Draw draw(seed, kPurpose);
  Recording recording;
  recording.camera = patrol.renderer().camera();
  const Vector6d bias =
      draw_velocity(draw, settings.velocity_deviation, settings.angular_deviation);
  const double depth_scale = 1 + settings.depth_deviation * draw.normal();

  simulation::ThermalTruth truth;
  const double period = 1 / settings.frame_rate;
  double gap_left = 0;
  double time = 0;
  for (std::uint64_t i = 0; recording.pictures.size() < settings.frames; ++i) {
    if (patrol.arrived()) {
      throw std::invalid_argument("frames: the row is too short for " +
                                  std::to_string(settings.frames));
    }
    Vector6d sum = Vector6d::Zero();  // by the trapezoidal rule
    const double next = static_cast<double>(i) * period;
    int steps = 0;
    for (; time < next - 1e-9; ++steps) {
      time = std::min(next, time + kVelocityStep);
      const Vector6d before = patrol.view(i).velocity;
      patrol.drive_until(time);
      sum += 0.5 * (before + patrol.view(i).velocity);
    }
    const simulation::ThermalView view = patrol.view(i);
    auto seen = truth_of(patrol, view, truth);
    if (recording.pictures.empty()) {
      if (!seen || (*seen)[PipeShape::kLength] < kFirstShare * parameters.camera.camera.width) {
        continue;
      }
      recording.depth = depth_scale * true_depth(patrol, view);
    }
    RecordedPicture picture{.time = next, .first_region = recording.regions.size()};
    picture.truth = seen;
    picture.velocity = sum / std::max(steps, 1) + bias +
                       draw_velocity(draw, settings.velocity_deviation, settings.angular_deviation);
    if (gap_left <= 0 && draw.uniform(0, 1) < period / settings.gap_spacing) {
      gap_left = 2 * settings.gap * draw.uniform(0, 1);
    }
    picture.gap = gap_left > 0;
    gap_left -= period;
    if (!picture.gap) {
      pictures.look(patrol, i, recording.regions);
    }
    picture.regions = recording.regions.size() - picture.first_region;
    recording.pictures.push_back(picture);
  }
  return recording;
}

std::vector<simulation::ThermalPatrolParameters> plan_patrols(std::size_t patrols,
                                                              const RecordingSettings& settings,
                                                              std::uint64_t seed) {
  settings.validate();
  constexpr double kPerLeak = 100;  // m
  constexpr double kPerDecoy = 50;  // m
  leak_study::CampaignSettings campaign{.sequences = patrols};
  const double driven = simulation::ThermalPatrolParameters{}.speed *
                        static_cast<double>(settings.frames) / settings.frame_rate;
  campaign.length = std::max(150.0, driven + kSpare);
  const double metres = campaign.length * static_cast<double>(patrols);
  campaign.faint_leaks = 0;
  campaign.other_leaks = std::min(10 * patrols, static_cast<std::size_t>(metres / kPerLeak));
  campaign.decoys = std::min(10 * patrols, static_cast<std::size_t>(metres / kPerDecoy));
  std::vector<simulation::ThermalPatrolParameters> result;
  for (const leak_study::SequencePlan& plan : leak_study::plan_campaign(campaign, seed)) {
    result.push_back(plan.patrol);
  }
  return result;
}

}  // namespace pipescout::tracking_study
