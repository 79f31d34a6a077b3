// SPDX-License-Identifier: Apache-2.0
#include "weld_signal.hpp"

#include <cmath>
#include <utility>

namespace pipescout::odometry::test {

Complex doublet(double distance, double middle, double width, Complex peak) {
  const double deviation = width / 3.0;
  const auto bell = [&](double at) {
    const double u = (distance - at) / deviation;
    return std::exp(-u * u / 2.0);
  };
  return peak * (bell(middle - width / 2.0) - bell(middle + width / 2.0));
}

Signal welds_at(std::vector<double> middles, double width, Complex peak) {
  return [middles = std::move(middles), width, peak](double distance) {
    Complex sum{};
    for (const double middle : middles) {
      if (std::abs(distance - middle) < 10.0 * width) {
        sum += doublet(distance, middle, width, peak);
      }
    }
    return sum;
  };
}

Crawl::Crawl(WeldDetector& detector, Signal signal, double noise, std::uint64_t seed)
    : detector_(detector), signal_(std::move(signal)), noise_(noise), engine_(seed) {}

void Crawl::keep(std::span<const WeldEvent> events) {
  events_.insert(events_.end(), events.begin(), events.end());
}

void Crawl::go_to(double distance, double step) {
  const double from = at_;
  const double direction = distance > from ? 1.0 : -1.0;
  const auto steps = static_cast<std::int64_t>(std::abs(distance - from) / step);
  for (std::int64_t i = 0; i < steps; ++i) {
    sample(from + direction * step * static_cast<double>(i));
  }
  at_ = distance;
}

void Crawl::sample(double distance) {
  const Complex value = signal_(distance);
  const double x = noise_ * normal_(engine_);
  const double y = noise_ * normal_(engine_);
  sample(distance, {value.real() + x, value.imag() + y});
}

void Crawl::sample(double distance, Impedance value) {
  at_ = distance;
  keep(detector_.update(distance, {&value, 1}));
}

void Crawl::finish() {
  keep(detector_.finish());
}

std::vector<double> Crawl::distances() const {
  std::vector<double> distances;
  for (const auto& event : events_) {
    distances.push_back(event.distance);
  }
  return distances;
}

}  // namespace pipescout::odometry::test
