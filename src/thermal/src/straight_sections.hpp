// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "medial_axis.hpp"

namespace pipescout::thermal {

/// A straight piece of a medial axis, as the sums that its line of least squares follows from, so
/// that pieces can be joined.
class Straight {
 public:
  void add(const Eigen::Vector2d& point, int chord_length, bool column);
  /// Takes in the points of another.
  void join(const Straight& other);
  /// Fits the line, and the ends on it.
  void fit();

  [[nodiscard]] int points() const noexcept { return points_; }
  [[nodiscard]] const Eigen::Vector2d& start() const noexcept { return start_; }
  [[nodiscard]] const Eigen::Vector2d& end() const noexcept { return end_; }
  [[nodiscard]] const Eigen::Vector2d& direction() const noexcept { return direction_; }
  [[nodiscard]] double length() const { return (end_ - start_).norm(); }
  [[nodiscard]] double half_width() const noexcept { return half_width_; }
  /// Root mean square distance of the points from the line.
  [[nodiscard]] double deviation() const noexcept { return deviation_; }
  /// How far a point lies from the line; the sign tells the side.
  [[nodiscard]] double offset(const Eigen::Vector2d& point) const {
    const Eigen::Vector2d d = point - start_;
    return direction_.x() * d.y() - direction_.y() * d.x();
  }
  [[nodiscard]] double along(const Eigen::Vector2d& point) const {
    return direction_.dot(point - start_);
  }

  bool cut = false;  ///< made of chords that end at the border

 private:
  int points_ = 0;
  Eigen::Vector2d origin_ = Eigen::Vector2d::Zero();  // sums are about it
  Eigen::Vector2d sum_ = Eigen::Vector2d::Zero();
  Eigen::Matrix2d squares_ = Eigen::Matrix2d::Zero();
  double column_lengths_ = 0;
  double row_lengths_ = 0;
  Eigen::Vector2d first_ = Eigen::Vector2d::Zero();  // the extreme points
  Eigen::Vector2d last_ = Eigen::Vector2d::Zero();
  Eigen::Vector2d start_ = Eigen::Vector2d::Zero();
  Eigen::Vector2d end_ = Eigen::Vector2d::Zero();
  Eigen::Vector2d direction_ = Eigen::Vector2d::UnitX();
  double half_width_ = 0;
  double deviation_ = 0;
};

/// From the points of a medial axis to its straight sections, longest first: chains of points that
/// follow each other, divided where they bend, joined where they go on behind a gap.
class StraightSections {
 public:
  struct Limits {
    double straightness = 2;
    double max_gap = 160;
    double min_length = 30;
    double min_elongation = 3;
    std::size_t max_sections = 16;
  };

  void find(const MedialAxis& axis, const Limits& limits);
  [[nodiscard]] std::span<const Straight> sections() const noexcept { return sections_; }

 private:
  struct Chain {
    int head = 0;
    int tail = 0;
    int count = 0;
    double middle = 0;
    double slope = 0;
  };

  void link(std::span<const Chord> chords);
  void divide(std::span<const Chord> chords, const Chain& chain, bool column, const Limits& limits);
  void join(const Limits& limits);
  void drop_remains(const Limits& limits);

  std::vector<int> next_;
  std::vector<Chain> active_;
  std::vector<Chain> finished_;
  std::vector<int> order_;
  std::vector<std::array<int, 2>> pending_;
  std::vector<Straight> sections_;
};

}  // namespace pipescout::thermal
