// SPDX-License-Identifier: Apache-2.0
#include "replay.hpp"

#include <algorithm>
#include <cmath>
#include <optional>
#include <stdexcept>
#include <type_traits>
#include <utility>
#include <variant>

#include "pipescout/command_line/formatted.hpp"
#include "pipescout/csv/csv_cell.hpp"
#include "pipescout/estimation/planar_motion.hpp"
#include "pipescout/statistics/median.hpp"

namespace pipescout::estimate {
namespace {

using command_line::formatted;
using Eigen::Vector3d;
using estimation::GpsMeasurement;
using estimation::ImuReading;
using estimation::OdometerReading;
using estimation::Source;
using estimation::SourceState;
using estimation::WheelTurn;

/// Of the distance, without slip that lasts: as in car and lawnmower studies.
constexpr double kOdometerVariance = 1e-4;  // m^2 per m
constexpr double kUnknownHeight = 1e4;      // m
constexpr std::size_t kReportEvery = 2000;
/// Of the way, of dead reckoning with a heading that is just known.
constexpr double kEarlyDrift = 0.1;
constexpr double kNever = 1e300;             // s
constexpr double kLongestOdometerGap = 1.0;  // s

struct Event {
  double time;
  std::variant<ImuReading, OdometerReading, WheelTurn, GpsMeasurement, FurtherReading> reading;
};

/// Normal gravity of GRS80 at the ellipsoid (Moritz 2000, eq. 2-146, in the series of 1967 form),
/// and its change with height.
double normal_gravity(const geometry::GeodeticPosition& place) {
  const double s = std::pow(std::sin(place.latitude * kDegree), 2);
  const double s2 = std::pow(std::sin(2 * place.latitude * kDegree), 2);
  return 9.780327 * (1 + 0.0053024 * s - 0.0000058 * s2) - 3.086e-6 * place.altitude;
}

const Stream* chosen(const Recording& recording, const std::string& name, Kind kind) {
  if (name.empty()) {
    return nullptr;
  }
  const Stream* found = recording.find(name, kind);
  if (found == nullptr) {
    throw std::invalid_argument(std::string(to_string(kind)) + ".source: the recording has no " +
                                to_string(kind) + " '" + name + "'");
  }
  return found->rows() == 0 ? nullptr : found;
}

double median_step(const std::vector<ImuRow>& rows) {
  std::vector<double> steps;
  for (std::size_t i = 1; i < rows.size(); ++i) {
    steps.push_back(rows[i].time - rows[i - 1].time);
  }
  if (steps.empty()) {
    return 0.01;
  }
  return statistics::median(std::move(steps));
}

std::string degrees(const geometry::SO3& rotation) {
  const Vector3d a = rotation.roll_pitch_yaw() / kDegree;
  return formatted("roll %.1f, pitch %.1f, yaw %.1f degrees", a.x(), a.y(), a.z());
}

/// The mounting of the IMU: of the configuration, of the transforms, or none.
geometry::SO3 imu_mounting(const Recording& recording, const Configuration& c, const Stream& imu,
                           std::vector<std::string>& said) {
  if (c.imu_rotation) {
    const auto result = geometry::SO3::from_roll_pitch_yaw(*c.imu_rotation * kDegree);
    said.push_back(imu.name + ": mounted with " + degrees(result) + ", from the configuration.");
    return result;
  }
  if (imu.frame.empty() || imu.frame == c.base_frame) {
    said.push_back(imu.name + ": its frame is that of the base, so that no mounting is applied.");
    return {};
  }
  if (const auto pose = recording.mounting(c.base_frame, imu.frame)) {
    said.push_back(imu.name + ": mounted with " + degrees(pose->rotation()) +
                   ", from the transforms (" + c.base_frame + " to " + imu.frame + ").");
    return pose->rotation();
  }
  said.push_back(
      imu.name + ": header.frame_id '" + imu.frame + "' is not connected to the base frame '" +
      c.base_frame +
      "' by fixed transforms; its axes are taken for those of the base. Set imu.rotation if "
      "they are not.");
  return {};
}

/// With stamps that were late moved to when it was measured.
Stream in_time(Stream odometer, double delay) {
  odometer.shift(-delay);
  return odometer;
}

void add_odometer_events(const Stream& odometer, double scale, std::vector<Event>& events) {
  double distance = 0;
  double way = 0;
  for (std::size_t i = 0; i < odometer.odometer.size(); ++i) {
    const OdometerRow& row = odometer.odometer[i];
    if (i > 0) {
      const OdometerRow& before = odometer.odometer[i - 1];
      const double step = scale * (row.time - before.time) * (row.speed + before.speed) / 2;
      distance += step;
      way += std::abs(step);
    }
    events.push_back({row.time, OdometerReading{.time = row.time,
                                                .distance = distance,
                                                .variance = kOdometerVariance * way}});
    if (row.yaw_rate) {
      events.push_back({row.time, WheelTurn{.time = row.time, .yaw_rate = *row.yaw_rate}});
    }
  }
}

/// What an IMU on level ground would read when the vehicle moves as its odometer says.
void add_implied_imu(const Stream& odometer, double scale, double gravity,
                     std::vector<Event>& events) {
  estimation::PlanarMotion motion({.gravity = gravity, .longest_gap = kLongestOdometerGap});
  double yaw_rate = 0;
  for (const OdometerRow& row : odometer.odometer) {
    yaw_rate = row.yaw_rate.value_or(yaw_rate);
    for (const ImuReading& reading : motion.add(row.time, scale * row.speed, yaw_rate)) {
      events.push_back({reading.time, reading});
    }
  }
}

void add_gps_events(const Stream& gps, const Configuration& c, const geometry::LocalFrame& map,
                    Trajectory& result, std::vector<Event>& events) {
  std::size_t unstated = 0;
  for (const GpsRow& row : gps.gps) {
    GpsMeasurement m{.time = row.time, .position = map.position(row.place)};
    if (row.covariance) {
      const Eigen::Matrix3d axes = map.axes_at(row.place);
      m.covariance = c.gps_factor * c.gps_factor * axes * *row.covariance * axes.transpose();
      m.covariance = (0.5 * (m.covariance + m.covariance.transpose())).eval();
    } else {
      ++unstated;
      m.covariance.diagonal() << 1, 1, 4;  // heights are about twice as bad
      m.covariance *= c.gps_deviation * c.gps_deviation;
    }
    if (!row.has_height) {
      m.position.z() = 0;
      m.covariance.row(2).setZero();
      m.covariance.col(2).setZero();
      m.covariance(2, 2) = kUnknownHeight * kUnknownHeight;
    }
    result.fixes.push_back(
        {.time = row.time,
         .position = m.position,
         .deviation = std::sqrt(m.covariance.topLeftCorner<2, 2>().trace() / 2)});
    events.push_back({row.time, m});
  }
  if (unstated > 0) {
    result.said.push_back(gps.name + ": " + std::to_string(unstated) + " of " +
                          std::to_string(gps.gps.size()) +
                          " fixes state no usable covariance; gps.deviation " +
                          format_csv_number(c.gps_deviation) + " m is used for them.");
  }
}

estimation::StateEstimatorParameters parameters_for(const Configuration& c, bool odometer,
                                                    double imu_step, double gravity,
                                                    double fastest) {
  using estimation::StateEstimatorParameters;
  auto p = odometer ? StateEstimatorParameters::ground_robot() : StateEstimatorParameters::uav();
  p.smoother.gravity = gravity;
  p.smoother.imu_noise.gyro = c.gyro_noise;
  p.smoother.imu_noise.accelerometer = c.accelerometer_noise;
  p.specific_force_scale = c.specific_force_scale;
  p.start.hover_speed = 0;
  p.start.largest_speed = std::clamp(2 * fastest, 5.0, 100.0);
  p.odometer.largest_speed = std::clamp(3 * fastest, 30.0, 1000.0);
  p.odometer.largest_gap = kLongestOdometerGap;
  p.gps.correlation_time = c.gps_correlation;
  p.gps.shortest_correlation_time =
      c.gps_shortest_correlation.value_or(p.gps.shortest_correlation_time);
  p.smoother.global_deviations.gps_time_offset = c.gps_time_offset_deviation;
  p.gps.confirmed_takeover = p.gps.takeover;
  // Slow IMUs: a gap is several of their own steps.
  p.largest_imu_gap = std::clamp(4 * imu_step, p.largest_imu_gap, 1.0);
  p.imu_silence = std::clamp(6 * imu_step, p.imu_silence, 5.0);
  p.smoother.max_held_imu = std::clamp(2 * imu_step, p.smoother.max_held_imu, 1.0);
  p.keyframe_period = std::clamp(imu_step, p.keyframe_period, 1.0);
  return p;
}

/// Notes what changes while the estimator runs.
class Watcher {
 public:
  explicit Watcher(Trajectory& result) : result_(result) {}

