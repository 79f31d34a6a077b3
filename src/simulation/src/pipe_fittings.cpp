// SPDX-License-Identifier: Apache-2.0
#include "pipescout/simulation/pipe_fittings.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <string>

#include "pipescout/validation/check.hpp"

namespace pipescout::simulation {
namespace {

using validation::check_above;
using validation::check_within;

constexpr double kUnlimited = std::numeric_limits<double>::infinity();

std::string element(const char* list, std::size_t index) {
  return std::string(list) + "[" + std::to_string(index) + "].";
}

/// Integral of cos(angle + turn * s) over s in [0, length].
double cosine_sum(double angle, double turn, double length) {
  // sin(b) - sin(a) as a product, which keeps its digits for a small turn.
  const double half = 0.5 * turn * length;
  const double share = std::abs(half) < 1e-8 ? 1.0 : std::sin(half) / half;
  return length * share * std::cos(angle + half);
}

/// Length of [from, to] within [low, high].
double overlap(double from, double to, double low, double high) {
  return std::max(0.0, std::min(to, high) - std::max(from, low));
}

}  // namespace

void PipeFittings::validate() const {
  check_above("radius", radius, 0.0, kUnlimited);
  double end = -kUnlimited;
  for (std::size_t i = 0; i < bends.size(); ++i) {
    const std::string prefix = element("bends", i);
    check_above(prefix + "radius", bends[i].radius, radius, kUnlimited);
    check_above(prefix + "angle", bends[i].angle, 0.0, 2.0 * std::numbers::pi);
    check_within(prefix + "direction", bends[i].direction, -kUnlimited, kUnlimited);
    check_within(prefix + "begin", bends[i].begin, end, kUnlimited);
    end = bends[i].end();
  }
  end = -kUnlimited;
  for (std::size_t i = 0; i < tees.size(); ++i) {
    const std::string prefix = element("tees", i);
    check_within(prefix + "position", tees[i].position, end, kUnlimited);
    check_above(prefix + "radius", tees[i].radius, 0.0, radius);
    check_within(prefix + "direction", tees[i].direction, -kUnlimited, kUnlimited);
    end = tees[i].position;
  }
  end = -kUnlimited;
  for (std::size_t i = 0; i < rises.size(); ++i) {
    const std::string prefix = element("rises", i);
    check_within(prefix + "begin", rises[i].begin, end, kUnlimited);
    check_above(prefix + "length", rises[i].length, 0.0, kUnlimited);
    check_within(prefix + "pitch", rises[i].pitch, -0.5 * std::numbers::pi, 0.5 * std::numbers::pi);
    end = rises[i].begin + rises[i].length;
  }
}

double wall_distance(const PipeFittings& fittings, const WallLine& line, double from,
                     double to) noexcept {
  double distance = to - from;
  const auto bend = std::ranges::upper_bound(fittings.bends, from, {}, &PipeBend::end);
  for (auto it = bend; it != fittings.bends.end() && it->begin < to; ++it) {
    const double begin = std::max(from, it->begin);
    const double length = overlap(from, to, it->begin, it->end());
    const double angle = line.angle + line.turn_per_metre * begin - it->direction;
    distance -= fittings.radius / it->radius * cosine_sum(angle, line.turn_per_metre, length);
  }
  const auto tee =
      std::ranges::lower_bound(fittings.tees, from - fittings.radius, {}, &PipeTee::position);
  for (auto it = tee; it != fittings.tees.end() && it->position < to + fittings.radius; ++it) {
    const double angle = line.angle + line.turn_per_metre * it->position - it->direction;
    const double aside = fittings.radius * std::sin(angle);
    if (std::cos(angle) > 0.0 && std::abs(aside) < it->radius) {
      const double half = std::sqrt(it->radius * it->radius - aside * aside);
      distance -= overlap(from, to, it->position - half, it->position + half);
    }
  }
  return distance;
}

std::optional<double> pitch_on_rise(const PipeFittings& fittings, double position) noexcept {
  const auto after = std::ranges::upper_bound(fittings.rises, position, {}, &PipeRise::begin);
  if (after == fittings.rises.begin()) {
    return std::nullopt;
  }
  const PipeRise& rise = *std::prev(after);
  return position <= rise.begin + rise.length ? std::optional(rise.pitch) : std::nullopt;
}

}  // namespace pipescout::simulation
