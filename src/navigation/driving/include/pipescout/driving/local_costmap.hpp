// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "pipescout/navigation_maps/pose2d.hpp"

namespace pipescout::navigation {

/// A scan as sensor_msgs/LaserScan has it, of a lidar that looks all around or to one side.
struct ScanView {
  double time = 0;       ///< s
  double angle_min = 0;  ///< rad, of the first beam, in the frame of the lidar
  double angle_increment = 0;
  double range_min = 0;  ///< m; nearer ones do not count
  double range_max = 0;  ///< m; from there on, and infinity, there is no echo
  std::span<const float> ranges;
};

struct LocalCostmapParameters {
  double resolution = 0.1;   ///< m, [0.02, 1]
  int size = 240;            ///< cells, [20, 2000]: of each edge
  double forget_after = 20;  ///< s, (0, 3600]: cells that nothing sees again
  /// Scans, [1, 100], in which beams without an echo pass an occupied cell until it counts as
  /// free: dark and wet things give no echo at times.
  int clearing_scans = 3;

  void validate() const;
};

/// Occupied and free cells around the robot, from scans. It rolls along with the robot: its cells
/// stay where they are in the map, those that leave it are forgotten.
class LocalCostmap {
 public:
  enum class State : std::uint8_t { kUnknown, kFree, kOccupied };

  /// Throws std::invalid_argument.
  explicit LocalCostmap(const LocalCostmapParameters& parameters);

  void clear();
  /// Beams make the cells they pass free, and those of their echoes occupied (Moravec and Elfes,
  /// 1985, with certain cells: the lidar's noise is less than a cell). Beams without an echo make
  /// occupied cells free after `clearing_scans`, and no unknown ones. Allocates nothing.
  void add(const ScanView& scan, const Pose2d& T_map_lidar);

  [[nodiscard]] const LocalCostmapParameters& parameters() const { return parameters_; }
  /// Corner of the lowest cell in the map; nothing before the first scan.
  [[nodiscard]] std::optional<Point2d> origin() const;
  /// Of a column and a row, counted from the origin; kUnknown outside.
  [[nodiscard]] State at(int column, int row) const;
  /// Centres of the occupied cells within `radius` of a point are appended up to the vector's
  /// capacity; false when there were more.
  bool occupied_near(const Point2d& centre, double radius, double now,
                     std::vector<Point2d>& cells) const;

 private:
  struct CellValue {
    State state = State::kUnknown;
    std::uint8_t missed = 0;  ///< scans without an echo there
    double seen = 0;          ///< s
    double missed_at = 0;     ///< s
  };

  [[nodiscard]] CellValue& cell(long column, long row);
  [[nodiscard]] const CellValue& cell(long column, long row) const;
  [[nodiscard]] bool covers(long column, long row) const;
  void roll_to(const Point2d& centre);
  void miss(CellValue& cell, double time) const;

  LocalCostmapParameters parameters_;
  std::vector<CellValue> cells_;  ///< cell (c, r) of the map is at (c mod size, r mod size)
  bool placed_ = false;
  long first_column_ = 0;
  long first_row_ = 0;
};

}  // namespace pipescout::navigation
