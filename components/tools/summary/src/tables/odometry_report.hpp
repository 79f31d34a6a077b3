// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "pipescout/mission_folder/mission_section.hpp"
#include "pipescout/runtime/time.hpp"

namespace pipescout::summary {

/// The table of the section: puts each fused distance beside the readings of the same stamp, in
/// whatever order the two arrive, and beside a reference. Bounded in memory however long it runs:
/// rows beyond a limit are counted but not kept. Pure; not thread-safe.
class OdometryReport {
 public:
  struct Options {
    std::vector<std::string> odometers;
    /// m, one for each odometer, that the fusion adds to its readings; nothing: not known.
    std::optional<std::vector<double>> offsets;
    /// Reference for the fused distance of reading 1, 2, ...; m, NaN where there is none.
    std::vector<double> reference;
    std::string reference_name;      ///< "paper"
    std::size_t maximum_rows = 200;  ///< of the table
  };

  struct Fused {
    Time stamp{};
    bool has_consensus = false;
    double distance = 0.0;            ///< m
    double standard_deviation = 0.0;  ///< m
    std::vector<bool> in_fusion_set;  ///< of each odometer
  };

  explicit OdometryReport(Options options);

  /// Returns the number of the reading: 1, 2, ...
  std::uint64_t add_reading(Time stamp, const std::vector<double>& distance);
  /// Returns the number of the reading it belongs to, or nothing when that has not arrived (yet).
  std::optional<std::uint64_t> add_fused(const Fused& fused);

  [[nodiscard]] std::uint64_t readings() const noexcept { return readings_; }
  [[nodiscard]] std::uint64_t fused() const noexcept { return fused_; }
  /// Readings whose fused distance is there.
  [[nodiscard]] std::uint64_t pairs() const noexcept { return pairs_; }

  /// Title, table and figures, and notes on what the table does not show. The table has the
  /// readings as they were fused: with the offsets. `figure_prefix` comes before the names of the
  /// figures: "robot_1." or nothing.
  [[nodiscard]] MissionSection section(const std::string& figure_prefix) const;

 private:
  struct Row {
    std::vector<double> distance;
    std::optional<Fused> fused;
  };
  /// Of readings and fused distances that wait for each other; the oldest makes room.
  static constexpr std::size_t kMaximumWaiting = 1024;

  void pair(std::uint64_t reading, const Fused& fused);
  [[nodiscard]] double reference(std::uint64_t reading) const;
  [[nodiscard]] double offset(std::size_t odometer) const;
  [[nodiscard]] bool has_offsets() const;
  [[nodiscard]] bool is_between_its_readings(const Row& row) const;
  void add_notes_on_offsets(MissionSection& section) const;

  Options options_;
  std::uint64_t readings_ = 0;
  std::uint64_t fused_ = 0;
  std::uint64_t pairs_ = 0;
  std::uint64_t without_consensus_ = 0;
  std::multimap<Time, std::uint64_t> waiting_readings_;
  std::multimap<Time, Fused> waiting_fused_;
  std::vector<Row> rows_;  // row i is reading i + 1
  std::optional<double> largest_difference_;
  std::uint64_t largest_difference_reading_ = 0;
};

/// "2 3" for the second and the third: numbers from 1.
[[nodiscard]] std::string format_fusion_set(const std::vector<bool>& in_fusion_set);

}  // namespace pipescout::summary
