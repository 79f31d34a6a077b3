// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <vector>

/// Bends, T pieces and vertical runs of a pipe as the wheels of a crawler meet them: each wheel
/// rolls on the wall along a line of its own. Metres and radians; positions are distances along the
/// axis from the start of the drive. An angle around the axis counts from the top, clockwise for
/// one who looks forward: 3 o'clock is pi / 2.
namespace pipescout::simulation {

/// An arc of the axis.
struct PipeBend {
  double begin = 0.0;
  double radius = 1.0;     ///< > 0, of the axis
  double angle = 0.0;      ///< (0, 2 pi]
  double direction = 0.0;  ///< around the axis: where the centre of the arc is

  [[nodiscard]] double length() const noexcept { return radius * angle; }
  [[nodiscard]] double end() const noexcept { return begin + length(); }
};

/// An opening in the wall. A wheel above it has nothing to roll on and stands still.
struct PipeTee {
  double position = 0.0;   ///< of its middle
  double radius = 0.1;     ///< (0, radius of the pipe], of the opening
  double direction = 0.0;  ///< around the axis: where it is
};

/// A straight run that is not level.
struct PipeRise {
  double begin = 0.0;
  double length = 0.0;  ///< > 0
  double pitch = 0.0;   ///< [-pi/2, pi/2], upwards
};

struct PipeFittings {
  double radius = 0.5;            ///< > 0, inner, of the pipe
  std::vector<PipeBend> bends{};  ///< in order, apart from each other
  std::vector<PipeTee> tees{};    ///< in order
  std::vector<PipeRise> rises{};  ///< in order, apart from each other

  /// Throws std::invalid_argument naming the field, the value and the range.
  void validate() const;
};

/// A line on the wall: its angle around the axis at distance 0, and how fast the angle grows along
/// the axis, as the crawler rolls.
struct WallLine {
  double angle = 0.0;
  double turn_per_metre = 0.0;
};

/// Length of the line on the wall from `from` to `to` >= `from`, less what lies over openings.
/// Through a bend of axis radius R, a line at the angle a from its direction is shorter by the
/// integral of r / R * cos(a). (The turn of the line itself, (r * turn)^2 / 2 per metre, is left
/// out: it is the same for all wheels.)
[[nodiscard]] double wall_distance(const PipeFittings& fittings, const WallLine& line, double from,
                                   double to) noexcept;

/// Pitch at a position on a rise; nothing elsewhere.
[[nodiscard]] std::optional<double> pitch_on_rise(const PipeFittings& fittings,
                                                  double position) noexcept;

}  // namespace pipescout::simulation
