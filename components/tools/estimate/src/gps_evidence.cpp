// SPDX-License-Identifier: Apache-2.0
#include "gps_evidence.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "pipescout/command_line/formatted.hpp"
#include "pipescout/statistics/median.hpp"

namespace pipescout::estimate {
namespace {

using command_line::formatted;

/// A leg between two fixes is so long that their errors turn its direction by 0.35 rad, and
/// vehicles by little more.
constexpr double kLegDeviations = 4;
constexpr double kShortestLeg = 3;      // m
constexpr double kLongestLegTime = 20;  // s
/// Of the comparison of ways: so short that a wrong heading bends few of them.
constexpr double kShortestWindow = 5;  // s
constexpr double kLongestWindow = 40;
constexpr std::size_t kFewestLegs = 8;
constexpr double kOtherWay = 0.15;  // relative: no wheel is so worn
constexpr double kClearCorrelation = 0.7;
constexpr double kLeastTurns = 0.3;   // rad, rms between two legs
constexpr double kLargestTurn = 2.5;  // rad: beyond it left and right are the same
constexpr std::size_t kFrozenFixes = 30;
constexpr double kFrozenWay = 20;  // m, of the odometer meanwhile

/// Sum of a rate from the first row on, between rows in straight lines.
class Integral {
 public:
  void add(double time, double rate) {
    if (!times_.empty()) {
      const double step = std::min(time - times_.back(), 1.0);
      sums_.push_back(sums_.back() + step * (rate + rate_) / 2);
    } else {
      sums_.push_back(0);
    }
    times_.push_back(time);
    rate_ = rate;
  }
  [[nodiscard]] bool empty() const { return times_.size() < 2; }
  [[nodiscard]] double at(double time) const {
    const auto after = std::ranges::upper_bound(times_, time);
    if (after == times_.begin()) {
      return sums_.front();
    }
    if (after == times_.end()) {
      return sums_.back();
    }
    const auto i = static_cast<std::size_t>(after - times_.begin());
    const double share = (time - times_[i - 1]) / (times_[i] - times_[i - 1]);
    return sums_[i - 1] + share * (sums_[i] - sums_[i - 1]);
  }
  [[nodiscard]] double between(double from, double to) const { return at(to) - at(from); }

 private:
  std::vector<double> times_;
  std::vector<double> sums_;
  double rate_ = 0;
};

struct Leg {
  double begin = 0;  // s
  double end = 0;
  Eigen::Vector2d chord = Eigen::Vector2d::Zero();  // m
  [[nodiscard]] double middle() const { return (begin + end) / 2; }
};

std::vector<Leg> legs_of(const std::vector<ComparedFix>& fixes) {
  std::vector<Leg> legs;
  for (std::size_t i = 0, k = 1; k < fixes.size(); ++k) {
    const Eigen::Vector2d chord = (fixes[k].position - fixes[i].position).head<2>();
    const double needed =
        std::max(kShortestLeg, kLegDeviations * std::max(fixes[i].deviation, fixes[k].deviation));
    if (fixes[k].time - fixes[i].time > kLongestLegTime) {
      i = k;
    } else if (chord.norm() >= needed) {
      legs.push_back({fixes[i].time, fixes[k].time, chord});
      i = k;
    }
  }
  return legs;
}

/// Of the turns from leg to leg with those that `heading` says; `sign`: of the direction of travel.
std::optional<double> turn_correlation(const std::vector<Leg>& legs, const Integral& heading,
                                       const Integral& way) {
  double n = 0, xx = 0, yy = 0, xy = 0;
  const auto backwards = [&](const Leg& leg) {
    return !way.empty() && way.between(leg.begin, leg.end) < 0;
  };
  for (std::size_t i = 1; i < legs.size(); ++i) {
    const Leg& a = legs[i - 1];
    const Leg& b = legs[i];
    if (b.begin != a.end || backwards(a) != backwards(b)) {
      continue;
    }
    const double course =
        std::atan2(a.chord.x() * b.chord.y() - a.chord.y() * b.chord.x(), a.chord.dot(b.chord));
    const double turn = heading.between(a.middle(), b.middle());
    if (std::abs(course) < kLargestTurn && std::abs(turn) < kLargestTurn) {
      n += 1, xx += course * course, yy += turn * turn, xy += course * turn;
    }
  }
  if (n < static_cast<double>(kFewestLegs) || yy < n * kLeastTurns * kLeastTurns || !(xx > 0)) {
    return std::nullopt;
  }
  return xy / std::sqrt(xx * yy);
}

/// Where the odometer says that the vehicle is, in the plane, with the heading of gyro or wheels.
class Reckoning {
 public:
  Reckoning(const Stream& odometer, double scale, const Integral& heading) {
    for (const OdometerRow& row : odometer.odometer) {
      const double angle = heading.empty() ? 0 : heading.at(row.time);
      x_.add(row.time, scale * row.speed * std::cos(angle));
      y_.add(row.time, scale * row.speed * std::sin(angle));
    }
  }
  [[nodiscard]] double chord(double from, double to) const {
    return std::hypot(x_.between(from, to), y_.between(from, to));
  }

