// SPDX-License-Identifier: Apache-2.0
#include "pipescout/leak_study/sequence_run.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <numeric>
#include <string>

#include "pipescout/statistics/chi_square.hpp"
#include "pipescout/thermal/temperature_table.hpp"
#include "pipescout/validation/check.hpp"
#include "pose_noise.hpp"

namespace pipescout::leak_study {
namespace {

using Eigen::Vector3d;
using leak_findings::LeakFindings;
using simulation::ThermalPatrol;

constexpr double kNear = 1;          // m, beyond the ends of a leak that a finding may be
constexpr double kGreyLowest = 100;  // degC
constexpr double kGreyHighest = 300;

/// How pictures come, and what they mean to who knows nothing of the scene but the paper's
/// settings.
class Pictures {
 public:
  Pictures(const SequencePlan& plan, bool by_contrast)
      : width_(plan.patrol.camera.camera.width),
        height_(plan.patrol.camera.camera.height),
        grey_(plan.grey || plan.automatic_gain),
        automatic_(plan.automatic_gain),
        radiometry_(plan.patrol.camera.constants, thermal::ibarguren2013_object()),
        greys_(radiometry_, kGreyLowest, kGreyHighest),
        table_(table_of(plan, by_contrast)),
        counts_(static_cast<std::size_t>(width_) * static_cast<std::size_t>(height_)),
        levels_(grey_ ? counts_.size() : 0) {}

  const thermal::Detections& look(ThermalPatrol& patrol, std::uint64_t frame,
                                  const thermal::FrameConditions& conditions,
                                  thermal::LeakDetector& detector) {
    patrol.render(frame, counts_);
    if (grey_) {
      if (automatic_) {
        gain_.convert(counts_, levels_);
      } else {
        greys_.convert(counts_, levels_);
      }
      return detector.detect(thermal::GreyView{levels_.data(), width_, height_, width_},
                             table_.degrees(), conditions);
    }
    return detector.detect(thermal::CountView{counts_.data(), width_, height_, width_},
                           table_.degrees(), conditions);
  }

 private:
  static thermal::TemperatureTable table_of(const SequencePlan& plan, bool by_contrast) {
    if (plan.automatic_gain) {
      return thermal::TemperatureTable::of_grey(0, thermal::kGreyLevels);
    }
    if (plan.grey) {
      return thermal::TemperatureTable::of_grey(kGreyLowest, kGreyHighest);
    }
    return thermal::TemperatureTable(
        by_contrast
            ? thermal::apparent_radiometry(plan.patrol.camera.constants)
            : thermal::Radiometry(plan.patrol.camera.constants, thermal::ibarguren2013_object()));
  }

