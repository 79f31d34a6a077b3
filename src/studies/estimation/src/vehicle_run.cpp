// SPDX-License-Identifier: Apache-2.0
#include "pipescout/estimation_study/vehicle_run.hpp"

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <string>

#include "pipescout/validation/check.hpp"

namespace pipescout::estimation_study {
namespace {

/// The last point at or before a time, and how far beyond it, as a share of the way to the next.
std::pair<std::size_t, double> place(const VehicleRun& run, double time) {
  const auto after = std::ranges::upper_bound(run.truth, time, {}, &TruthPoint::time);
  if (after == run.truth.begin()) {
    return {0, 0};
  }
  const auto index = static_cast<std::size_t>(std::distance(run.truth.begin(), after)) - 1;
  if (after == run.truth.end()) {
    return {index, 0};
  }
  return {index, (time - run.truth[index].time) / (after->time - run.truth[index].time)};
}

}  // namespace

void RunOptions::validate() const {
  validation::check_within("duration", duration, 20, 3600);
  validation::check_within("outlier_share", outlier_share, 0, 1);
  for (const Silence& silence : silences) {
    validation::check_within("silences.begin", silence.begin, -1e9, 1e9);
    validation::check_within("silences.duration", silence.duration, 0, 1e9);
  }
  imu.validate();
}

double time_of(const Reading& reading) {
  return std::visit([](const auto& r) { return r.time; }, reading);
}

VehicleRun vehicle_run(Vehicle vehicle, const RunOptions& options, std::uint64_t seed) {
  switch (vehicle) {
    case Vehicle::kGroundRobot:
      return ground_robot_run(options, seed);
    case Vehicle::kUav:
      return uav_run(options, seed);
    case Vehicle::kCrawler:
      return crawler_run(options, seed);
  }
  throw std::invalid_argument("vehicle: not an enumerator of Vehicle");
}

estimation::NavState truth_at(const VehicleRun& run, double time) {
  const auto [index, share] = place(run, time);
  const estimation::NavState& from = run.truth[index].state;
  if (share <= 0) {
    return from;
  }
  return from.retract(share * from.local(run.truth[index + 1].state));
}

double way_at(const VehicleRun& run, double time) {
  const auto [index, share] = place(run, time);
  const double from = run.truth[index].way;
  return share > 0 ? from + share * (run.truth[index + 1].way - from) : from;
}

}  // namespace pipescout::estimation_study
