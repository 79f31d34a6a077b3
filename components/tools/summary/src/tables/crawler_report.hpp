// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <deque>
#include <optional>
#include <string>
#include <vector>

#include "pipescout/mission_folder/mission_section.hpp"
#include "pipescout/runtime/time.hpp"

namespace pipescout::summary {

/// Report of a run of a crawler: its welds as a table, and its position errors if the truth is
/// known. Bounded in memory for any length of the run. Pure; not thread-safe.
class CrawlerReport {
 public:
  struct Weld {
    std::string id;                   ///< empty: not recognised
    double chainage = 0.0;            ///< m, by the tally; NaN: not recognised
    double distance = 0.0;            ///< m, of the odometer
    double standard_deviation = 0.0;  ///< m
    double confidence = 0.0;
    double probability = 0.0;
  };
  struct Position {
    Time stamp{};
    bool locked = false;
    std::uint32_t joint = 0;
    double into_joint = 0.0;          ///< m
    double standard_deviation = 0.0;  ///< m
    double odometer_distance = 0.0;   ///< m
  };

  /// `maximum_rows`: of the table.
  explicit CrawlerReport(std::size_t maximum_rows);

  void add_weld(const Weld& weld);
  /// With rising stamps. Positions are compared with the latest ones, linear in between.
  void add_truth(const Position& truth);
  void add_position(const Position& position);

  [[nodiscard]] std::uint64_t welds() const noexcept { return welds_; }
  [[nodiscard]] std::uint64_t positions() const noexcept { return positions_; }

  /// Title, table, figures and notes. `figure_prefix` comes before the names of the figures:
  /// "robot_1." or nothing.
  [[nodiscard]] MissionSection section(const std::string& figure_prefix) const;

 private:
  /// Of the errors of locked positions, m: one bin per millimetre, the last for all beyond.
  static constexpr std::size_t kBins = 5001;
  /// Truths that are remembered: positions come seconds later.
  static constexpr std::size_t kMaximumTruths = 4096;

  [[nodiscard]] std::optional<Position> truth_at(Time stamp) const;
  [[nodiscard]] double quantile(double share) const;

  std::size_t maximum_rows_;
  std::vector<Weld> rows_;
  std::uint64_t welds_ = 0;
  std::uint64_t recognised_ = 0;
  std::uint64_t positions_ = 0;
  std::uint64_t locked_ = 0;
  std::optional<std::uint64_t> welds_to_lock_;
  double distance_ = 0.0;  // m, of the odometer
  std::deque<Position> truths_;
  std::uint64_t compared_ = 0;
  std::uint64_t wrong_joint_ = 0;
  std::uint64_t covered_ = 0;
  double worst_ = 0.0;  // m
  std::array<std::uint64_t, kBins> errors_{};
};

}  // namespace pipescout::summary
