// SPDX-License-Identifier: Apache-2.0
#include "pipescout/leak_study/rack_inspection.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <optional>

#include "pipescout/estimation/state_estimator.hpp"
#include "pipescout/leak_findings/leak_findings.hpp"
#include "pipescout/leak_findings/rack_lines.hpp"
#include "pipescout/rack_study/image_scene.hpp"
#include "pipescout/rack_vision/rack_localization.hpp"
#include "pipescout/rack_vision/visual_servo.hpp"
#include "pipescout/rack_vision/way_point_mission.hpp"
#include "pipescout/simulation/rack_flight.hpp"
#include "pipescout/statistics/chi_square.hpp"
#include "pipescout/statistics/draw.hpp"
#include "pipescout/thermal/temperature_table.hpp"
#include "pipescout/validation/check.hpp"

namespace pipescout::leak_study {
namespace {

using Eigen::Vector3d;
using geometry::Matrix6d;
using geometry::SE3;
using geometry::SO3;
using rack_vision::RackModel;
using simulation::HotSpot;
using statistics::Draw;

// Purposes of random draws.
constexpr std::uint64_t kSpotDraws = 81;
constexpr std::uint64_t kFlightDraws = 82;

constexpr double kImagePeriod = 0.08;  // s
constexpr int kImagesPerThermalImage = 2;
constexpr double kImuPeriod = 0.005;      // s
constexpr double kMiddle = 0.88;          // m, rack x, of the four pipes
constexpr double kFirst = 1.6;            // m, rack y, where the flight begins
constexpr double kLast = 8.4;             // m, where it turns
constexpr double kFromEnds = 0.8;         // m: hot spots are farther within
constexpr double kSame = 0.5;             // m, between a finding and its hot spot
constexpr double kStartPosition = 0.01;   // m, per axis, of the pose that the tracker begins with
constexpr double kStartRotation = 0.005;  // rad

/// The sun warms some of the ground beside the rack.
constexpr double kBesideRack = -0.7;  // m, rack x

Vector3d thermal_camera_on_body() {
  return {0.08, -0.05, 0.02};
}

geometry::CameraParameters thermal_camera() {
  geometry::CameraParameters camera;
  camera.width = 320;
  camera.height = 240;
  camera.focal_length = 280;
  camera.centre_u = 159.5;
  camera.centre_v = 119.5;
  return camera;
}

/// Whether the pipe across lies over, or under, the hot spot or next to it.
bool is_hidden(const HotSpot& spot, const RackModel& model) {
  constexpr double kBeside = 0.15;  // m
  const rack_vision::Pipe& pipe = model.pipes[spot.pipe];
  return std::ranges::any_of(model.pipes, [&](const rack_vision::Pipe& other) {
    const double crossing = (other.start - pipe.start).dot(pipe.direction);
    return std::abs(other.direction.dot(pipe.direction)) < 0.5 &&
           other.start.z() > pipe.start.z() &&
           std::abs(spot.along - crossing) < other.largest_radius() + 0.5 * spot.length + kBeside;
  });
}

HotSpot draw_hot_spot(const RackModel& model, Draw& draw) {
  HotSpot spot;
  spot.pipe = draw.index(model.pipes.size());
  if (draw.happens(0.5)) {
    spot.length = draw.uniform(0.25, 0.6);
    spot.half_angle = draw.uniform(0.5, 0.9);
    spot.azimuth = draw.uniform(-0.5, 0.5);
    spot.rise = draw.uniform(12, 30);
  } else {
    spot.length = draw.uniform(0.5, 1.0);
    spot.half_angle = std::numbers::pi;
    spot.rise = draw.uniform(9, 15);
  }
  const rack_vision::Pipe& pipe = model.pipes[spot.pipe];
  // A pipe across is seen where it is over the others.
  const bool across = std::abs(pipe.direction.y()) < 0.5;
  const double begin = across ? 0.2 - pipe.start.x() : kFirst + kFromEnds;
  const double end = across ? 1.5 - pipe.start.x() : kLast - kFromEnds;
  spot.along = draw.uniform(begin, end);
  return spot;
}

RackModel displaced(RackModel model, double deviation, Draw& draw) {
  // The first one is where the frame of the rack is.
  for (std::size_t i = 1; i < model.pipes.size(); ++i) {
    if (model.pipes[i].movable) {
      model.pipes[i].start.x() += deviation * draw.normal();
    }
  }
  return model;
}

std::vector<rack_vision::WayPoint> draw_way_points(Draw& draw) {
  const auto next = [&](double along) {
    return rack_vision::WayPoint{
        .position = {kMiddle + draw.uniform(-0.15, 0.15), along, draw.uniform(2.4, 2.9)},
        .yaw = std::numbers::pi / 2 + draw.uniform(-0.15, 0.15),
        .hold = 1};
  };
  const double half_way = (kFirst + kLast) / 2;
  return {next(kFirst), next(half_way), next(kLast), next(half_way), next(kFirst)};
}

thermal::LeakDetectorParameters detector_parameters() {
  using thermal::LeakDetectorParameters;
  auto p = LeakDetectorParameters::of(thermal::DetectorPreset::kHotPipes);
  p.threshold_rule = thermal::ThresholdRule::kFixed;
  p.threshold = 20;          // degC, between the ground and the coldest pipe
  p.profile.leak_delta = 4;  // K: a sound pipe changes by 2 along its length
  p.profile.min_part_width_m = 0.12;
  return p;
}

estimation::StateEstimatorParameters estimator_parameters(const simulation::ImuParameters& imu) {
  auto p = estimation::StateEstimatorParameters::uav();
  p.smoother.gravity = simulation::kGravity;
  p.smoother.imu_noise.gyro = imu.gyro.noise_density;
  p.smoother.imu_noise.accelerometer = imu.accelerometer.noise_density;
  p.start.hover_speed = 0.06;  // m/s, in gusts: it waits for its place in the air
  return p;
}

simulation::ImuParameters imu_parameters() {
  auto p = simulation::ImuParameters::industrial();
  p.period = kImuPeriod;
  return p;
}

Matrix6d diagonal(double position, double rotation) {
  geometry::Vector6d deviations;
  deviations << Vector3d::Constant(position), Vector3d::Constant(rotation);
  return deviations.cwiseAbs2().asDiagonal();
}

/// With rotations about the axes of the body made of ones about those of the rack, or the reverse
/// with its transpose.
Matrix6d turned(const Matrix6d& covariance, const Eigen::Matrix3d& rotation) {
  Matrix6d by = Matrix6d::Identity();
  by.bottomRightCorner<3, 3>() = rotation;
  const Matrix6d result = by * covariance * by.transpose();
  return 0.5 * (result + result.transpose());
}

class Inspection {
 public:
  Inspection(const RackInspectionSettings& settings, std::uint64_t seed)
      : settings_((settings.validate(), settings)),
        draw_(seed, kFlightDraws),
        filed_(rack_study::rack_on_beams()),
        true_(displaced(filed_, settings.offset_deviation, draw_)),
        spots_(draw_hot_spots(true_, settings.hot_spots, seed)),
        mission_(rack_vision::WayPointPath(draw_way_points(draw_), {}), {}),
        flight_(flight_parameters(seed)),
        servo_({.T_base_camera = T_base_camera_}),
        localization_(filed_, camera_, localization_parameters()),
        estimator_(estimator_parameters(imu_parameters())),
        detector_(detector_parameters()),
        findings_(findings_parameters(), geometry::Camera(thermal_camera())),
        table_(simulation::kRackThermalGain, simulation::kRackThermalOffset),
        grey_(pixels(camera_.parameters())),
        counts_(pixels(thermal_camera())) {}