  void look(double time, const estimation::EstimatorStatus& status) {
    if (status.phase != phase_) {
      phase_ = status.phase;
      std::string what = "the estimator is " + std::string(to_string(phase_));
      if (!status.text.empty()) {
        what += ": " + status.text;
      }
      result_.changes.push_back({time, std::move(what)});
    }
    const SourceState gps = status.of(Source::kGps).state;
    if (gps != gps_) {
      gps_ = gps;
      result_.changes.push_back({time, "GPS is " + std::string(to_string(gps))});
    }
    std::size_t restarts = 0;
    for (const std::size_t n : status.restarts) {
      restarts += n;
    }
    if (restarts != restarts_) {
      restarts_ = restarts;
      result_.changes.push_back(
          {time, "the state was reset: " + std::string(to_string(status.last_restart))});
    }
  }

  /// After a fix at `position` was handed over.
  void compare(double time, const Vector3d& position, const estimation::EstimatorStatus& status,
               const std::optional<estimation::Estimate>& estimate) {
    const bool in_map = estimate && estimate->in_map;
    // Fixes that the start needed for itself are not held out.
    const bool out = in_map && was_in_map_ && status.of(Source::kGps).held > held_;
    was_in_map_ = in_map;
    held_ = status.of(Source::kGps).held;
    if (!out) {
      open_ = open_ && time - result_.held.back().end < 1;
      return;
    }
    if (!open_) {
      result_.held.push_back({.begin = time});
      open_ = true;
    }
    HeldOut& held = result_.held.back();
    held.end = time;
    ++held.fixes;
    held.farthest = std::max(held.farthest, (estimate->state.position - position).head<2>().norm());
  }

