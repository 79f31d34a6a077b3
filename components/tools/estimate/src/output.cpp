// SPDX-License-Identifier: Apache-2.0
#include "output.hpp"

#include <algorithm>
#include <cmath>

#include "pipescout/command_line/formatted.hpp"
#include "pipescout/csv/csv_cell.hpp"
#include "pipescout/geometry/antimeridian.hpp"
#include "pipescout/statistics/median.hpp"

namespace pipescout::estimate {
namespace {

using command_line::formatted;
using Eigen::Vector2d;
using Eigen::Vector3d;

/// As many digits as a difference of 0.1 mm needs.
std::string coordinate(double degrees) {
  return formatted("%.9f", degrees);
}

std::string stamp(const Recording& recording, double time) {
  return formatted("%.6f", recording.origin + time);
}

const TrajectoryPoint* point_at(const Trajectory& trajectory, double time) {
  constexpr double kNear = 0.3;  // s
  const auto after = std::ranges::lower_bound(trajectory.points, time, {}, &TrajectoryPoint::time);
  const TrajectoryPoint* best = nullptr;
  for (const auto& each : {after, after == trajectory.points.begin() ? after : std::prev(after)}) {
    if (each != trajectory.points.end() && std::abs(each->time - time) < kNear &&
        (best == nullptr || std::abs(each->time - time) < std::abs(best->time - time))) {
      best = &*each;
    }
  }
  return best;
}

struct Residuals {
  std::size_t since_start = 0;
  std::size_t count = 0;  // of them, without those that were held out
  double rms = 0;         // m, horizontal
  double largest = 0;     // m
  double per_axis = 0;    // m, standard deviation, by the median: outliers do not count
  double stated = 0;      // m, per axis, rms of the deviations as used
};

/// Of the length of a vector of two normal components of deviation 1.
constexpr double kMedianOfRayleigh = 1.1774;

Residuals residuals(const Trajectory& trajectory) {
  Residuals result;
  std::vector<Vector2d> values;
  double sum = 0;
  double stated = 0;
  for (const ComparedFix& fix : trajectory.fixes) {
    const TrajectoryPoint* point = point_at(trajectory, fix.time);
    if (point == nullptr || point->time < trajectory.started) {
      continue;  // dead reckoning that was put into the map afterwards
    }
    ++result.since_start;
    if (std::ranges::any_of(trajectory.held, [&](const HeldOut& held) {
          return fix.time >= held.begin && fix.time <= held.end;
        })) {
      continue;
    }
    const Vector2d moved = (point->position + (fix.time - point->time) * point->velocity).head<2>();
    values.push_back(fix.position.head<2>() - moved);
    sum += values.back().squaredNorm();
    stated += fix.deviation * fix.deviation;
    result.largest = std::max(result.largest, values.back().norm());
  }
  result.count = values.size();
  if (values.size() < 3) {
    return result;
  }
  const double n = static_cast<double>(values.size());
  result.rms = std::sqrt(sum / n);
  std::vector<double> norms;
  for (const Vector2d& value : values) {
    norms.push_back(value.norm());
  }
  result.per_axis = statistics::median(std::move(norms)) / kMedianOfRayleigh;
  result.stated = std::sqrt(stated / n);
  return result;
}

double way(const Trajectory& trajectory) {
  double sum = 0;
  for (std::size_t i = 1; i < trajectory.points.size(); ++i) {
    sum += (trajectory.points[i].position - trajectory.points[i - 1].position).norm();
  }
  return sum;
}

void add_list(std::string& out, const char* title, const std::vector<std::string>& lines,
              const char* none) {
  out += std::string("\n## ") + title + "\n\n";
  for (const std::string& line : lines) {
    out += "- " + line + "\n";
  }
  if (lines.empty()) {
    out += std::string(none) + "\n";
  }
}

std::vector<std::string> believed(const Trajectory& trajectory) {
  constexpr std::size_t kMost = 60;
  std::vector<std::string> lines;
  for (const Change& change : trajectory.changes) {
    if (lines.size() == kMost) {
      lines.push_back(formatted("... and %zu more changes.", trajectory.changes.size() - kMost));
      break;
    }
    lines.push_back(formatted("%8.1f s: ", change.time) + change.what + ".");
  }
  return lines;
}

/// Why a measurement was refused, for who does not know the estimator's terms.
std::string reason(const std::string& source, estimation::Outcome outcome) {
  using estimation::Outcome;
  switch (outcome) {
    case Outcome::kGated:
      return source == "imu" ? "a spike, not like the readings before and after" : "an outlier";
    case Outcome::kLate:
      return "too old when it arrived";
    case Outcome::kFuture:
      return "too far ahead of the other sources";
    case Outcome::kDuplicate:
      return "its stamp repeats";
    case Outcome::kNotFinite:
      return "not finite";
    case Outcome::kBadCovariance:
      return "its covariance is none";
    case Outcome::kDead:
      return "a dead reading";
    default:
      return std::string(to_string(outcome));
  }
}

std::string outcome(const std::string& source, const estimation::SourceStatus& s) {
  std::string line = formatted("%s: %zu measurements accepted, %zu rejected as outliers",
                               source.c_str(), s.accepted, s.gated);
  if (s.held > 0) {
    line +=
        formatted(", %zu not used before the start or while they contradicted the state", s.held);
  }
  if (s.refused > 0) {
    line += formatted(", %zu refused (the last one: %s)", s.refused,
                      reason(source, s.last_refusal).c_str());
  }
  return line + ".";
}

std::vector<std::string> refused(const Recording& recording, const Trajectory& trajectory) {
  std::vector<std::string> lines = recording.faults();
  for (std::size_t i = 0; i < estimation::kSources; ++i) {
    const auto source = static_cast<estimation::Source>(i);
    const estimation::SourceStatus& s = trajectory.status.of(source);
    const bool implied = source == estimation::Source::kImu && !trajectory.with_imu;
    if (implied || s.accepted + s.gated + s.held + s.refused == 0) {
      continue;
    }
    lines.push_back(outcome(std::string(to_string(source)), s));
  }
  for (const FurtherOutcome& further : trajectory.further) {
    lines.push_back(outcome(further.name, further.status));
    if (!further.calibration.empty()) {
      lines.push_back(further.name + ": " + further.calibration + ".");
    }
    for (const auto& [fault, count] : further.faults) {
      lines.push_back(further.name + ": " + fault + ": " + std::to_string(count) +
                      " of its messages.");
    }
  }
  if (const estimation::ImuGaps& gaps = trajectory.status.imu_gaps;
      gaps.count > 0 && trajectory.with_imu) {
    lines.push_back(formatted(
        "The IMU's stamps have %zu %s of %.1f s in all, %.2f s at most; %.1f s were "
        "bridged without it.",
        gaps.count, gaps.count == 1 ? "gap" : "gaps", gaps.total, gaps.longest, gaps.bridged));
  }
  for (const HeldOut& held : trajectory.held) {
    lines.push_back(
        formatted("GPS was held out from %.1f to %.1f s (%zu fixes); it was up to %.1f m from "
                  "the trajectory.",
                  held.begin, held.end, held.fixes, held.farthest));
  }
  return lines;
}

/// What is missing where the estimator did not start.
std::string how_to_start(const Trajectory& trajectory) {
  using estimation::WaitsFor;
  switch (trajectory.status.waits_for) {
    case WaitsFor::kHeading:
      return "The heading was never known. Give 'start: {heading: DEGREES, heading_deviation: "
             "DEGREES}', from the map's x axis (east) to the left, or name an odometer, a compass "
             "or "
             "another source that shows it.";
    case WaitsFor::kPlace:
      return "The position was never known: GPS was not there, or its fixes did not agree. Without "
             "gps.source the trajectory begins where 'start' says.";
    case WaitsFor::kImu:
    case WaitsFor::kLevel:
      return "There was never 1 s of readings of the IMU without a gap: see what was refused.";
    default:
      return "Nothing is known that would help.";
  }
}

std::vector<std::string> settings(const Configuration& c, const Trajectory& trajectory,
                                  const Residuals& gps) {
  std::vector<std::string> lines = trajectory.mounting.findings;
  lines.insert(lines.end(), trajectory.track.findings.begin(), trajectory.track.findings.end());
  bool contradicted = !lines.empty();
  if (trajectory.points.empty()) {
    lines.push_back(how_to_start(trajectory));
    return lines;
  }
  constexpr double kUnexpected = 3;  // standard deviations beforehand
  const double delay = std::abs(trajectory.gps_delay);
  if (!contradicted && delay > kUnexpected * c.gps_time_offset_deviation) {
    lines.push_back(formatted(
        "GPS: its fixes seem to be of %.2f s %s their stamps, which is more than was to be "
        "expected. Set gps.time_offset_deviation: %.1f, or mend the stamps.",
        delay, trajectory.gps_delay < 0 ? "before" : "after", std::ceil(10 * delay) / 10));
    contradicted = true;
  }
  // Sensors that are wrong look like noise of GPS.
  if (!contradicted && gps.count >= 30 && gps.per_axis > 2 * gps.stated) {
    lines.push_back(
        formatted("GPS is off the trajectory by %.2f m per axis, and states %.2f m: its "
                  "deviations seem too small. Try gps.deviation_factor: %.1f.",
                  gps.per_axis, gps.stated, c.gps_factor * gps.per_axis / gps.stated));
  }
  if (!contradicted && trajectory.gps_correlation.is_beyond_stated()) {
    lines.push_back("GPS: " + correlation_text("gps", trajectory.gps_correlation) +
                    ": until then the trajectory is stated to be better than it is.");
  }
  for (const FurtherOutcome& further : trajectory.further) {
    if (further.status.gated > further.status.accepted) {
      lines.push_back(
          formatted("%s contradicts the trajectory in %zu of %zu measurements: one of the two is "
                    "wrong. Check "
                    "where it and its beacon are, its deviation, and start.",
                    further.name.c_str(), further.status.gated,
                    further.status.gated + further.status.accepted));
    }
  }
  if (!contradicted && std::abs(trajectory.odometer_scale - 1) > 0.05) {
    lines.push_back(
        formatted("The odometer's scale is estimated as %.3f: check wheel radius or set "
                  "odometer.scale: %.3f.",
                  trajectory.odometer_scale, c.odometer_scale * trajectory.odometer_scale));
  }
  if (trajectory.mounting.odometer_delay && std::abs(*trajectory.mounting.odometer_delay) >= 0.06) {
    lines.push_back(formatted(
        "The odometer's stamps are %.2f s %s the IMU's, by their yaw rates. Set odometer.delay: "
        "%.2f.",
        std::abs(*trajectory.mounting.odometer_delay),
        *trajectory.mounting.odometer_delay > 0 ? "behind" : "ahead of",
        c.odometer_delay + *trajectory.mounting.odometer_delay));
  }
  return lines;
}

/// s, of GPS, if the motion has shown it.
std::optional<std::string> gps_delay(const Configuration& c, const Trajectory& trajectory) {
  constexpr double kLearnt = 0.5;  // of the standard deviation beforehand
  constexpr double kPlusMinus = 2;
  const double deviation = trajectory.gps_delay_deviation;
  if (trajectory.points.empty() || !(c.gps_time_offset_deviation > 0) ||
      !(deviation < kLearnt * c.gps_time_offset_deviation)) {
    return std::nullopt;
  }
  return formatted(
      "GPS: its fixes are of %.2f +-%.2f s %s their stamps, as the motion shows; that "
      "is taken into account.",
      std::abs(trajectory.gps_delay), kPlusMinus * deviation,
      trajectory.gps_delay < 0 ? "before" : "after");
}

}  // namespace

std::string trajectory_csv(const Recording& recording, const Trajectory& trajectory) {
  std::string out = "stamp,x,y,z,x_deviation,y_deviation,z_deviation,qx,qy,qz,qw,vx,vy,vz";
  out += trajectory.datum ? ",latitude,longitude,altitude\n" : "\n";
  std::optional<geometry::LocalFrame> map;
  if (trajectory.datum) {
    map.emplace(*trajectory.datum);
  }
  for (const TrajectoryPoint& p : trajectory.points) {
    out += stamp(recording, p.time);
    for (const Vector3d& v : {p.position, p.position_deviation}) {
      out += formatted(",%.4f,%.4f,%.4f", v.x(), v.y(), v.z());
    }
    const auto& q = p.orientation;
    out += formatted(",%.6f,%.6f,%.6f,%.6f,%.4f,%.4f,%.4f", q.x(), q.y(), q.z(), q.w(),
                     p.velocity.x(), p.velocity.y(), p.velocity.z());
    if (map) {
      const auto place = map->geodetic(p.position);
      out += "," + coordinate(place.latitude) + "," + coordinate(place.longitude) +
             formatted(",%.3f", place.altitude);
    }
    out += "\n";
  }
  return out;
}

std::string trajectory_tum(const Recording& recording, const Trajectory& trajectory) {
  std::string out;
  for (const TrajectoryPoint& p : trajectory.points) {
    const auto& q = p.orientation;
    out += stamp(recording, p.time) + formatted(" %.4f %.4f %.4f %.6f %.6f %.6f %.6f\n",
                                                p.position.x(), p.position.y(), p.position.z(),
                                                q.x(), q.y(), q.z(), q.w());
  }
  return out;
}

std::string trajectory_geojson(const Trajectory& trajectory) {
  if (!trajectory.datum) {
    return {};
  }
  const geometry::LocalFrame map(*trajectory.datum);
  std::vector<geometry::GeodeticPosition> line;
  for (const TrajectoryPoint& point : trajectory.points) {
    line.push_back(map.geodetic(point.position));
  }
  const auto lines = geometry::cut_at_antimeridian(line);
  std::string out =
      R"({"type":"FeatureCollection","features":[{"type":"Feature","properties":{"name":"trajectory"},"geometry":{"type":"MultiLineString","coordinates":[)";
  for (std::size_t i = 0; i < lines.size(); ++i) {
    out += i == 0 ? "[" : ",[";
    for (std::size_t k = 0; k < lines[i].size(); ++k) {
      const geometry::GeodeticPosition& p = lines[i][k];
      out += (k == 0 ? "[" : ",[") + coordinate(p.longitude) + "," + coordinate(p.latitude) +
             formatted(",%.3f]", p.altitude);
    }
    out += "]";
  }
  return out + "]}}]}\n";
}

std::string report(const Recording& recording, const Configuration& configuration,
                   const Trajectory& trajectory, const std::vector<std::string>& said) {
  constexpr double kContradicted = 3;
  constexpr double kMissing = 2;  // s
  constexpr double kMuch = 0.3;
  std::string out = "# Trajectory of the recording\n\n";
  const Residuals gps = residuals(trajectory);
  if (trajectory.points.empty()) {
    out += "There is no trajectory: " + trajectory.status.text + "\n";
  } else {
    const double begin = trajectory.points.front().time;
    const double end = trajectory.points.back().time;
    out += formatted(
        "%zu poses from %.1f to %.1f s after the first message (at %.3f), %.1f m of way, ",
        trajectory.points.size(), begin, end, recording.origin, way(trajectory));
    if (trajectory.recorded_until > end + kMissing) {
      out += formatted("until %.1f s before the end of the recording, ",
                       trajectory.recorded_until - end);
    }
    out += trajectory.with_imu ? "with the IMU.\n" : "without an IMU, as planar motion.\n";
    if (gps.count >= 3) {
      out += formatted(
          "GPS is off the trajectory by %.2f m rms, %.2f m at most, horizontally (%zu "
          "fixes since the start). The trajectory uses GPS, so this is no measure of its error.\n",
          gps.rms, gps.largest, gps.count);
    }
    if (gps.since_start > 0 &&
        static_cast<double>(gps.count) < (1 - kMuch) * static_cast<double>(gps.since_start)) {
      out += formatted(
          "**GPS contradicts this trajectory for much of the time**: %zu of its %zu fixes were "
          "held "
          "out, see below. One of the two is wrong.\n",
          gps.since_start - gps.count, gps.since_start);
    }
    const Vector3d deviation = trajectory.points.back().position_deviation;
    const double both = std::hypot(gps.stated, deviation.head<2>().norm() / std::sqrt(2.0));
    if (gps.count >= 3 && gps.per_axis > kContradicted * both) {
      out += formatted(
          "**Do not rely on this trajectory**: that is %.0f times what it and GPS state. One of "
          "the "
          "sensors, or how it is mounted, is not as it is taken to be; see the settings below.\n",
          gps.per_axis / both);
    }
    out += formatted(
        "Stated standard deviation of the position at the end: %.2f, %.2f, %.2f m (x, y, "
        "z).\n",
        deviation.x(), deviation.y(), deviation.z());
  }
  std::vector<std::string> taken = said;
  taken.insert(taken.end(), trajectory.said.begin(), trajectory.said.end());
  taken.insert(taken.end(), recording.remarks.begin(), recording.remarks.end());
  add_list(out, "What was taken for what", taken, "Nothing.");
  add_list(out, "What was believed when", believed(trajectory), "Nothing changed.");
  add_list(out, "What was refused, and why", refused(recording, trajectory), "Nothing.");
  std::vector<std::string> noise;
  if (gps.count >= 3) {
    noise.push_back(formatted("GPS: %.2f m per axis off the trajectory; stated (as used): %.2f m.",
                              gps.per_axis, gps.stated));
  }
  if (const std::string text = correlation_text("gps", trajectory.gps_correlation); !text.empty()) {
    noise.push_back("GPS: " + text + ".");
  }
  if (trajectory.with_imu && !trajectory.points.empty()) {
    const Vector3d& g = trajectory.gyro_bias;
    const Vector3d& a = trajectory.accelerometer_bias;
    noise.push_back(
        formatted("IMU: gyro bias %.4f, %.4f, %.4f rad/s; accelerometer bias %.3f, %.3f, %.3f "
                  "m/s^2, at the end, in the body.",
                  g.x(), g.y(), g.z(), a.x(), a.y(), a.z()));
  }
  if (const auto delay = gps_delay(configuration, trajectory)) {
    noise.push_back(*delay);
  }
  if (trajectory.status.of(estimation::Source::kOdometer).accepted > 0 &&
      !trajectory.points.empty()) {
    noise.push_back(trajectory.datum ? formatted("Odometer: scale %.4f (true distance / measured).",
                                                 trajectory.odometer_scale)
                                     : "Odometer: its scale is taken as it is; without GPS nothing "
                                       "else measures the way.");
  }
  if (trajectory.mounting.rate_correlation) {
    noise.push_back(
        formatted("Yaw rates of gyro and odometer correlate by %.3f; the gyro's is %.3f times "
                  "the odometer's.",
                  *trajectory.mounting.rate_correlation, trajectory.mounting.rate_factor));
  }
  if (trajectory.with_imu && trajectory.mounting.intervals > 0 &&
      !trajectory.mounting.acceleration_is_clear) {
    noise.push_back(
        formatted("Mounting: the yaw of the IMU is not certain from the motion (accelerations of "
                  "odometer and IMU correlate by %.2f in %zu intervals), so that it is not judged.",
                  trajectory.mounting.acceleration_correlation, trajectory.mounting.intervals));
  }
  if (trajectory.mounting.odometer_delay) {
    noise.push_back(formatted("Delay of the odometer behind the IMU: %.2f s.",
                              *trajectory.mounting.odometer_delay));
  }
  add_list(out, "Noise, delays and mounting as they seem to be", noise, "Not known.");
  add_list(out, "Which setting to change", settings(configuration, trajectory, gps),
           "Nothing needs to be changed.");
  return out;
}

}  // namespace pipescout::estimate
