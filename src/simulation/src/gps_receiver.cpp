// SPDX-License-Identifier: Apache-2.0
#include "pipescout/simulation/gps_receiver.hpp"

#include <cmath>
#include <limits>
#include <numbers>
#include <stdexcept>
#include <string>

#include "pipescout/statistics/draw.hpp"
#include "pipescout/validation/check.hpp"

namespace pipescout::simulation {
namespace {

using validation::check_within;

Eigen::Vector3d white(std::mt19937_64& engine) {
  Eigen::Vector3d result;
  for (double& entry : result) {
    entry = statistics::normal(engine);
  }
  return result;
}

void check_vector(const std::string& name, const Eigen::Vector3d& v, double low, double high) {
  for (const double entry : v) {
    check_within(name, entry, low, high);
  }
}

bool within(double time, double begin, double duration) {
  return time >= begin && time < begin + duration;
}

}  // namespace

void GpsParameters::validate() const {
  constexpr double kFar = 1e9;
  constexpr double kLargest = std::numeric_limits<double>::max();
  check_within("period", period, 0.01, 1000);
  check_within("latency", latency, 0, 10);
  check_within("latency_spread", latency_spread, 0, 10);
  check_vector("white_deviation", white_deviation, 0, 100);
  check_vector("correlated_deviation", correlated_deviation, 0, 100);
  check_within("correlation_time", correlation_time, 0.01, 1e5);
  check_within("outlier_share", outlier_share, 0, 1);
  check_within("outlier_least", outlier_least, 0, 1e5);
  check_within("outlier_most", outlier_most, outlier_least, 1e5);
  check_within("stated_share", stated_share, 0.01, 100);
  check_vector("antenna", antenna, -kFar, kFar);
  for (const GpsOutage& outage : outages) {
    check_within("outages.begin", outage.begin, -kFar, kFar);
    check_within("outages.duration", outage.duration, 0, kLargest);
  }
  for (const GpsTrap& trap : traps) {
    check_within("traps.begin", trap.begin, -kFar, kFar);
    check_within("traps.duration", trap.duration, 0, kLargest);
    check_vector("traps.offset", trap.offset, -kFar, kFar);
  }
  if ((white_deviation.cwiseAbs2() + correlated_deviation.cwiseAbs2()).minCoeff() <= 0) {
    throw std::invalid_argument(
        "white_deviation: 0, and correlated_deviation too: no covariance can be stated");
  }
}

GpsReceiver::GpsReceiver(const GpsParameters& parameters, std::uint64_t seed)
    : parameters_(parameters),
      engine_(statistics::make_engine(seed, 4)),
      trapped_at_(parameters.traps.size()) {
  parameters_.validate();
  correlated_ = parameters_.correlated_deviation.cwiseProduct(white(engine_));
}

double GpsReceiver::due() const noexcept {
  return static_cast<double>(fixes_) * parameters_.period;
}

std::optional<GpsFix> GpsReceiver::measure(const geometry::SE3& T_map_body) {
  // All that is drawn is drawn for every fix, so that options change nothing but what they say.
  const Eigen::Vector3d noise = parameters_.white_deviation.cwiseProduct(white(engine_));
  const bool outlier = statistics::uniform(engine_) < parameters_.outlier_share;
  const double by =
      statistics::uniform(engine_, parameters_.outlier_least, parameters_.outlier_most);
  const double towards = statistics::uniform(engine_, 0, 2 * std::numbers::pi);
  const double late =
      parameters_.latency + parameters_.latency_spread * statistics::uniform(engine_);

  GpsFix fix;
  fix.time = due();
  fix.arrival = fix.time + late;
  const Eigen::Vector3d antenna = T_map_body * parameters_.antenna;
  fix.position = antenna + noise + correlated_;
  fix.covariance =
      (parameters_.stated_share * parameters_.stated_share *
       (parameters_.white_deviation.cwiseAbs2() + parameters_.correlated_deviation.cwiseAbs2()))
          .asDiagonal();
  if (outlier) {
    fix.kind = GpsFixKind::kOutlier;
    fix.position += by * Eigen::Vector3d(std::cos(towards), std::sin(towards), 0);
  }
  for (std::size_t i = 0; i < parameters_.traps.size(); ++i) {
    const GpsTrap& trap = parameters_.traps[i];
    if (within(fix.time, trap.begin, trap.duration)) {
      if (!trapped_at_[i]) {
        trapped_at_[i] = antenna + trap.offset;
      }
      fix.kind = GpsFixKind::kTrap;
      fix.position =
          (trap.moves_along ? Eigen::Vector3d(antenna + trap.offset) : *trapped_at_[i]) + noise;
    }
  }
  bool silent = false;
  for (const GpsOutage& outage : parameters_.outages) {
    silent = silent || within(fix.time, outage.begin, outage.duration);
  }

  ++fixes_;
  const double decay = std::exp(-parameters_.period / parameters_.correlation_time);
  correlated_ =
      decay * correlated_ +
      std::sqrt(1 - decay * decay) * parameters_.correlated_deviation.cwiseProduct(white(engine_));
  if (silent) {
    return std::nullopt;
  }
  return fix;
}

}  // namespace pipescout::simulation
