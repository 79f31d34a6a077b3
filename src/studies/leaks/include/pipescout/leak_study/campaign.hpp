// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "pipescout/simulation/thermal_patrol.hpp"

/// Night patrols along half loops of collectors, after the database of Ibarguren and others (2013),
/// section 7: some with leaks, some with features that resemble leaks. SI units, degrees Celsius.
namespace pipescout::leak_study {

struct CampaignSettings {
  std::size_t sequences = 60;   ///< [1, 10000]: one along each row of collectors
  std::size_t faint_leaks = 6;  ///< [0, sequences]: 75 to 90 K over 0.3 to 0.5 m
  std::size_t near_leaks = 0;   ///< [0, sequences]: as faint ones, beside a joint or a post
  std::size_t other_leaks = 7;  ///< [0, 10 sequences]: 95 to 250 K over 0.4 to 4 m
  std::size_t decoys = 40;      ///< [0, 10 sequences]: of all kinds, as many of each
  double netd_least = 0.05;     ///< K, [0, netd_most]
  double netd_most = 0.12;      ///< K, [netd_least, 5]
  double length = 150;          ///< m, [20, 5000]: of a row
  /// m, [0, length / 4]: smallest distance between leaks and decoys, and of leaks from the ends.
  double apart = 4;
  /// What the camera is told is wrong: true emissivity 0.02 to 0.1 (evenly in its logarithm; told
  /// 0.04), reflected temperature within 10 K, air temperature within 10 K, humidity and distance
  /// within 30 %. Images are counts.
  bool drawn_radiometry = false;
  bool automatic_gain = false;  ///< images are 8-bit video with automatic gain

  /// Throws std::invalid_argument naming the field, the value and the range.
  void validate() const;
};

/// One patrol along one row, and the format of its images.
struct SequencePlan {
  simulation::ThermalPatrolParameters patrol{};
  bool grey = false;            ///< 8 bits from 100 to 300 degC; otherwise counts
  bool automatic_gain = false;  ///< 8 bits, of ThermalAutomaticGain
  std::size_t faint_leaks = 0;  ///< the first so many leaks of the scene are
  std::size_t near_leaks = 0;   ///< the last so many are beside a joint or a post
};

/// The same settings and seed give the same plans. Odd ones are of 320x240 pixels, even ones of
/// 640x512; every fifth is in grey. Rows are next to each other in the map, in any direction; the
/// ground is of the classes C to E of ISO 8608. Throws as CampaignSettings::validate, and
/// std::runtime_error when there is no room for so many leaks and decoys.
[[nodiscard]] std::vector<SequencePlan> plan_campaign(const CampaignSettings& settings,
                                                      std::uint64_t seed);

/// One of the kind, with a place and its other properties drawn as in a campaign.
[[nodiscard]] simulation::ThermalDecoy draw_decoy(simulation::ThermalDecoyKind kind, double place,
                                                  std::uint64_t seed);

}  // namespace pipescout::leak_study