  RackInspectionScore run() {
    start();
    for (int image = 0; !mission_.complete() && image * kImagePeriod < settings_.longest; ++image) {
      const double now = image * kImagePeriod;
      flight_.fly_until(now);
      take_imu();
      take_image(image, now);
      if (image % kImagesPerThermalImage == 0) {
        take_thermal_image(image / kImagesPerThermalImage, now);
      }
      steer(now);
    }
    score_.complete = mission_.count(rack_vision::WayPointOutcome::kReached) ==
                      mission_.path().way_points().size();
    score_findings();
    return score_;
  }

 private:
  static std::size_t pixels(const geometry::CameraParameters& camera) {
    return static_cast<std::size_t>(camera.width) * static_cast<std::size_t>(camera.height);
  }

  simulation::RackFlightParameters flight_parameters(std::uint64_t seed) {
    const rack_vision::WayPoint& first = mission_.path().way_points().front();
    simulation::RackFlightParameters p;
    p.scene.model = true_;
    p.wind.speed_at_20_feet = settings_.wind_at_20_feet;
    p.wind.direction = draw_.uniform(-std::numbers::pi, std::numbers::pi);
    p.wind.height = 6;
    p.imu = imu_parameters();
    p.T_base_camera = T_base_camera_;
    p.thermal = simulation::RackThermalParameters{
        .camera = thermal_camera(),
        .T_base_camera = rack_vision::downward_camera(thermal_camera_on_body()),
        .hot_spots = spots_};
    for (int i = 0; i < 2; ++i) {
      p.thermal->warm_ground.push_back({.middle = {kBesideRack, draw_.uniform(kFirst, kLast)},
                                        .radius = draw_.uniform(0.2, 0.4),
                                        .temperature = draw_.uniform(30, 50)});
    }
    p.start_position = first.position;
    p.start_yaw = first.yaw;
    p.seed = seed;
    return p;
  }

