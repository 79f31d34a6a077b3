// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <numbers>
#include <pipescout/odometry/odometer_stream.hpp>

/// Three wheels around a pipe of 0.6 m drive 20 m: an elbow of 3 diameters from 6 m on, where each
/// goes its own way, and a slip of one wheel from 12 m to 14 m.
int main() {
  using namespace pipescout::odometry;
  constexpr double kPi = std::numbers::pi;
  constexpr double kTowards = kPi / 3.0;  // 2 o'clock
  OdometerStreamParameters parameters;
  parameters.rule = FusionRule::kCircumference;
  parameters.circumference.radius = 0.3;
  parameters.window_distance = 0.3;
  for (const double clock : {0.0, 2.0 * kPi / 3.0, 4.0 * kPi / 3.0}) {
    parameters.odometers.push_back({.sigma_per_sqrt_metre = 0.004, .clock = clock});
  }
  OdometerStream stream(parameters);
  constexpr int kSamples = 2000;
  for (int k = 0; k <= kSamples; ++k) {
    const double driven = 0.01 * k;
    const double turned = std::clamp((driven - 6.0) / 1.8, 0.0, kPi / 2.0);  // rad
    for (std::size_t i = 0; i < parameters.odometers.size(); ++i) {
      double rolled = driven - 0.3 * turned * std::cos(parameters.odometers[i].clock - kTowards);
      rolled -= i == 1 ? 0.2 * std::clamp(driven - 12.0, 0.0, 2.0) : 0.0;
      stream.push({.odometer = i, .time = 0.05 * k, .value = rolled});
    }
  }
  const FusedStream& state = stream.state();
  const auto& bend = state.recent_bends[0];
  const double hours = std::fmod(bend.direction * 6.0 / kPi + 12.0, 12.0);
  std::printf(
      "20.000 m driven: %.3f +- %.3f m; a bend of %.0f degrees towards %.0f:%02.0f at %.1f m\n",
      state.distance, std::sqrt(state.variance), bend.angle * 180.0 / kPi, std::floor(hours),
      60.0 * (hours - std::floor(hours)), bend.middle);
  return state.bends == 1 && std::abs(state.distance - 20.0) < 0.05 ? 0 : 1;
}