 private:
  Trajectory& result_;
  estimation::Phase phase_ = estimation::Phase::kStarting;
  SourceState gps_ = SourceState::kAbsent;
  std::size_t restarts_ = 0;
  std::size_t held_ = 0;
  bool was_in_map_ = false;
  bool open_ = false;
};

/// A pose before the estimator knew its place in the map, by dead reckoning from the levelling on.
struct EarlyPose {
  double time;
  geometry::SE3 T_odom_body;
  Vector3d velocity;  // m/s, in `odom`
};

/// Puts the way before the start in front of the trajectory.
void prepend(const std::vector<EarlyPose>& early, const estimation::Estimate& first,
             const Vector3d& deviation, Trajectory& result) {
  // The errors of dead reckoning grow backwards from the start.
  double way = 0;
  std::vector<double> ways(early.size());
  for (std::size_t i = early.size(); i-- > 0;) {
    if (i + 1 < early.size()) {
      way += (early[i + 1].T_odom_body.translation() - early[i].T_odom_body.translation()).norm();
    }
    ways[i] = way;
  }
  for (std::size_t i = 0; i < early.size(); ++i) {
    const EarlyPose& pose = early[i];
    const geometry::SE3 T_map_body = first.T_map_odom * pose.T_odom_body;
    const Vector3d grown = deviation.array() + kEarlyDrift * ways[i];
    result.points.push_back({.time = pose.time,
                             .position = T_map_body.translation(),
                             .orientation = T_map_body.rotation().quaternion(),
                             .velocity = first.T_map_odom.rotation() * pose.velocity,
                             .position_deviation = grown});
  }
  if (!early.empty()) {
    result.said.push_back(formatted(
        "Poses before %.1f s are dead reckoning, put into the map when the start was known.",
        first.time));
  }
}

estimation::GivenPose given(const Start& start, double time) {
  return {.time = time,
          .position = start.position,
          .position_deviation = start.position_deviation,
          .heading = start.heading * kDegree,
          .heading_deviation = start.heading_deviation * kDegree};
}

void run(const std::vector<Event>& events, const estimation::StateEstimatorParameters& parameters,
         const std::optional<estimation::GivenPose>& start, FurtherInputs& further,
         Trajectory& result, const Progress& progress) {
  estimation::StateEstimator estimator(parameters);
  if (start) {
    estimator.add(*start);
  }
  Vector3d rate = Vector3d::Zero();  // rad/s, of the body, by the newest reading of the gyro
  Watcher watcher(result);
  std::vector<EarlyPose> early;
  std::uint64_t updates = 0;
  for (std::size_t i = 0; i < events.size(); ++i) {
    const Event& event = events[i];
    if (i % kReportEvery == 0) {
      progress("estimating", static_cast<double>(i) / static_cast<double>(events.size()));
    }
    if (const auto* reading = std::get_if<FurtherReading>(&event.reading)) {
      further.take(*reading, rate, estimator);
    }
    std::visit(
        [&]<class Reading>(const Reading& reading) {
          if constexpr (!std::is_same_v<Reading, FurtherReading>) {
            (void)estimator.add(reading);
          }
        },
        event.reading);
    if (const auto* imu = std::get_if<ImuReading>(&event.reading)) {
      rate = parameters.R_body_imu * imu->angular_rate;
    }
    if (const auto* fix = std::get_if<GpsMeasurement>(&event.reading)) {
      const auto status = estimator.status();
      watcher.look(event.time, status);
      watcher.compare(event.time, fix->position, status, estimator.estimate());
    }
    if (estimator.updates() == updates) {
      continue;
    }
    updates = estimator.updates();
    if (updates % 10 == 0) {
      watcher.look(event.time, estimator.status());
    }
    const auto estimate = estimator.estimate();
    if (!estimate) {
      early.clear();
      continue;
    }
    const double newest = result.points.empty() ? early.empty() ? -kNever : early.back().time
                                                : result.points.back().time;
    if (estimate->time <= newest) {
      continue;
    }
    if (!estimate->in_map) {
      // Without an odometer the way before the start is that of the accelerometer: unknown.
      if (result.points.empty() && estimator.status().of(Source::kOdometer).accepted > 0) {
        early.push_back({estimate->time, estimate->T_odom_body, estimate->state.velocity});
      }
      continue;
    }
    const auto covariance = estimator.covariance();
    const Vector3d deviation =
        covariance.diagonal().segment<3>(estimation::kPosition).cwiseMax(0).cwiseSqrt();
    if (result.points.empty()) {
      result.started = estimate->time;
      prepend(early, *estimate, deviation, result);
    }
    result.points.push_back({.time = estimate->time,
                             .position = estimate->state.position,
                             .orientation = estimate->state.R_map_body.quaternion(),
                             .velocity = estimate->state.velocity,
                             .position_deviation = deviation});
    result.odometer_scale = estimator.smoother().globals().odometer_scale;
    result.gps_delay = estimator.smoother().globals().gps_time_offset;
    result.gps_delay_deviation =
        std::sqrt(std::max(0.0, estimator.smoother().global_covariance()(
                                    estimation::kGpsTimeOffset, estimation::kGpsTimeOffset)));
    result.gyro_bias = estimate->state.gyro_bias;
    result.accelerometer_bias = estimate->state.accelerometer_bias;
  }
  result.recorded_until = events.empty() ? 0 : events.back().time;
  result.status = estimator.status();
  result.gps_correlation = estimator.correlation_of(Source::kGps);
  result.further = further.outcomes(estimator, parameters);
}

}  // namespace

Trajectory estimate_trajectory(const Recording& recording, const Configuration& configuration,
                               bool apply_mounting, const Progress& progress) {
  Configuration c = configuration;
  const Stream* imu = chosen(recording, c.imu, Kind::kImu);
  const Stream* odometer = chosen(recording, c.odometer, Kind::kOdometer);
  const Stream* gps = chosen(recording, c.gps, Kind::kGps);
  std::optional<Stream> moved;
  if (odometer != nullptr && c.odometer_delay != 0) {
    odometer = &moved.emplace(in_time(*odometer, c.odometer_delay));
  }
  Trajectory result;
  std::vector<Event> events;
  std::optional<geometry::LocalFrame> map;
  double gravity = 9.81;
  geometry::SO3 R_body_imu;
  if (imu != nullptr) {
    R_body_imu = imu_mounting(recording, c, *imu, result.said);
    result.mounting = examine_mounting(*imu, odometer, R_body_imu);
    if (result.mounting.gravity == Gravity::kUnitG && c.specific_force_scale == 1) {
      c.specific_force_scale = 9.80665;
    }
    if (apply_mounting && result.mounting.R_body_imu) {
      R_body_imu = *result.mounting.R_body_imu;
      result.mounting.tilt = 0;
      result.said.push_back(imu->name + ": as asked by --apply-mounting, mounted with " +
                            degrees(R_body_imu) + ".");
    }
    const double scaled = result.mounting.mean_force * c.specific_force_scale;
    const bool sound = std::abs(scaled - 9.81) < 1.5 && result.mounting.tilt < 40 * kDegree;
    if (!sound) {
      result.said.push_back(imu->name +
                            ": not used, because its accelerometer contradicts gravity in the "
                            "assumed mounting or unit; see the findings.");
      imu = nullptr;
    }
  }
  if (gps != nullptr) {
    result.datum = gps->gps.front().place;
    map.emplace(*result.datum);
    gravity = normal_gravity(*result.datum);
    add_gps_events(*gps, c, *map, result, events);
    result.track = examine_gps(*gps, result.fixes, odometer, c.odometer_scale, imu,
                               R_body_imu.inverse() * Vector3d::UnitZ());
    if (result.track.gyro_is_opposite) {
      result.said.push_back(imu->name +
                            ": not used, because it turns against the course of GPS; see the "
                            "findings.");
      imu = nullptr;
    }
  }
  if (!result.track.gyro_is_opposite && !result.track.odometer_is_opposite &&
      !result.mounting.opposite_rates.empty()) {
    result.mounting.findings.push_back(result.mounting.opposite_rates);
  }
  const bool turns =
      odometer != nullptr && !result.track.odometer_is_opposite &&
      std::ranges::any_of(odometer->odometer, [](const auto& r) { return r.yaw_rate.has_value(); });
  if (imu == nullptr && !turns) {
    std::string what =
        "no trajectory: there is no usable IMU, and no odometer with a usable yaw rate.";
    for (const auto& findings : {result.mounting.findings, result.track.findings}) {
      for (const std::string& finding : findings) {
        what += " " + finding;
      }
    }
    throw std::invalid_argument(what);
  }
  result.with_imu = imu != nullptr;

  double fastest = 0;
  if (gps != nullptr) {
    for (std::size_t i = 0, k = 0; i < result.fixes.size(); ++i) {
      const double step = result.fixes[i].time - result.fixes[k].time;
      if (step >= 2) {  // shorter differences are those of the noise
        const double way = (result.fixes[i].position - result.fixes[k].position).head<2>().norm();
        fastest = std::max(fastest, way / step);
        k = i;
      }
    }
  }
  if (odometer != nullptr) {
    add_odometer_events(*odometer, c.odometer_scale, events);
    for (const OdometerRow& row : odometer->odometer) {
      fastest = std::max(fastest, std::abs(c.odometer_scale * row.speed));
    }
  }
  double step = estimation::PlanarMotionParameters{}.step;
  if (imu != nullptr) {
    step = median_step(imu->imu);
    for (const ImuRow& row : imu->imu) {
      events.push_back(
          {row.time,
           ImuReading{.time = row.time, .specific_force = row.force, .angular_rate = row.rate}});
    }
  } else {
    result.said.emplace_back(
        "No IMU is used: the motion is taken as planar, with the odometer's speed and yaw rate.");
    add_implied_imu(*odometer, c.odometer_scale, gravity, events);
  }
  auto parameters = parameters_for(c, odometer != nullptr, step, gravity, fastest);
  parameters.R_body_imu = R_body_imu;
  if (result.datum && imu != nullptr) {
    parameters.smoother.earth = estimation::Earth::at_latitude(result.datum->latitude);
  }
  if (gps == nullptr) {
    // Nothing else measures distances.
    parameters.smoother.global_deviations.odometer_scale = 0;
  }
  if (imu == nullptr) {
    estimation::set_planar(parameters);
  }
  if (gps != nullptr) {
    if (c.antenna) {
      parameters.smoother.globals.gps_lever_arm = *c.antenna;
    } else if (const auto pose = recording.mounting(c.base_frame, gps->frame)) {
      parameters.smoother.globals.gps_lever_arm = pose->translation();
      result.said.push_back(gps->name + ": antenna from the transforms (" + c.base_frame + " to " +
                            gps->frame + ").");
    } else {
      result.said.push_back(gps->name +
                            ": where the antenna is on the robot is not known (frame '" +
                            gps->frame + "'); it is taken to be at the origin of the base.");
    }
  }
  FurtherInputs further(recording, c, map ? &*map : nullptr, parameters, result.said);
  for (std::size_t i = 0; i < further.size(); ++i) {
    for (const FurtherRow& row : further.rows(i)) {
      events.push_back({row.time, FurtherReading{i, &row}});
    }
  }
  std::ranges::stable_sort(events, {}, &Event::time);
  std::optional<estimation::GivenPose> start;
  if (c.start || gps == nullptr) {
    start = given(c.start.value_or(Start{}), events.front().time);
  }
  if (c.start && gps != nullptr) {
    constexpr double kCovers = 3;  // standard deviations
    const ComparedFix& first = result.fixes.front();
    start->time = first.time;
    start->position = first.position;
    start->position_deviation = std::clamp(kCovers * first.deviation, 1e-3, 1e4);
    result.said.emplace_back(
        "The heading of start is used; the position is that of the first fix.");
  }
  if (gps == nullptr && odometer == nullptr && further.size() == 0) {
    result.said.emplace_back(
        "There is neither GPS nor an odometer: the position of an IMU alone is off by metres after "
        "seconds, and by kilometres after minutes. Only the attitude is of use.");
  }
  if (gps == nullptr) {
    const auto seen = c.start ? std::nullopt : further.first_pose();
    start = seen.value_or(*start);
    result.said.emplace_back(
        c.start ? "No GPS: the trajectory begins as start says."
        : seen  ? "No GPS: the trajectory begins at the first pose of the sources of kind pose."
                : "No GPS: the trajectory begins at the origin, along the x axis, and drifts.");
  }
  run(events, parameters, start, further, result, progress);
  return result;
}

}  // namespace pipescout::estimate