  static rack_vision::RackLocalizationParameters localization_parameters() {
    rack_vision::RackLocalizationParameters p;
    p.tracker.offset_sigma = 0.02;
    return p;
  }

  leak_findings::LeakFindingsParameters findings_parameters() const {
    leak_findings::LeakFindingsParameters p;
    p.range_source = leak_findings::RangeSource::kLine;
    p.lines = leak_findings::rack_lines(filed_, {});
    p.T_base_camera = rack_vision::downward_camera(thermal_camera_on_body());
    return p;
  }

  void start() {
    const SE3 truth = flight_.T_rack_camera();
    const SE3 given(SO3::exp(kStartRotation * draw_.normals()) * truth.rotation(),
                    truth.translation() + kStartPosition * draw_.normals());
    localization_.set_pose(given, diagonal(kStartPosition, kStartRotation));
  }

  void take_imu() {
    for (const simulation::RackFlight::ImuSample& sample : flight_.take_imu_samples()) {
      estimator_.add(estimation::ImuReading{.time = sample.time,
                                            .specific_force = sample.reading.specific_force,
                                            .angular_rate = sample.reading.angular_rate});
      angular_rate_ = sample.reading.angular_rate;
    }
  }

  void take_image(int image, double now) {
    const geometry::CameraParameters& camera = camera_.parameters();
    flight_.render(static_cast<std::uint64_t>(image), grey_);
    const auto result = localization_.track({.pixels = grey_.data(),
                                             .width = camera.width,
                                             .height = camera.height,
                                             .stride = camera.width},
                                            now);
    ++score_.images;
    if (result.status != rack_vision::TrackStatus::kTracking) {
      return;
    }
    ++score_.with_pose;
    servo_.observe({.time = now,
                    .position = result.T_rack_camera.translation(),
                    .orientation = result.T_rack_camera.rotation().quaternion(),
                    .quality = result.quality},
                   now);
    const SE3 T_rack_body = result.T_rack_camera * T_base_camera_.inverse();
    estimator_.add(estimation::VisualPoseMeasurement{
        .time = now,
        .T_rack_body = T_rack_body,
        .covariance = turned(result.covariance, T_rack_body.rotation().matrix().transpose()),
        .angular_rate = angular_rate_});
    findings_.set_lines(leak_findings::rack_lines(filed_, result.offsets));
  }

  void take_thermal_image(int image, double now) {
    flight_.render_thermal(static_cast<std::uint64_t>(image), counts_);
    const geometry::CameraParameters camera = thermal_camera();
    const leak_findings::Frame frame{
        .time = now, .number = static_cast<std::uint64_t>(image), .pose = estimated_pose()};
    ++score_.thermal_images;
    score_.placed += frame.pose ? 1 : 0;
    const thermal::Detections& detections = detector_.detect(
        thermal::CountView{counts_.data(), camera.width, camera.height, camera.width},
        table_.degrees(), findings_.conditions(frame));
    findings_.update(frame, detections);
  }

  /// Now: the IMU's newest reading is of this time.
  [[nodiscard]] std::optional<leak_findings::FramePose> estimated_pose() const {
    const auto estimate = estimator_.estimate();
    if (!estimate || !estimate->in_map) {
      return std::nullopt;
    }
    const SE3 T_map_body = estimate->state.T_map_body();
    return leak_findings::FramePose{
        .T_map_base = T_map_body,
        .covariance =
            turned(estimator_.covariance().topLeftCorner<6, 6>(), T_map_body.rotation().matrix())};
  }

