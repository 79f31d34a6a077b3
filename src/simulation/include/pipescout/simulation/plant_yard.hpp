// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <vector>

/// The ground of a plant: rows of collectors with aisles between them, roads around, a wall, things
/// that no map shows, and people and vehicles that move; and a lidar in it. Frame of the map, SI
/// units, radians.
namespace pipescout::simulation {

/// A rectangle that stands or moves on the ground, around its centre.
struct YardBox {
  Eigen::Vector2d centre = Eigen::Vector2d::Zero();
  double heading = 0;
  double half_length = 0.5;
  double half_width = 0.5;
};

/// A person (a square box) or a vehicle that goes to and fro between two points. It halts while
/// something that it would hit stands or drives before it, and turns back after a while.
struct YardMover {
  YardBox box;
  Eigen::Vector2d from = Eigen::Vector2d::Zero();
  Eigen::Vector2d to = Eigen::Vector2d::Zero();
  double speed = 1;    ///< m/s
  double sight = 1.2;  ///< m, how far ahead it looks for the robot
  double halted = 0;   ///< s
};

struct PlantYardParameters {
  int rows = 4;            ///< [2, 20]
  double row_length = 40;  ///< m, [10, 200]
  double aisle = 5;        ///< m, [2.5, 20]: free width between two rows
  double row_width = 1.5;  ///< m, [0.5, 10]
  double road = 7;         ///< m, [4, 20]: width at the ends of the rows
  int people = 4;          ///< [0, 50]
  int vehicles = 1;        ///< [0, 20]
  int unmapped = 3;        ///< [0, 50]: boxes at the edges of aisles

  void validate() const;
};

struct LidarParameters {
  int beams = 360;            ///< [8, 10000]: over the whole turn
  double largest_range = 20;  ///< m, (0, 200]
  double noise = 0.02;        ///< m, [0, 1]: standard deviation
  double dropouts = 0.01;     ///< [0, 1]: share of the beams without an echo

  /// Throws std::invalid_argument that names the field.
  void validate() const;
};

class PlantYard {
 public:
  /// Draws the movers and the unmapped boxes. Rows lie along x: row i is at
  /// y = i * (aisle + row_width), x from 0 to row_length; aisle i lies above row i.
  PlantYard(const PlantYardParameters& parameters, std::uint64_t seed);

  [[nodiscard]] const PlantYardParameters& parameters() const { return parameters_; }
  /// y of the middle of aisle `i`.
  [[nodiscard]] double aisle_middle(int i) const;
  [[nodiscard]] const std::vector<YardBox>& mapped() const { return mapped_; }
  [[nodiscard]] const std::vector<YardBox>& unmapped() const { return unmapped_; }
  [[nodiscard]] const std::vector<YardMover>& movers() const { return movers_; }
  /// Without them from now on: where they would stand in what is to be tested.
  void remove_movers() { movers_.clear(); }
  void add_unmapped(const YardBox& box) { unmapped_.push_back(box); }
  void add_mover(const YardMover& mover) { movers_.push_back(mover); }

  /// Moves what moves by `dt` s; `robot` is what it halts for.
  void step(double dt, const YardBox& robot);
  /// Whether the robot overlaps anything.
  [[nodiscard]] bool collides(const YardBox& robot) const;
  /// m, to the nearest thing; 0 when it overlaps.
  [[nodiscard]] double clearance(const YardBox& robot) const;
  /// Ranges of a scan from `position`, beam 0 in direction `heading` - pi; infinite without echo.
  /// Throws std::invalid_argument for parameters outside their ranges.
  void scan(const LidarParameters& lidar, const Eigen::Vector2d& position, double heading,
            std::uint64_t seed, std::vector<float>& ranges) const;

 private:
  template <class Function>
  void for_each(Function function) const;

  PlantYardParameters parameters_;
  std::vector<YardBox> mapped_;
  std::vector<YardBox> unmapped_;
  std::vector<YardMover> movers_;
};

/// m, between two boxes; 0 when they overlap (separating axes; distance of corners to edges).
[[nodiscard]] double box_distance(const YardBox& a, const YardBox& b);

}  // namespace pipescout::simulation