  int width_;
  int height_;
  bool grey_;
  bool automatic_;
  thermal::Radiometry radiometry_;
  simulation::ThermalGreys greys_;
  simulation::ThermalAutomaticGain gain_;
  thermal::TemperatureTable table_;
  std::vector<std::uint16_t> counts_;
  std::vector<std::uint8_t> levels_;
};

/// Which leak is at a place along the row, if any.
std::optional<std::size_t> leak_at(const simulation::ThermalSceneParameters& scene, double place) {
  std::optional<std::size_t> nearest;
  double least = kNear;
  for (std::size_t i = 0; i < scene.leaks.size(); ++i) {
    const double beyond = std::abs(place - scene.leaks[i].place) - scene.leaks[i].length / 2;
    if (beyond <= least) {
      least = beyond;
      nearest = i;
    }
  }
  return nearest;
}

/// K, the mean over the length of a leak; NaN where it saturates the camera.
double true_delta(const simulation::ThermalScene& scene, std::size_t which, double highest) {
  const simulation::ThermalLeak& leak = scene.parameters().leaks[which];
  constexpr int kSteps = 100;
  double sum = 0;
  for (int i = 0; i < kSteps; ++i) {
    const double place = leak.place + leak.length * ((i + 0.5) / kSteps - 0.5);
    if (scene.tube_temperature(place) > highest) {
      return std::numeric_limits<double>::quiet_NaN();
    }
    sum += simulation::ThermalScene::rise_of(leak, place);
  }
  return sum / kSteps;
}

FindingScore score_finding(const leak_findings::Finding& finding,
                           const simulation::ThermalScene& scene, double highest) {
  FindingScore score;
  score.mean_delta = finding.mean_delta;
  score.delta_interval = finding.mean_delta_interval;
  score.length = finding.length;
  score.place = std::numeric_limits<double>::quiet_NaN();
  if (!finding.position) {
    return score;
  }
  const geometry::SE3 T_row_map = scene.parameters().T_map_row.inverse();
  score.place = (T_row_map * finding.position->point).x();
  score.leak = leak_at(scene.parameters(), score.place);
  if (score.leak) {
    score.true_delta = true_delta(scene, *score.leak, highest);
    const Vector3d error =
        finding.position->point - scene.on_tube(scene.parameters().leaks[*score.leak].place);
    const Eigen::Matrix3d& covariance = finding.position->covariance;
    score.position_error = error.norm();
    score.square = error.dot(covariance.ldlt().solve(error));
    const Eigen::Vector2d level = error.head<2>();
    score.level_square = level.dot(covariance.topLeftCorner<2, 2>().ldlt().solve(level));
  }
  return score;
}

/// Detections of single frames that are of no leak: by the leaks' own place in the image.
std::size_t false_ones(const thermal::Detections& detections,
                       const simulation::ThermalTruth& truth) {
  return static_cast<std::size_t>(
      std::ranges::count_if(detections.leaks, [&truth](const thermal::LeakDetection& detection) {
        const Eigen::Vector2d centre = detection.centre();
        return std::ranges::none_of(truth.leaks, [&](const simulation::LeakInImage& leak) {
          const Eigen::Vector2d middle = (leak.stretch.from + leak.stretch.to) / 2;
          const double half = (leak.stretch.to - leak.stretch.from).norm() / 2;
          return (centre - middle).norm() <= half + 2 * leak.stretch.width;
        });
      }));
}

/// Which pieces of the tube have been in a picture with their whole width.
class SeenTube {
 public:
  SeenTube(const simulation::ThermalScene& scene, const geometry::Camera& camera)
      : scene_(scene),
        camera_(camera),
        seen_(static_cast<std::size_t>(std::floor(scene.parameters().length / kPiece)), false) {}

  /// A picture that was taken from abreast of `place`.
  void add(const geometry::SE3& T_map_camera, double place) {
    const geometry::SE3 T_camera_map = T_map_camera.inverse();
    const Vector3d up(0, 0, scene_.parameters().tube_radius);
    const auto piece = [this](double at) {
      return static_cast<std::size_t>(
          std::clamp(at / kPiece, 0.0, static_cast<double>(seen_.size())));
    };
    for (std::size_t i = piece(place - kReach); i < piece(place + kReach); ++i) {
      const Vector3d middle = scene_.on_tube((static_cast<double>(i) + 0.5) * kPiece);
      seen_[i] = seen_[i] || (in_picture(T_camera_map * (middle + up)) &&
                              in_picture(T_camera_map * (middle - up)));
    }
  }
  [[nodiscard]] double metres() const {
    return kPiece * static_cast<double>(std::ranges::count(seen_, true));
  }

 private:
  static constexpr double kPiece = 0.1;  // m
  static constexpr double kReach = 20;   // m, along the row

  [[nodiscard]] bool in_picture(const Vector3d& point) const {
    const auto pixel = camera_.project(point);
    return pixel && camera_.contains(*pixel);
  }

