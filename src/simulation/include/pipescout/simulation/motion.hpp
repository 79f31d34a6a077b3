// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

/// Motion of a crawler along a pipe: speed changes with constant acceleration, so distance, path
/// and speed are exact at any time. Metres and seconds; time and distance count from 0 at the
/// start.
namespace pipescout::simulation {

/// Drives at a speed (negative: back, 0: stands), reached at the acceleration of the motion, for a
/// duration that includes the change of speed.
struct MotionLeg {
  double speed = 0.0;     ///< m/s
  double duration = 0.0;  ///< s, > 0
};

/// A segment of constant acceleration without a change of direction.
struct MotionPiece {
  double begin = 0.0;         ///< s
  double duration = 0.0;      ///< s
  double distance = 0.0;      ///< m, at its begin
  double path = 0.0;          ///< m, at its begin
  double speed = 0.0;         ///< m/s, at its begin
  double acceleration = 0.0;  ///< m/s^2
};

class Motion {
 public:
  /// Starts from rest. Throws std::invalid_argument naming the field, the value and the range when
  /// there are no legs, a duration is not positive, a speed not finite or `acceleration`, m/s^2,
  /// not positive.
  Motion(const std::vector<MotionLeg>& legs, double acceleration);

  [[nodiscard]] double duration() const noexcept { return duration_; }
  [[nodiscard]] const std::vector<MotionPiece>& pieces() const noexcept { return pieces_; }
  /// Integral of the speed; beyond the end the final speed continues.
  [[nodiscard]] double distance(double time) const noexcept;
  /// Integral of the magnitude of the speed.
  [[nodiscard]] double path(double time) const noexcept;
  [[nodiscard]] double speed(double time) const noexcept;
  /// Index of the piece at a time.
  [[nodiscard]] std::size_t piece_at(double time) const noexcept;

 private:
  void add(double duration, double acceleration);

  std::vector<MotionPiece> pieces_;
  double duration_ = 0.0;
};

struct InspectionParameters {
  double length = 1000.0;         ///< m, > 0: distance to travel
  double speed = 0.3;             ///< m/s, > 0
  double speed_spread = 0.1;      ///< [0, 0.5]: largest relative deviation of the speed of a leg
  double acceleration = 0.2;      ///< m/s^2, > 0
  double stop_spacing = 100.0;    ///< m, > 0: mean distance between stops
  double stop_duration = 20.0;    ///< s, > 0: mean
  double reverse_share = 0.2;     ///< [0, 0.9]: share of the stops after which it first reverses
  double reverse_distance = 3.0;  ///< m, > 0: mean

  /// Throws std::invalid_argument naming the field, the value and the range.
  void validate() const;
};

/// A drive through a pipe with stops and reversals at random. Throws what
/// `InspectionParameters::validate` throws.
[[nodiscard]] Motion draw_inspection(const InspectionParameters& parameters, std::uint64_t seed);

}  // namespace pipescout::simulation
