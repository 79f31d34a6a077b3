// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "pipescout/leak_study/sequence_run.hpp"

/// Receiver operating characteristic of the leak inspection over Delta-T and the camera's noise.
namespace pipescout::leak_study {

struct RocSettings {
  std::vector<double> rises{25, 50, 75, 100};       ///< K, of leaks of 0.3 m; positive
  std::vector<double> netds{0.05, 0.12, 0.5, 1.5};  ///< K
  std::size_t leaks = 5;    ///< [1, 100]: of each rise, along one row, for each noise
  std::size_t decoys = 12;  ///< [0, 1000]: along another one
  /// K: smallest Delta-T that is evaluated; below all thresholds of interest.
  double least_delta = 15;
};

/// Delta-T of findings, the score of the classification.
struct RocScores {
  double netd = 0;                              ///< K
  std::vector<std::vector<double>> of_leaks{};  ///< K, for each rise; 0 where it is not found
  std::vector<double> of_others{};              ///< K, of false findings
  double metres = 0;                            ///< of tube passed
};

/// One for each noise. `settings` as of the whole inspection, but for the least Delta-T. The same
/// arguments give the same bits.
[[nodiscard]] std::vector<RocScores> run_roc(const RocSettings& roc,
                                             const InspectionSettings& settings,
                                             std::uint64_t seed);

struct RocPoint {
  double threshold = 0;      ///< K
  double found_percent = 0;  ///< of the leaks
  double false_per_km = 0;
};
/// At thresholds, K.
[[nodiscard]] std::vector<RocPoint> roc_curve(std::span<const double> leaks,
                                              std::span<const double> others, double metres,
                                              std::span<const double> thresholds);
/// Probability that a leak scores higher than another finding, half of it where they are alike: the
/// area under the curve; 1 without others. `leaks` is not empty.
[[nodiscard]] double roc_area(std::span<const double> leaks, std::span<const double> others);

}  // namespace pipescout::leak_study
