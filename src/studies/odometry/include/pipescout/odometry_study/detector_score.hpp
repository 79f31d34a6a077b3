// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <vector>

namespace pipescout::odometry_study {

/// `WeldDetector` on the simulated signal of a pipe with all features and disturbances. The speed
/// goes from 0.02 to 0.58 m/s, the crawler stands for 15 s every 200 s and reverses for 2 m every
/// 900 s. A weld is found when an event lies within 0.05 m of it; every other event is false. The
/// last metre at either end of the pipe is not scored.
struct DetectorScore {
  int welds = 0;
  int found = 0;
  int wrong = 0;
  double km = 0.0;
  std::uint64_t samples = 0;
  std::vector<double> errors{};      ///< m, absolute, of the position
  std::vector<double> normalised{};  ///< by the stated standard deviation

  DetectorScore& operator+=(const DetectorScore& other);
  [[nodiscard]] double found_percent() const;
  [[nodiscard]] double false_per_km() const;
  /// Share of the positions within this many stated standard deviations.
  [[nodiscard]] double share_within(double sigmas) const;
};

/// `peak_snr`: as in simulation::EddyCurrentParameters, dB. `length`: m of pipe.
[[nodiscard]] DetectorScore score_detector(double peak_snr, double length, std::uint64_t seed);

}  // namespace pipescout::odometry_study
