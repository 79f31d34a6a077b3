// SPDX-License-Identifier: Apache-2.0
#include "pipescout/estimation_study/husky_recording.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>
#include <variant>

#include "pipescout/csv/number_table.hpp"
#include "pipescout/geometry/geodesy.hpp"

namespace pipescout::estimation_study {
namespace {

using estimation::GpsMeasurement;

/// Of distance, stated: the increments scatter by a centimetre in a metre.
constexpr double kOdometerVariance = 1e-4;  // m^2 per m

/// Feeds the recording without the fixes of [begin, begin + duration); tells each fix while the
/// state is in the map, before it is used.
template <class Told>
void drive(const HuskyRecording& husky, double begin, double duration, Told&& told) {
  estimation::StateEstimator estimator(husky_parameters());
  for (const Event& event : husky.events) {
    if (const auto* fix = std::get_if<GpsMeasurement>(&event.reading)) {
      if (const auto estimate = estimator.estimate(); estimate && estimate->in_map) {
        told(*fix, *estimate, estimator.status().of(estimation::Source::kGps));
      }
      if (fix->time >= begin && fix->time < begin + duration) {
        continue;
      }
    }
    std::visit([&](const auto& reading) { (void)estimator.add(reading); }, event.reading);
  }
}

double distance(const GpsMeasurement& fix, const estimation::Estimate& estimate) {
  return (estimate.state.position - fix.position).head<2>().norm();
}

}  // namespace

HuskyRecording read_husky(const HuskyFiles& files) {
  const auto imu = number_table(files.imu, "husky_imu.csv", true, 11);
  const auto odom = number_table(files.odom, "husky_odom.csv", true, 8);
  const auto fixes = number_table(files.fix, "husky_fix.csv", true, 8);
  HuskyRecording husky;
  for (const auto& row : imu) {
    husky.events.push_back(
        {row[0], estimation::ImuReading{.time = row[0],
                                        .specific_force = {row[8], row[9], row[10]},
                                        .angular_rate = {row[5], row[6], row[7]}}});
  }
  double distance = 0;
  double way = 0;
  for (std::size_t i = 0; i < odom.size(); ++i) {
    const double step = i == 0 ? 0.0 : (odom[i][0] - odom[i - 1][0]) * odom[i][5];
    distance += step;
    way += std::abs(step);
    husky.events.push_back(
        {odom[i][0],
         estimation::OdometerReading{
             .time = odom[i][0], .distance = distance, .variance = kOdometerVariance * way}});
  }
  const geometry::LocalFrame map({fixes[0][2], fixes[0][3], fixes[0][4]});
  for (const auto& row : fixes) {
    GpsMeasurement fix;
    fix.time = row[0];
    fix.position = map.position({row[2], row[3], row[4]});
    fix.covariance.diagonal() << row[5], row[6], row[7];
    husky.events.push_back({row[0], fix});
  }
  std::ranges::stable_sort(husky.events, {}, &Event::arrival);
  husky.end = husky.events.back().arrival;
  return husky;
}

estimation::StateEstimatorParameters husky_parameters() {
  auto parameters = estimation::StateEstimatorParameters::ground_robot();
  parameters.R_body_imu = geometry::SO3::about_z(-M_PI / 2) * geometry::SO3::about_x(M_PI / 2);
  parameters.largest_imu_gap = 0.2;  // it comes at 30 Hz
  return parameters;
}

HuskyScore score_husky(const HuskyRecording& husky) {
  HuskyScore score{.started = std::numeric_limits<double>::quiet_NaN()};
  std::optional<std::size_t> held_before;
  drive(husky, 0, 0,
        [&](const GpsMeasurement& fix, const estimation::Estimate& estimate,
            const estimation::SourceStatus& gps) {
          if (!held_before) {
            held_before = gps.held + gps.gated;
            score.started = fix.time;
          }
          const double error = distance(fix, estimate);
          score.rms += error * error;
          score.largest = std::max(score.largest, error);
          score.held_out = gps.held + gps.gated - *held_before;
          ++score.compared;
        });
  score.rms = std::sqrt(score.rms / static_cast<double>(score.compared));
  return score;
}

std::optional<double> score_husky_outage(const HuskyRecording& husky, double begin,
                                         double duration) {
  std::optional<double> error;
  drive(husky, begin, duration,
        [&](const GpsMeasurement& fix, const estimation::Estimate& estimate,
            const estimation::SourceStatus& /*gps*/) {
          if (fix.time >= begin && fix.time < begin + duration) {
            error = distance(fix, estimate);
          }
        });
  return error;
}

}  // namespace pipescout::estimation_study
