// SPDX-License-Identifier: Apache-2.0
#include "recording.hpp"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "pipescout/statistics/median.hpp"

namespace pipescout::estimate {
namespace {

using statistics::median;

/// Two fixes further apart belong to no recording of a ground robot or small UAV.
constexpr double kFarFix = 100e3;  // m
/// A working gyro does not repeat all three axes for so long while the accelerometer moves.
constexpr double kFrozenTime = 0.5;  // s
constexpr std::size_t kFrozenRows = 10;
constexpr int kLongestChain = 64;

bool usable(const Eigen::Matrix3d& c) {
  if (!c.allFinite() ||
      (c - c.transpose()).cwiseAbs().maxCoeff() > 1e-6 * c.cwiseAbs().maxCoeff()) {
    return false;
  }
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver(c, Eigen::EigenvaluesOnly);
  return solver.eigenvalues().minCoeff() > 1e-12 && solver.eigenvalues().maxCoeff() < 1e12;
}

template <class Row>
void sort_rows(std::vector<Row>& rows, std::map<std::string, std::size_t>& faults) {
  std::stable_sort(rows.begin(), rows.end(),
                   [](const Row& a, const Row& b) { return a.time < b.time; });
  const auto end = std::unique(rows.begin(), rows.end(),
                               [](const Row& a, const Row& b) { return a.time == b.time; });
  if (end != rows.end()) {
    faults["the stamp repeats that of another message; the first one is used"] +=
        static_cast<std::size_t>(std::distance(end, rows.end()));
    rows.erase(end, rows.end());
  }
}

void remove_frozen(Stream& stream) {
  std::vector<ImuRow> kept;
  kept.reserve(stream.imu.size());
  for (std::size_t i = 0; i < stream.imu.size();) {
    std::size_t end = i + 1;
    bool force_moves = false;
    while (end < stream.imu.size() && stream.imu[end].rate == stream.imu[i].rate) {
      force_moves = force_moves || stream.imu[end].force != stream.imu[i].force;
      ++end;
    }
    const bool frozen = force_moves && end - i >= kFrozenRows &&
                        stream.imu[end - 1].time - stream.imu[i].time >= kFrozenTime;
    if (frozen) {
      stream.faults
          ["angular_velocity is frozen at one value while linear_acceleration changes; "
           "not used"] += end - i;
    } else {
      kept.insert(kept.end(), stream.imu.begin() + static_cast<std::ptrdiff_t>(i),
                  stream.imu.begin() + static_cast<std::ptrdiff_t>(end));
    }
    i = end;
  }
  stream.imu = std::move(kept);
}

void remove_far_fixes(Stream& stream) {
  if (stream.gps.empty()) {
    return;
  }
  std::vector<double> x;
  std::vector<double> y;
  std::vector<double> z;
  for (const GpsRow& row : stream.gps) {
    x.push_back(row.place.latitude);
    y.push_back(row.place.longitude);
    z.push_back(row.place.altitude);
  }
  const geometry::GeodeticPosition centre{median(x), median(y), median(z)};
  const auto count = std::erase_if(stream.gps, [&](const GpsRow& row) {
    return geometry::straight_distance(row.place, centre) > kFarFix;
  });
  if (count > 0) {
    stream.faults["the position is more than 100 km from most others; not used"] += count;
  }
}

}  // namespace

const char* to_string(Kind kind) noexcept {
  switch (kind) {
    case Kind::kImu:
      return "imu";
    case Kind::kOdometer:
      return "odometer";
    case Kind::kGps:
      return "gps";
    case Kind::kFurther:
      return "further source";
  }
  return "unknown";
}

void Stream::shift(double offset) noexcept {
  const auto move = [offset](auto& rows) {
    for (auto& row : rows) {
      row.time += offset;
    }
  };
  move(imu);
  move(odometer);
  move(gps);
  move(further);
}

std::vector<std::string> Recording::faults() const {
  std::vector<std::string> sentences;
  for (const Stream& stream : streams) {
    for (const auto& [fault, count] : stream.faults) {
      sentences.push_back(stream.name + ": " + fault + ": " + std::to_string(count) +
                          " of its messages.");
    }
  }
  return sentences;
}

const Stream* Recording::find(const std::string& name, Kind kind) const noexcept {
  const auto found = std::ranges::find_if(
      streams, [&](const Stream& s) { return s.kind == kind && s.name == name; });
  return found == streams.end() ? nullptr : &*found;
}

const Stream* Recording::find_further(const std::string& name) const noexcept {
  const auto found = std::ranges::find_if(
      streams, [&](const Stream& s) { return s.name == name && !s.further.empty(); });
  return found == streams.end() ? nullptr : &*found;
}

std::optional<geometry::SE3> Recording::mounting(const std::string& parent,
                                                 const std::string& child) const {
  // Up from both to the root of their trees: the sensor need not be below the base.
  const auto ascend = [&](std::string frame) {
    std::map<std::string, geometry::SE3> ancestors;
    geometry::SE3 T_frame_start;
    for (int i = 0; i < kLongestChain; ++i) {
      ancestors.emplace(frame, T_frame_start);
      const auto up = mounts.find(frame);
      if (up == mounts.end()) {
        break;
      }
      T_frame_start = up->second.T_parent_child * T_frame_start;
      frame = up->second.parent;
    }
    return ancestors;
  };
  const auto of_parent = ascend(parent);
  for (const auto& [frame, T_frame_child] : ascend(child)) {
    if (const auto common = of_parent.find(frame); common != of_parent.end()) {
      return common->second.inverse() * T_frame_child;
    }
  }
  return std::nullopt;
}

void add_imu(Stream& stream, const ImuRow& row) {
  if (!std::isfinite(row.time)) {
    ++stream.faults["the time is not finite; not used"];
  } else if (!row.force.allFinite()) {
    ++stream.faults["linear_acceleration is not finite; not used"];
  } else if (!row.rate.allFinite()) {
    ++stream.faults["angular_velocity is not finite; not used"];
  } else if (row.force.isZero(0)) {
    ++stream.faults["linear_acceleration is exactly zero, a dead accelerometer; not used"];
  } else {
    stream.imu.push_back(row);
  }
}

void add_odometer(Stream& stream, const OdometerRow& row) {
  if (!std::isfinite(row.time)) {
    ++stream.faults["the time is not finite; not used"];
  } else if (!std::isfinite(row.speed)) {
    ++stream.faults["twist.linear is not finite; not used"];
  } else if (row.yaw_rate && !std::isfinite(*row.yaw_rate)) {
    ++stream.faults["twist.angular.z is not finite; only the speed is used"];
    stream.odometer.push_back({.time = row.time, .speed = row.speed});
  } else {
    stream.odometer.push_back(row);
  }
}

void add_gps(Stream& stream, GpsRow row) {
  const double latitude = row.place.latitude;
  const double longitude = row.place.longitude;
  if (!std::isfinite(row.time)) {
    ++stream.faults["the time is not finite; not used"];
    return;
  }
  if (!std::isfinite(latitude) || !std::isfinite(longitude)) {
    ++stream.faults["latitude or longitude is not finite; not used"];
    return;
  }
  if (std::abs(latitude) > 90 || std::abs(longitude) > 540) {
    ++stream.faults["latitude or longitude is outside the earth's range; not used"];
    return;
  }
  if (latitude == 0 && longitude == 0) {
    ++stream.faults["the position is exactly 0, 0, as of a receiver without a fix; not used"];
    return;
  }
  if (!std::isfinite(row.place.altitude)) {
    row.place.altitude = 0;
    row.has_height = false;
    ++stream.faults["altitude is not finite; the horizontal position is used"];
  }
  if (row.covariance && !usable(*row.covariance)) {
    ++stream.faults
          ["position_covariance is not finite, not symmetric, zero or negative; "
           "gps.deviation is used"];
    row.covariance.reset();
  }
  stream.gps.push_back(std::move(row));
}

void add_further(Stream& stream, double time, SourceMessage message) {
  if (!std::isfinite(time)) {
    ++stream.faults["the time is not finite; not used"];
    return;
  }
  stream.further.push_back({.time = time, .message = std::move(message)});
}

std::string about_further(const std::string& name, const std::string& message_type) {
  if (name.ends_with("initialpose")) {
    return name +
           ": not used: a pose that was given by hand; 'start' of the configuration takes one.";
  }
  std::string text = name + ": not used; the configuration may name it: ";
  for (std::size_t i = 0; i < kNamedSourceKinds; ++i) {
    const auto kind = static_cast<NamedSourceKind>(i);
    if (message_type_of(kind) == message_type) {
      return text + "'further_sources: {a_name: {kind: " + std::string(to_string(kind)) +
             ", topic: " + name +
             (kind == NamedSourceKind::kRange ? ", beacon: [x, y, z]}}'." : "}}'.");
    }
  }
  return text + "no kind of further source is of its type.";
}

void finish(Recording& recording) {
  double first = std::numeric_limits<double>::infinity();
  std::map<std::string, std::size_t> told_already;
  for (Stream& stream : recording.streams) {
    sort_rows(stream.imu, stream.faults);
    sort_rows(stream.odometer, stream.faults);
    sort_rows(stream.gps, stream.faults);
    sort_rows(stream.further, stream.kind == Kind::kFurther ? stream.faults : told_already);
    remove_frozen(stream);
    remove_far_fixes(stream);
    const auto earliest = [&](const auto& rows) {
      if (!rows.empty()) {
        first = std::min(first, rows.front().time);
      }
    };
    earliest(stream.imu);
    earliest(stream.odometer);
    earliest(stream.gps);
    earliest(stream.further);
  }
  if (!std::isfinite(first)) {
    return;
  }
  recording.origin = first;
  for (Stream& stream : recording.streams) {
    stream.shift(-first);
  }
}

}  // namespace pipescout::estimate
