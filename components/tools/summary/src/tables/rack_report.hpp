// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>

#include "pipescout/geometry/se3.hpp"
#include "pipescout/mission_folder/mission_section.hpp"
#include "pipescout/mission_tables/error_histogram.hpp"
#include "pipescout/mission_tables/true_track.hpp"
#include "pipescout/runtime/time.hpp"

namespace pipescout::summary {

/// Report of a flight over a rack: share of the time with a pose, pose errors if the truth is
/// known, and number of way-points done. Bounded in memory for any length of the flight. Pure; not
/// thread-safe.
class RackReport {
 public:
  struct Pose {
    Time stamp{};
    geometry::SE3 T_rack_camera;
    /// 1-sigma of (x, y, z, rotation about the fixed axes x, y, z of the rack), m and rad.
    geometry::Vector6d standard_deviation = geometry::Vector6d::Zero();
  };

  /// Poses are compared with the truth at their own stamp, between two truths interpolated. In any
  /// order: of poses without a truth yet the last 1024 wait for it.
  void add_pose(const Pose& pose);
  void add_truth(Time stamp, const geometry::SE3& T_rack_camera);
  /// One per image. `losses`: as the localizer counts them since its start.
  void add_state(Time stamp, bool tracking, std::uint64_t losses);
  /// `done`: reached or given up; `text`: what the source says of them.
  void set_way_points(std::uint64_t done, std::uint64_t of, const std::string& text);

  [[nodiscard]] std::uint64_t poses() const noexcept { return poses_; }
  [[nodiscard]] std::uint64_t losses() const noexcept { return losses_; }

  /// Title, table, figures and notes. `figure_prefix` comes before the names of the figures:
  /// "robot_1." or nothing.
  [[nodiscard]] MissionSection section(const std::string& figure_prefix) const;

 private:
  /// A row of the table: an error, and what the poses say of it.
  struct Measure {
    ErrorHistogram errors;
    std::uint64_t covered = 0;
    double sum_of_variances = 0;
  };

  void compare(const Pose& pose, const geometry::SE3& truth);
  void add_table(MissionSection& section) const;
  void add_notes(MissionSection& section) const;

  std::uint64_t poses_ = 0;
  std::uint64_t states_ = 0;
  std::uint64_t tracked_ = 0;
  std::optional<Time> last_tracked_;
  std::uint64_t states_since_tracked_ = 0;
  Duration longest_without_{};
  std::uint64_t losses_ = 0;
  std::uint64_t losses_said_ = 0;
  std::uint64_t way_points_ = 0;
  std::uint64_t way_points_done_ = 0;
  std::string way_points_text_;
  TruthPairing<Pose> pairing_;
  std::array<Measure, 6> axes_{};  // across, along, up, and the rotations about these
  Measure position_;
  Measure orientation_;
};

}  // namespace pipescout::summary
