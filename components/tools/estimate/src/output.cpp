// SPDX-License-Identifier: Apache-2.0
#include "output.hpp"

#include <algorithm>
#include <cmath>

#include "pipescout/command_line/formatted.hpp"
#include "pipescout/csv/csv_table.hpp"
#include "pipescout/geometry/antimeridian.hpp"

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
  std::size_t count = 0;
  double rms = 0;               // m, horizontal
  double largest = 0;           // m
  double per_axis = 0;          // m
  double stated = 0;            // m, per axis, rms of the deviations as used
  double correlation_time = 0;  // s; 0: not seen
};

Residuals residuals(const Trajectory& trajectory) {
  Residuals result;
  std::vector<Vector2d> values;
  std::vector<double> times;
  double sum = 0;
  double stated = 0;
  for (const ComparedFix& fix : trajectory.fixes) {
    const TrajectoryPoint* point = point_at(trajectory, fix.time);
    if (point == nullptr) {
      continue;
    }
    const Vector2d moved = (point->position + (fix.time - point->time) * point->velocity).head<2>();
    values.push_back(fix.position.head<2>() - moved);
    times.push_back(fix.time);
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
  result.per_axis = result.rms / std::sqrt(2.0);
  result.stated = std::sqrt(stated / n);
  double next = 0;
  for (std::size_t i = 1; i < values.size(); ++i) {
    next += values[i].dot(values[i - 1]);
  }
  const double correlation = sum > 0 ? next / sum : 0;
  if (correlation > 0.1 && correlation < 1) {
    result.correlation_time = -(times.back() - times.front()) / (n - 1) / std::log(correlation);
  }
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

std::string outcome(const std::string& source, const estimation::SourceStatus& s) {
  std::string line = formatted(
      "%s: %zu measurements accepted, %zu rejected as outliers, %zu held back, "
      "%zu refused",
      source.c_str(), s.accepted, s.gated, s.held, s.refused);
  if (s.refused > 0) {
    line += " (last reason: " + std::string(to_string(s.last_refusal)) + ")";
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
    lines.push_back(
        formatted("The IMU's stamps have %zu gaps of %.1f s in all, %.2f s at most; %.1f s were "
                  "bridged without it.",
                  gaps.count, gaps.total, gaps.longest, gaps.bridged));
  }
  for (const HeldOut& held : trajectory.held) {
    lines.push_back(
        formatted("GPS was held out from %.1f to %.1f s (%zu fixes); it was up to %.1f m from "
                  "the trajectory.",
                  held.begin, held.end, held.fixes, held.farthest));
  }
  return lines;
}

std::vector<std::string> settings(const Configuration& c, const Trajectory& trajectory,
                                  const Residuals& gps) {
  std::vector<std::string> lines = trajectory.mounting.findings;
  if (gps.count >= 30 && gps.per_axis > 2 * gps.stated) {
    lines.push_back(
        formatted("GPS is off the trajectory by %.2f m per axis, and states %.2f m: its "
                  "deviations seem too small. Try gps.deviation_factor: %.1f.",
                  gps.per_axis, gps.stated, c.gps_factor * gps.per_axis / gps.stated));
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
  if (std::abs(trajectory.odometer_scale - 1) > 0.05) {
    lines.push_back(
        formatted("The odometer's scale is estimated as %.3f: check wheel radius or "
                  "odometer.scale.",
                  trajectory.odometer_scale));
  }
  if (trajectory.mounting.odometer_delay && std::abs(*trajectory.mounting.odometer_delay) >= 0.06) {
    lines.push_back(formatted("The odometer's stamps are %.2f s %s the IMU's, by their yaw rates.",
                              std::abs(*trajectory.mounting.odometer_delay),
                              *trajectory.mounting.odometer_delay > 0 ? "behind" : "ahead of"));
  }
  return lines;
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

std::string trajectory_svg(const Trajectory& trajectory) {
  constexpr double kSize = 800;
  constexpr double kMargin = 40;
  Vector2d low = Vector2d::Constant(1e300);
  Vector2d high = -low;
  const auto include = [&](const Vector3d& p) {
    low = low.cwiseMin(p.head<2>());
    high = high.cwiseMax(p.head<2>());
  };
  for (const auto& p : trajectory.points) {
    include(p.position);
  }
  for (const auto& fix : trajectory.fixes) {
    include(fix.position);
  }
  const double extent = std::max((high - low).maxCoeff(), 1.0);
  const double scale = (kSize - 2 * kMargin) / extent;
  const auto x = [&](const Vector3d& p) { return kMargin + scale * (p.x() - low.x()); };
  const auto y = [&](const Vector3d& p) { return kSize - kMargin - scale * (p.y() - low.y()); };
  std::string out = formatted(
      "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 %.0f %.0f\">\n"
      "<rect width=\"100%%\" height=\"100%%\" fill=\"white\"/>\n<g fill=\"#d95f02\">\n",
      kSize, kSize);
  for (const auto& fix : trajectory.fixes) {
    out += formatted("<circle cx=\"%.1f\" cy=\"%.1f\" r=\"1.5\"/>\n", x(fix.position),
                     y(fix.position));
  }
  out += "</g>\n<polyline fill=\"none\" stroke=\"#1b4f9c\" stroke-width=\"1.5\" points=\"";
  for (const auto& p : trajectory.points) {
    out += formatted("%.1f,%.1f ", x(p.position), y(p.position));
  }
  const double bar = std::pow(10.0, std::floor(std::log10(extent / 2)));
  out += formatted(
      "\"/>\n<path d=\"M%.0f %.0fh%.1f\" stroke=\"black\" stroke-width=\"2\"/>\n"
      "<text x=\"%.0f\" y=\"%.0f\" font-family=\"sans-serif\" font-size=\"14\">%g m; line: "
      "trajectory, points: GPS; x to the right, y up</text>\n</svg>\n",
      kMargin, kSize - 12, bar * scale, kMargin + bar * scale + 8, kSize - 8, bar);
  return out;
}

std::string report(const Recording& recording, const Configuration& configuration,
                   const Trajectory& trajectory, const std::vector<std::string>& said) {
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
    out += trajectory.with_imu ? "with the IMU.\n" : "without an IMU, as planar motion.\n";
    if (gps.count >= 3) {
      out += formatted(
          "GPS is off the trajectory by %.2f m rms, %.2f m at most, horizontally (%zu "
          "fixes). The trajectory uses GPS, so this is no measure of its error.\n",
          gps.rms, gps.largest, gps.count);
    }
    const Vector3d deviation = trajectory.points.back().position_deviation;
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
    noise.push_back(
        formatted("GPS: %.2f m per axis off the trajectory; stated (as used): %.2f m%s.",
                  gps.per_axis, gps.stated,
                  gps.correlation_time > 0
                      ? formatted("; correlated over about %.1f s", gps.correlation_time).c_str()
                      : ""));
  }
  if (trajectory.with_imu && !trajectory.points.empty()) {
    const Vector3d& g = trajectory.gyro_bias;
    const Vector3d& a = trajectory.accelerometer_bias;
    noise.push_back(
        formatted("IMU: gyro bias %.4f, %.4f, %.4f rad/s; accelerometer bias %.3f, %.3f, %.3f "
                  "m/s^2, at the end, in the body.",
                  g.x(), g.y(), g.z(), a.x(), a.y(), a.z()));
  }
  if (trajectory.status.of(estimation::Source::kOdometer).accepted > 0) {
    noise.push_back(
        formatted("Odometer: scale %.4f (true distance / measured).", trajectory.odometer_scale));
  }
  if (trajectory.mounting.rate_correlation) {
    noise.push_back(
        formatted("Yaw rates of gyro and odometer correlate by %.3f; the gyro's is %.3f times "
                  "the odometer's.",
                  *trajectory.mounting.rate_correlation, trajectory.mounting.rate_factor));
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
