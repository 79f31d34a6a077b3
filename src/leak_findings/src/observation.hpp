// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstddef>
#include <optional>
#include <vector>

#include "pipescout/leak_findings/leak_findings.hpp"
#include "place_estimate.hpp"

namespace pipescout::leak_findings {

/// Where the camera was; only made of poses that are sound.
struct Eye {
  geometry::SE3 T_map_camera{};
  Eigen::Vector3d base = Eigen::Vector3d::Zero();
  geometry::Matrix6d covariance = geometry::Matrix6d::Zero();
};

/// One leak in one frame: a detection, or several of one pipe with little in between.
struct Observation {
  std::size_t first_detection = 0;
  std::size_t last_detection = 0;
  std::size_t pipe = 0;
  Eigen::Vector2d start = Eigen::Vector2d::Zero();  ///< pixels
  Eigen::Vector2d end = Eigen::Vector2d::Zero();
  /// Of start and end: whether it is seen, neither hidden nor beyond the border.
  std::array<bool, 2> seen{};
  double across = 0;  ///< pixels, as `thermal::LeakDetection::across`
  double half_width = 0;
  double width = 0;            ///< pixels, `PipeSection::best_width`
  double width_deviation = 0;  ///< pixels, standard, as far as the picture tells
  double delta = 0;
  double peak_delta = 0;
  double delta_deviation = 0;  ///< K, standard, alike in all frames
  /// K, how far the 95 % interval reaches below and above, alike in all frames
  std::array<double, 2> delta_margins{};
  std::array<double, 2> peak_delta_margins{};
  std::optional<Bearing> bearing{};  ///< of the middle of what is seen, when there is an eye
  std::array<std::optional<Bearing>, 2> ends{};  ///< of those that are seen, likewise
  /// Pixels, where the rise begins at either end; NaN where that is not seen.
  std::array<Eigen::Vector2d, 2> onset{};
  std::array<std::optional<Bearing>, 2> onsets{};        ///< of those that are seen
  Eigen::Vector3d direction = Eigen::Vector3d::UnitX();  ///< of the pipe in the map, likewise; from
                                                         ///< start to end
  double angle = 0;                                      ///< rad, between start and end, likewise
  std::optional<RangePrior> range{};
  int line = -1;  ///< of `LeakFindingsParameters::lines`, that the range is from

  [[nodiscard]] bool whole() const { return seen[0] && seen[1]; }
  [[nodiscard]] Eigen::Vector2d centre() const { return 0.5 * (start + end); }
  [[nodiscard]] double pixels() const { return (end - start).norm(); }
};

/// Makes the observations of a frame; memory is kept.
class Observer {
 public:
  Observer(const LeakFindingsParameters& parameters, const geometry::Camera& camera)
      : parameters_(parameters), camera_(camera) {}

  /// Returns how many were left out, since they are on none of the known lines.
  std::size_t observe(double time, const std::optional<Eye>& eye,
                      const thermal::Detections& detections,
                      std::vector<Observation>& observations) const;

 private:
  [[nodiscard]] double metres_per_pixel(const thermal::PipeSection& pipe) const;
  void collect(const thermal::Detections& detections, std::vector<Observation>& observations) const;
  /// Of what is `across` pixels beside the axis. False where the camera cannot tell.
  bool add_bearings(double time, const Eye& eye, double across, Observation& observation) const;
  void add_range(const Eye& eye, Observation& observation) const;
  void add_range_of_line(Observation& observation) const;
  /// Where it is on a line with a radius: the bearings and the range become those of the warmth.
  void put_on_surface(double time, const Eye& eye, Observation& observation) const;

  const LeakFindingsParameters& parameters_;
  const geometry::Camera& camera_;
};

}  // namespace pipescout::leak_findings
