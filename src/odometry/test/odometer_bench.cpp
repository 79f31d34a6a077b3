// SPDX-License-Identifier: Apache-2.0
#include "odometer_bench.hpp"

#include <utility>

namespace pipescout::odometry::test {

OdometerBench::OdometerBench(OdometerStream& stream, std::vector<BenchWheel> wheels,
                             std::function<double(double)> position)
    : stream_(stream),
      wheels_(std::move(wheels)),
      position_(std::move(position)),
      sent_(wheels_.size(), 0) {}

void OdometerBench::run_until(double time) {
  const auto next = [this](std::size_t i) {
    return wheels_[i].start + static_cast<double>(sent_[i]) * wheels_[i].period;
  };
  while (true) {
    std::size_t first = 0;
    for (std::size_t i = 1; i < wheels_.size(); ++i) {
      first = next(i) < next(first) ? i : first;
    }
    const double now = next(first);
    if (now > time) {
      return;
    }
    ++sent_[first];
    if (wheels_[first].sends(now)) {
      stream_.push(
          {.odometer = first, .time = now, .value = wheels_[first].model(now, position_(now))});
      observe();
    }
  }
}

OdometerStreamParameters fine_odometers(std::size_t count) {
  OdometerStreamParameters parameters;
  parameters.odometers.resize(count, {.sigma_per_sqrt_metre = 0.003});
  return parameters;
}

}  // namespace pipescout::odometry::test