 private:
  Integral x_;
  Integral y_;
};

/// Of windows of one duration: of legs that end where GPS is far enough, noise would choose the
/// long ones. Nothing where noise is most of what GPS shows.
std::optional<double> way_factor(const std::vector<ComparedFix>& fixes, const Reckoning& reckoned,
                                 double window) {
  constexpr double kOutlier = 3;
  constexpr double kMostNoise = 0.3;
  struct Squares {
    double gps = 0;
    double noise = 0;
    double odometer = 0;
  };
  std::vector<Squares> all;
  std::vector<double> factors;
  for (std::size_t i = 0, k = 1; k < fixes.size(); ++k) {
    const double step = fixes[k].time - fixes[i].time;
    if (step < window) {
      continue;
    }
    const double driven = reckoned.chord(fixes[i].time, fixes[k].time);
    if (step < 2 * window && driven > 0) {
      const double a = fixes[i].deviation;
      const double b = fixes[k].deviation;
      all.push_back({(fixes[k].position - fixes[i].position).head<2>().squaredNorm(),
                     2 * (a * a + b * b), driven * driven});
      factors.push_back(all.back().gps / all.back().odometer);
    }
    i = k;
  }
  if (factors.size() < kFewestLegs) {
    return std::nullopt;
  }
  const double usual = statistics::median(std::move(factors));
  Squares sum;
  for (const Squares& each : all) {
    if (each.gps < kOutlier * kOutlier * usual * each.odometer) {
      sum.gps += each.gps;
      sum.noise += each.noise;
      sum.odometer += each.odometer;
    }
  }
  if (!(sum.noise < kMostNoise * sum.gps)) {
    return std::nullopt;
  }
  return std::sqrt((sum.gps - sum.noise) / sum.odometer);
}

void find_frozen(const Stream& gps, const Stream& odometer, const Integral& driven,
                 std::vector<std::string>& findings) {
  const auto same = [](const GpsRow& a, const GpsRow& b) {
    return a.place.latitude == b.place.latitude && a.place.longitude == b.place.longitude;
  };
  for (std::size_t i = 0; i < gps.gps.size();) {
    std::size_t end = i + 1;
    while (end < gps.gps.size() && same(gps.gps[i], gps.gps[end])) {
      ++end;
    }
    const double from = gps.gps[i].time;
    const double to = gps.gps[end - 1].time;
    const double meanwhile = driven.between(from, to);
    if (end - i >= kFrozenFixes && meanwhile > kFrozenWay) {
      findings.push_back(formatted(
          "%s: the position is frozen at one value from %.1f to %.1f s, while %s drives %.0f m: "
          "the receiver, or what publishes it, stood still. Leave this GPS out (gps.source), or "
          "cut the recording.",
          gps.name.c_str(), from, to, odometer.name.c_str(), meanwhile));
      return;
    }
    i = end;
  }
}

void judge_way(const Stream& gps, const Stream& odometer, double scale, GpsEvidence& result) {
  if (!result.way_factor || std::abs(*result.way_factor - 1) <= kOtherWay) {
    return;
  }
  constexpr double kKilometresPerHour = 3.6;
  const double times = 1 / *result.way_factor;
  const bool is_kmh = std::abs(times / kKilometresPerHour - 1) < kOtherWay;
  result.findings.push_back(
      formatted("%s: its way is %.2f times that of %s%s. Set odometer.scale: %.3f.",
                odometer.name.c_str(), times, gps.name.c_str(),
                is_kmh ? ", as if its speed were in km/h instead of m/s"
                       : ": its speed is not in m/s, or its "
                         "wheel radius is wrong",
                scale * *result.way_factor));
}

void judge_turns(const Stream& gps, const Stream* odometer, const Stream* imu,
                 GpsEvidence& result) {
  const auto opposite = [](const std::optional<double>& correlation) {
    return correlation && *correlation <= -kClearCorrelation;
  };
  result.gyro_is_opposite = opposite(result.gyro_correlation);
  result.odometer_is_opposite = opposite(result.odometer_correlation);
  if (result.gyro_is_opposite) {
    result.findings.push_back(formatted(
        "%s turns against the course of %s (correlation %.2f): its yaw rate has the wrong sign, or "
        "its mounting is upside down. It is not used. Positive is to the left (REP 103).",
        imu->name.c_str(), gps.name.c_str(), *result.gyro_correlation));
  }
  if (result.odometer_is_opposite) {
    result.findings.push_back(formatted(
        "%s turns against the course of %s (correlation %.2f): its yaw rate has the wrong sign and "
        "is not used. Positive is to the left (REP 103).",
        odometer->name.c_str(), gps.name.c_str(), *result.odometer_correlation));
  }
}

}  // namespace

GpsEvidence examine_gps(const Stream& gps, const std::vector<ComparedFix>& fixes,
                        const Stream* odometer, double scale, const Stream* imu,
                        const Eigen::Vector3d& up) {
  GpsEvidence result;
  Integral way;
  Integral driven;  // forwards or backwards
  Integral wheel_heading;
  Integral gyro_heading;
  if (odometer != nullptr) {
    for (const OdometerRow& row : odometer->odometer) {
      way.add(row.time, scale * row.speed);
      driven.add(row.time, std::abs(scale * row.speed));
      if (row.yaw_rate) {
        wheel_heading.add(row.time, *row.yaw_rate);
      }
    }
  }
  if (imu != nullptr) {
    for (const ImuRow& row : imu->imu) {
      gyro_heading.add(row.time, row.rate.dot(up));
    }
  }
  const std::vector<Leg> legs = legs_of(fixes);
  if (!gyro_heading.empty()) {
    result.gyro_correlation = turn_correlation(legs, gyro_heading, way);
  }
  if (!wheel_heading.empty()) {
    result.odometer_correlation = turn_correlation(legs, wheel_heading, way);
  }
  judge_turns(gps, odometer, imu, result);
  if (!way.empty()) {
    const Reckoning reckoned(*odometer, scale, gyro_heading.empty() ? wheel_heading : gyro_heading);
    for (double window = kShortestWindow; window <= kLongestWindow && !result.way_factor;
         window *= 2) {
      result.way_factor = way_factor(fixes, reckoned, window);
    }
    judge_way(gps, *odometer, scale, result);
    find_frozen(gps, *odometer, driven, result.findings);
  }
  return result;
}

}  // namespace pipescout::estimate
