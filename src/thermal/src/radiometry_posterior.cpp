// SPDX-License-Identifier: Apache-2.0
#include "pipescout/thermal/radiometry_posterior.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numeric>
#include <utility>

#include "pipescout/statistics/draw.hpp"
#include "pipescout/validation/check.hpp"

namespace pipescout::thermal {
namespace {

/// The quantiles of 95 % are then known to a tenth of a standard deviation.
constexpr std::size_t kDraws = 512;
constexpr std::uint64_t kSeed = 1;
constexpr double kEdge = 10;  // K, over which the range of the pipe falls off
/// Share of the draws that have to count: with fewer, what is told contradicts the images.
constexpr double kLeastShare = 0.01;
constexpr double kColdest = -150;  // degC, of anything that is reflected or a window
constexpr double kHottest = 1000;
constexpr double kLow = 0.025;
constexpr double kHigh = 0.975;

ObjectParameters drawn(const ObjectParameters& told, const ParameterDeviations& d,
                       statistics::Draw& draw) {
  ObjectParameters o = told;
  const double relative = d.emissivity / told.emissivity;
  // A log-normal cut at 1; one that is told as 1 stays below it.
  const double logarithm = relative * draw.normal();
  o.emissivity = told.emissivity * std::exp(logarithm);
  if (o.emissivity > 1) {
    o.emissivity = std::min(1.0, told.emissivity * std::exp(-std::abs(logarithm)));
  }
  o.reflected_temperature = std::clamp(
      told.reflected_temperature + d.reflected_temperature * draw.normal(), kColdest, kHottest);
  o.distance = std::clamp(told.distance + d.distance * draw.normal(), 0.0, 10000.0);
  o.atmospheric_temperature = std::clamp(
      told.atmospheric_temperature + d.atmospheric_temperature * draw.normal(), -60.0, 80.0);
  o.relative_humidity =
      std::clamp(told.relative_humidity + d.relative_humidity * draw.normal(), 0.0, 1.0);
  o.window_temperature = std::clamp(told.window_temperature + d.window_temperature * draw.normal(),
                                    kColdest, kHottest);
  constexpr double kDarkest = 0.01;
  o.window_transmission =
      std::clamp(told.window_transmission + d.window_transmission * draw.normal(), kDarkest, 1.0);
  return o;
}

}  // namespace

void PipeTemperatureRange::validate() const {
  validation::require("pipe_temperature.least", least, least > -kZeroCelsius,
                      "(-273.15, inf) degC");
  validation::require("pipe_temperature.most", most, most > least && most < kHottestBody,
                      "(least, 2000) degC");
}

PipeTemperatureRange collector_temperatures() noexcept {
  return {.least = 100, .most = 400};
}

RadiometryPosterior::RadiometryPosterior(const CameraConstants& camera,
                                         const ObjectParameters& told,
                                         const ParameterDeviations& deviations,
                                         const PipeTemperatureRange& pipe)
    : planck_(camera.planck), pipe_(pipe) {
  deviations.validate();
  pipe.validate();
  const Radiometry as_told(camera, told);
  const double slope = planck_.slope(told.reflected_temperature);
  statistics::Draw draw(kSeed, 0);
  draws_.reserve(kDraws);
  for (std::size_t i = 0; i < kDraws; ++i) {
    const ObjectParameters object = drawn(as_told.object(), deviations, draw);
    const double offset = deviations.calibration * slope * draw.normal();
    draws_.push_back({Radiometry(camera, object), offset, 1});
  }
}

double RadiometryPosterior::counts(double apparent) const noexcept {
  return planck_.counts(apparent);
}

void RadiometryPosterior::observe(double apparent) {
  const double seen = counts(apparent);
  if (!std::isfinite(seen)) {
    return;
  }
  ++images_;
  mean_ += (seen - mean_) / static_cast<double>(images_);
  weigh();
}

void RadiometryPosterior::weigh() {
  double sum = 0;
  for (Draw& draw : draws_) {
    const double temperature = draw.radiometry.temperature(mean_ + draw.offset);
    const double outside =
        std::max({0.0, pipe_.least - temperature, temperature - pipe_.most}) / kEdge;
    draw.weight = std::isfinite(temperature) ? std::exp(-0.5 * outside * outside) : 0;
    sum += draw.weight;
  }
  contradicted_ = sum < kLeastShare * static_cast<double>(kDraws);
  if (contradicted_) {
    for (Draw& draw : draws_) {
      draw.weight = 1;
    }
  }
}

/// Weighted quantiles of what `value` makes of the draws.
template <class Value>
TemperatureInterval RadiometryPosterior::interval(const Value& value) const {
  constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
  std::array<std::pair<double, double>, kDraws> of_draws;
  std::size_t count = 0;
  double total = 0;
  double sum = 0;
  for (const Draw& draw : draws_) {
    const double each = value(draw);
    if (std::isfinite(each) && draw.weight > 0) {
      of_draws[count++] = {each, draw.weight};
      total += draw.weight;
      sum += draw.weight * each;
    }
  }
  if (count == 0) {
    return {.mean = kNan, .deviation = kNan, .low = kNan, .high = kNan};
  }
  const auto end = of_draws.begin() + static_cast<std::ptrdiff_t>(count);
  std::sort(of_draws.begin(), end);
  const auto quantile = [&](double share) {
    double below = 0;
    for (auto each = of_draws.begin(); each != end; ++each) {
      below += each->second;
      if (below >= share * total) {
        return each->first;
      }
    }
    return (end - 1)->first;
  };
  const double mean = sum / total;
  const double squares =
      std::accumulate(of_draws.begin(), end, 0.0, [mean](double before, const auto& each) {
        return before + each.second * (each.first - mean) * (each.first - mean);
      });
  return {.mean = quantile(0.5),
          .deviation = std::sqrt(squares / total),
          .low = quantile(kLow),
          .high = quantile(kHigh)};
}

TemperatureInterval RadiometryPosterior::temperature(double apparent) const {
  const double seen = counts(apparent);
  return interval(
      [seen](const Draw& draw) { return draw.radiometry.temperature(seen + draw.offset); });
}

TemperatureInterval RadiometryPosterior::difference(double apparent, double base) const {
  const double seen = counts(apparent);
  const double of_base = counts(base);
  return interval([seen, of_base](const Draw& draw) {
    return draw.radiometry.temperature(seen + draw.offset) -
           draw.radiometry.temperature(of_base + draw.offset);
  });
}

TemperatureInterval RadiometryPosterior::pipe_temperature() const {
  return images_ == 0 ? temperature(std::numeric_limits<double>::quiet_NaN())
                      : temperature(planck_.temperature(mean_));
}

TemperatureInterval RadiometryPosterior::emissivity() const {
  return interval([](const Draw& draw) { return draw.radiometry.object().emissivity; });
}

TemperatureInterval RadiometryPosterior::reflected_temperature() const {
  return interval([](const Draw& draw) { return draw.radiometry.object().reflected_temperature; });
}

}  // namespace pipescout::thermal
