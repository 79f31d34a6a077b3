// SPDX-License-Identifier: Apache-2.0
#include "pipescout/estimation_study/sensor_loss.hpp"

#include <algorithm>
#include <type_traits>

#include "pipescout/validation/check.hpp"
#include "recorder.hpp"

namespace pipescout::estimation_study {

void SensorLoss::validate() const {
  validation::check_within("share", share, 0, 0.9);
  validation::check_within("longest_burst", longest_burst, 0, 60);
  validation::check_within("lag", lag, 0, 60);
}

std::optional<Sensor> sensor_of(const Reading& reading) {
  return std::visit(
      [](const auto& r) -> std::optional<Sensor> {
        using Kind = std::decay_t<decltype(r)>;
        if constexpr (std::is_same_v<Kind, estimation::ImuReading>) {
          return Sensor::kImu;
        } else if constexpr (std::is_same_v<Kind, estimation::OdometerReading>) {
          return Sensor::kOdometer;
        } else if constexpr (std::is_same_v<Kind, estimation::GpsMeasurement>) {
          return Sensor::kGps;
        } else if constexpr (std::is_same_v<Kind, estimation::VisualPoseMeasurement>) {
          return Sensor::kVisualPose;
        } else if constexpr (std::is_same_v<Kind, estimation::WeldMeasurement>) {
          return Sensor::kWeld;
        } else {
          return std::nullopt;
        }
      },
      reading);
}

VehicleRun with_loss(VehicleRun run, const SensorLoss& loss, double from, std::uint64_t seed) {
  loss.validate();
  internal::Draw draw = internal::make_draw(seed, 20);
  double begin = from;  // of the next burst
  double end = from;
  const auto next_burst = [&](double after) {
    // Bursts of half the longest on average, as far apart as the share asks for.
    const double spacing = 0.5 * loss.longest_burst * (1 - loss.share) / loss.share;
    begin = after + draw.uniform(0, 2 * spacing);
    end = begin + draw.uniform(0, loss.longest_burst);
  };
  const bool in_bursts = loss.share > 0 && loss.longest_burst > 0;
  if (in_bursts) {
    next_burst(from);
  }
  std::erase_if(run.events, [&](const Event& event) {
    const double time = time_of(event.reading);
    if (sensor_of(event.reading) != loss.sensor || time < from) {
      return false;
    }
    if (!in_bursts) {
      return draw.happens(loss.share);
    }
    while (time >= end) {
      next_burst(end);
    }
    return time >= begin;
  });
  for (Event& event : run.events) {
    const bool late = sensor_of(event.reading) == loss.sensor && time_of(event.reading) >= from;
    event.arrival += late ? loss.lag : 0;
  }
  std::ranges::stable_sort(run.events, {}, &Event::arrival);
  return run;
}

double longest_gap(const VehicleRun& run, Sensor sensor) {
  double longest = 0;
  std::optional<double> last;
  for (const Event& event : run.events) {
    if (sensor_of(event.reading) == sensor) {
      const double time = time_of(event.reading);
      longest = last ? std::max(longest, time - *last) : 0;
      last = time;
    }
  }
  return last && !run.truth.empty() ? std::max(longest, run.truth.back().time - *last) : longest;
}

}  // namespace pipescout::estimation_study
