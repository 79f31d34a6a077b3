// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <limits>
#include <optional>
#include <vector>

/// Conversion of chainages to map positions by the centre line of a pipe through surveyed points.
/// Distances and standard deviations in metres, angles in degrees as map formats have them.
namespace pipescout::odometry {

enum class MapFrame : std::uint8_t {
  kNone,      ///< no map
  kGeodetic,  ///< WGS 84: latitude and longitude in degrees, ellipsoidal height in m
  kLocal,     ///< x, y, z in m, any Cartesian frame
};

struct MapPosition {
  /// latitude, longitude, height or x, y, z: see `MapFrame`.
  std::array<double, 3> coordinates{std::numeric_limits<double>::quiet_NaN(),
                                    std::numeric_limits<double>::quiet_NaN(),
                                    std::numeric_limits<double>::quiet_NaN()};
  double standard_deviation = std::numeric_limits<double>::quiet_NaN();  ///< m, per axis

  friend bool operator==(const MapPosition&, const MapPosition&) = default;
};

/// Distance of two positions, m. Geodetic: along the ellipsoid by the radii of curvature half way,
/// within 1e-5 of the truth over 10 km and less than 80 degrees of latitude.
/// Not checked: values in range; both in `frame`, which is not kNone.
[[nodiscard]] double map_distance(MapFrame frame, const std::array<double, 3>& a,
                                  const std::array<double, 3>& b) noexcept;

/// The point at the fraction t from a to b, along the shorter arc.
[[nodiscard]] std::array<double, 3> map_between(MapFrame frame, const std::array<double, 3>& a,
                                                const std::array<double, 3>& b, double t) noexcept;

struct SurveyedPoint {
  MapPosition position;
  /// m, chainage of a surveyed feature, such as a valve or a marker, if known.
  std::optional<double> chainage{};
};

struct CentreLineParameters {
  /// m / sqrt(m), random walk of the pipe between surveyed points; in [0, 10]
  double wander = 0.02;
  double chainage_noise = 0.02;  ///< m / sqrt(m), of chainages between known ones; in [0, 10]

  /// Throws std::invalid_argument naming the field, the value and the range.
  void validate() const;
};

/// A polyline through surveyed points with its cumulative length. Chainages are interpolated
/// linearly between the points with known chainage, and continue with scale 1 beyond them. If none
/// is known, the first point has chainage 0.
class CentreLine {
 public:
  /// Throws std::invalid_argument when there are fewer than 2 points, two neighbours coincide, a
  /// value is not finite or out of range, or known chainages do not increase.
  CentreLine(MapFrame frame, std::vector<SurveyedPoint> points,
             CentreLineParameters parameters = {});

  /// Nothing beyond the ends of the line and for a chainage that is not finite. The uncertainty
  /// combines those of the two surveyed points, of the path of the pipe between them, and of the
  /// chainage, whose standard deviation is reduced between points of known chainage.
  [[nodiscard]] std::optional<MapPosition> at(double chainage,
                                              double standard_deviation) const noexcept;

  [[nodiscard]] MapFrame frame() const noexcept { return frame_; }
  [[nodiscard]] double length() const noexcept { return lengths_.back(); }

 private:
  MapFrame frame_;
  std::vector<SurveyedPoint> points_;
  CentreLineParameters parameters_;
  std::vector<double> lengths_;         // m, from the first point
  std::vector<std::size_t> anchors_{};  // points of known chainage
};

}  // namespace pipescout::odometry
