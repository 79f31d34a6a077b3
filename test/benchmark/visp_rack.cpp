// SPDX-License-Identifier: Apache-2.0
#include "visp_rack.hpp"

#include <sstream>
#include <stdexcept>

namespace pipescout::benchmarks {

std::string rack_cao(const rack_vision::RackModel& model) {
  std::ostringstream points;
  std::ostringstream cylinders;
  points.precision(17);
  cylinders.precision(17);
  std::size_t count = 0;
  for (const rack_vision::Pipe& pipe : model.pipes) {
    const double radius = pipe.radii.front().radius;
    for (const rack_vision::RadiusAt& at : pipe.radii) {
      if (at.radius != radius) {
        throw std::invalid_argument("pipe '" + pipe.name + "' is no cylinder");
      }
    }
    const Eigen::Vector3d end = pipe.start + pipe.length() * pipe.direction;
    for (const Eigen::Vector3d& point : {pipe.start, end}) {
      points << point.x() << ' ' << point.y() << ' ' << point.z() << '\n';
    }
    cylinders << count << ' ' << count + 1 << ' ' << radius << '\n';
    count += 2;
  }
  // Version; points; segments, faces of segments and faces of points (none); cylinders by the ends
  // of their axis; circles (none).
  return "V1\n" + std::to_string(count) + "\n" + points.str() + "0\n0\n0\n" +
         std::to_string(model.pipes.size()) + "\n" + cylinders.str() + "0\n";
}

VispCamera visp_camera(const geometry::Camera& camera) {
  const geometry::CameraParameters& p = camera.parameters();
  if (camera.has_distortion() || p.skew != 0.0) {
    throw std::invalid_argument("the camera has skew or distortion");
  }
  return {.width = static_cast<unsigned int>(p.width),
          .height = static_cast<unsigned int>(p.height),
          .focal_length_u = p.focal_length,
          .focal_length_v = p.aspect_ratio * p.focal_length,
          .centre_u = p.centre_u,
          .centre_v = p.centre_v};
}

}  // namespace pipescout::benchmarks