  void steer(double now) {
    const auto T_rack_base = servo_.T_rack_base(now);
    std::optional<rack_vision::LevelPose> pose;
    if (T_rack_base) {
      pose = rack_vision::LevelPose{.time = *servo_.pose_time(),
                                    .position = T_rack_base->translation(),
                                    .yaw = T_rack_base->rotation().roll_pitch_yaw().z()};
    }
    mission_.advance(now, pose);
    const auto command = servo_.step(now, mission_.target(servo_.pose_time().value_or(now)));
    flight_.command({.velocity = command.linear, .yaw_rate = command.angular.z()});
  }

  void score_findings() {
    score_.hot_spots = spots_.size();
    std::vector<bool> found(spots_.size(), false);
    const double within = statistics::chi_square_quantile(0.95, 3);
    for (const leak_findings::Finding& finding : findings_.findings()) {
      if (finding.state != leak_findings::FindingState::kRaised) {
        continue;
      }
      const std::optional<std::size_t> spot = spot_of(finding);
      if (!spot || found[*spot]) {
        ++score_.false_findings;
        continue;
      }
      found[*spot] = true;
      ++score_.found;
      const Vector3d error = position_error(spots_[*spot], true_, finding.position->point);
      score_.position_errors.push_back(error.norm());
      score_.covered +=
          error.dot(finding.position->covariance.ldlt().solve(error)) <= within ? 1 : 0;
    }
    for (std::size_t i = 0; i < spots_.size(); ++i) {
      if (!found[i]) {
        score_.missed.push_back(spots_[i]);
      }
    }
  }

  [[nodiscard]] std::optional<std::size_t> spot_of(const leak_findings::Finding& finding) const {
    std::optional<std::size_t> nearest;
    double least = kSame;
    for (std::size_t i = 0; finding.position && i < spots_.size(); ++i) {
      const double error = position_error(spots_[i], true_, finding.position->point).norm();
      if (error < least) {
        least = error;
        nearest = i;
      }
    }
    return nearest;
  }

  RackInspectionSettings settings_;
  Draw draw_;
  RackModel filed_;
  RackModel true_;
  std::vector<HotSpot> spots_;
  rack_vision::WayPointMission mission_;
  SE3 T_base_camera_ = rack_vision::downward_camera();
  simulation::RackFlight flight_;
  rack_vision::VisualServo servo_;
  geometry::Camera camera_;
  rack_vision::RackLocalization localization_;
  estimation::StateEstimator estimator_;
  thermal::LeakDetector detector_;
  leak_findings::LeakFindings findings_;
  thermal::TemperatureTable table_;
  std::vector<std::uint8_t> grey_;
  std::vector<std::uint16_t> counts_;
  Vector3d angular_rate_ = Vector3d::Zero();
  RackInspectionScore score_;
};

}  // namespace

void RackInspectionSettings::validate() const {
  constexpr std::size_t kMostSpots = 8;
  if (hot_spots > kMostSpots) {
    validation::refuse("hot_spots: ", hot_spots, " is outside [0, ", kMostSpots, "]");
  }
  validation::check_within("offset_deviation", offset_deviation, 0, 0.05);
  validation::check_within("wind_at_20_feet", wind_at_20_feet, 0, 10);
  validation::check_within("longest", longest, 1, 600);
}

std::vector<HotSpot> draw_hot_spots(const RackModel& model, std::size_t count, std::uint64_t seed) {
  constexpr double kApart = 0.6;  // m
  Draw draw(seed, kSpotDraws);
  std::vector<HotSpot> spots;
  while (spots.size() < count) {
    const HotSpot next = draw_hot_spot(model, draw);
    const bool free = std::ranges::none_of(spots, [&](const HotSpot& other) {
      return other.pipe == next.pipe &&
             std::abs(other.along - next.along) < 0.5 * (other.length + next.length) + kApart;
    });
    if (free && !is_hidden(next, model)) {
      spots.push_back(next);
    }
  }
  return spots;
}

Vector3d position_error(const HotSpot& spot, const RackModel& model, const Vector3d& point) {
  const Vector3d middle = place_of(spot, model);
  if (spot.half_angle < std::numbers::pi) {
    return point - middle;
  }
  const rack_vision::Pipe& pipe = model.pipes[spot.pipe];
  const Vector3d on_axis = pipe.start + spot.along * pipe.direction;
  const Vector3d off = point - on_axis;
  const Vector3d outwards = off - pipe.direction * pipe.direction.dot(off);
  return off - (middle - on_axis).norm() * outwards.normalized();
}

RackInspectionScore inspect_rack(const RackInspectionSettings& settings, std::uint64_t seed) {
  return Inspection(settings, seed).run();
}

}  // namespace pipescout::leak_study