  const simulation::ThermalScene& scene_;
  const geometry::Camera& camera_;
  std::vector<bool> seen_;
};

void drive_until(double time, ThermalPatrol& patrol, CameraCarrier* carrier) {
  if (carrier == nullptr) {
    patrol.drive_until(time);
    return;
  }
  while (patrol.robot().motion().time < time - simulation::GroundRobot::kStep / 2) {
    patrol.step();
    carrier->step(patrol);
  }
}

double percent_within(const std::vector<double>& squares, double most) {
  const auto inside =
      std::ranges::count_if(squares, [most](double square) { return square <= most; });
  return squares.empty() ? 0
                         : 100 * static_cast<double>(inside) / static_cast<double>(squares.size());
}

template <class Value>
void append(std::vector<Value>& to, const std::vector<Value>& values) {
  to.insert(to.end(), values.begin(), values.end());
}

}  // namespace

std::size_t SequenceScore::false_findings() const {
  return static_cast<std::size_t>(std::ranges::count_if(
      findings, [](const FindingScore& each) { return !each.leak || !each.first; }));
}

SequenceScore run_sequence(const SequencePlan& plan, const InspectionSettings& settings,
                           std::uint64_t seed, CameraCarrier* carrier) {
  validation::check_within("frame_rate", settings.frame_rate, 1, 200);
  settings.pose.validate();
  ThermalPatrol patrol(plan.patrol);
  const simulation::ThermalScene& scene = patrol.scene();
  internal::PoseNoise noise(settings.pose, seed);
  Pictures pictures(plan, settings.by_contrast);
  thermal::LeakDetectorParameters detection =
      settings.by_contrast ? thermal::LeakDetectorParameters::by_contrast() : settings.detector;
  leak_findings::LeakFindingsParameters parameters = settings.findings;
  parameters.pipe_diameter = 2 * plan.patrol.scene.tube_radius;
  if (parameters.range_source == leak_findings::RangeSource::kDiameter) {
    detection.pipe_diameter = parameters.pipe_diameter;
  }
  thermal::LeakDetector detector(detection);
  parameters.T_base_camera = noise.mounting(plan.patrol.T_body_camera);
  parameters.mounting_attitude_deviation = settings.pose.mounting_deviation;
  parameters.mounting_position_deviation = settings.pose.mounting_shift_deviation;
  const double length = plan.patrol.scene.length;
  parameters.lines = {noise.line(scene.on_tube(0), scene.on_tube(length))};
  constexpr double kLeastDeviation = 1e-3;  // m: none is not accepted
  parameters.line_deviation = std::max(settings.pose.line_deviation, kLeastDeviation);
  LeakFindings findings(parameters, patrol.renderer().camera());
  std::optional<thermal::RadiometryPosterior> posterior;
  if (settings.by_contrast && !plan.grey && !plan.automatic_gain) {
    posterior.emplace(plan.patrol.camera.constants, thermal::ibarguren2013_object(),
                      settings.deviations, settings.pipe_temperature);
  }

  SequenceScore score;
  score.found.assign(plan.patrol.scene.leaks.size(), false);
  std::vector<std::uint64_t> raised;
  std::vector<std::size_t> frames_to_raise;
  simulation::ThermalTruth truth;
  SeenTube seen(scene, patrol.renderer().camera());
  for (std::uint64_t i = 0; patrol.place() < length && !patrol.arrived(); ++i) {
    const double time = static_cast<double>(i) / settings.frame_rate;
    drive_until(time, patrol, carrier);
    leak_findings::Frame frame{
        .time = time, .number = i, .pose = noise.measure(patrol.robot().motion().T_map_body, time)};
    if (carrier != nullptr) {
      frame.T_base_camera = carrier->T_base_camera();
    }
    if (patrol.place() < 0) {
      continue;
    }
    thermal::FrameConditions conditions = findings.conditions(frame);
    conditions.posterior = posterior ? &*posterior : nullptr;
    if (plan.automatic_gain) {
      conditions.levels = true;
    }
    const thermal::Detections& detections = pictures.look(patrol, i, conditions, detector);
    if (const thermal::PipeSection* pipe = detections.main_pipe(); posterior && pipe != nullptr) {
      posterior->observe(pipe->reference_temperature);
    }
    const leak_findings::FrameResult& result = findings.update(frame, detections);
    if (carrier != nullptr) {
      carrier->see(frame, detections);
    }
    seen.add(patrol.view(i).T_map_camera, patrol.place());
    ++score.frames;
    score.frame_faults += detections.fault == thermal::FrameFault::kNone ? 0 : 1;
    patrol.renderer().truth(patrol.view(i), truth);
    score.false_detections += false_ones(detections, truth);
    for (const leak_findings::Event& event : result.events) {
      if (event.kind == leak_findings::EventKind::kRaised) {
        raised.push_back(event.finding);
        frames_to_raise.push_back(findings.find(event.finding)->frames);
      }
    }
  }
  score.metres = length;
  score.true_tube = plan.patrol.scene.tube_temperature;
  if (posterior) {
    score.tube = posterior->pipe_temperature();
  }
  score.metres_seen = seen.metres();
  for (std::size_t i = 0; i < raised.size(); ++i) {
    const leak_findings::Finding* finding = findings.find(raised[i]);
    if (finding == nullptr) {
      continue;
    }
    FindingScore each = score_finding(*finding, scene, plan.patrol.camera.highest);
    each.frames_to_raise = frames_to_raise[i];
    if (each.leak) {
      each.first = !score.found[*each.leak];
      score.found[*each.leak] = true;
    }
    score.findings.push_back(each);
  }
  return score;
}

void CampaignScore::add(const SequencePlan& plan, const SequenceScore& score) {
  ++sequences;
  leaks += score.found.size();
  faint_leaks += plan.faint_leaks;
  near_leaks += plan.near_leaks;
  for (std::size_t i = 0; i < score.found.size(); ++i) {
    found += score.found[i] ? 1 : 0;
    faint_found += score.found[i] && i < plan.faint_leaks ? 1 : 0;
    near_found += score.found[i] && i + plan.near_leaks >= score.found.size() ? 1 : 0;
  }
  false_findings += score.false_findings();
  metres += score.metres;
  metres_seen += score.metres_seen;
  for (const FindingScore& finding : score.findings) {
    if (finding.leak && finding.first) {
      position_errors.push_back(finding.position_error);
      level_squares.push_back(finding.level_square);
      squares.push_back(finding.square);
      frames_to_raise.push_back(finding.frames_to_raise);
      if (std::isfinite(score.tube.mean) && std::isfinite(finding.true_delta)) {
        add_interval(finding.delta_interval.low, finding.delta_interval.high, finding.true_delta);
        relative_widths.push_back((finding.delta_interval.high - finding.delta_interval.low) /
                                  (2 * finding.true_delta));
      }
    }
  }
  if (std::isfinite(score.tube.mean)) {
    add_interval(score.tube.low, score.tube.high, score.true_tube);
  }
}

void CampaignScore::add_interval(double low, double high, double truth) {
  ++intervals;
  covering += low <= truth && truth <= high ? 1U : 0U;
}

CampaignScore& CampaignScore::operator+=(const CampaignScore& other) {
  sequences += other.sequences;
  leaks += other.leaks;
  found += other.found;
  faint_leaks += other.faint_leaks;
  faint_found += other.faint_found;
  near_leaks += other.near_leaks;
  near_found += other.near_found;
  false_findings += other.false_findings;
  metres += other.metres;
  metres_seen += other.metres_seen;
  append(position_errors, other.position_errors);
  append(level_squares, other.level_squares);
  append(squares, other.squares);
  append(frames_to_raise, other.frames_to_raise);
  intervals += other.intervals;
  covering += other.covering;
  append(relative_widths, other.relative_widths);
  return *this;
}

double CampaignScore::found_percent() const {
  return leaks == 0 ? 100 : 100 * static_cast<double>(found) / static_cast<double>(leaks);
}

double CampaignScore::seen_percent() const {
  return metres == 0 ? 100 : 100 * metres_seen / metres;
}

double CampaignScore::level_coverage_percent() const {
  return percent_within(level_squares, statistics::chi_square_quantile(0.95, 2));
}

double CampaignScore::coverage_percent() const {
  return percent_within(squares, statistics::chi_square_quantile(0.95, 3));
}

double CampaignScore::near_percent() const {
  return near_leaks == 0 ? 100
                         : 100 * static_cast<double>(near_found) / static_cast<double>(near_leaks);
}

double CampaignScore::false_per_km() const {
  return metres == 0 ? 0 : 1000 * static_cast<double>(false_findings) / metres;
}

double CampaignScore::temperature_coverage_percent() const {
  return intervals == 0 ? 0 : 100 * static_cast<double>(covering) / static_cast<double>(intervals);
}

}  // namespace pipescout::leak_study
