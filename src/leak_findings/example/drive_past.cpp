// SPDX-License-Identifier: Apache-2.0
// Drives past a pipe 8 m to the left with a leak 20 m along it, and prints what the images add up
// to.
#include <cmath>
#include <iostream>

#include "pipescout/leak_findings/leak_findings.hpp"
using namespace pipescout;

int main() {
  const geometry::Camera camera(
      {.width = 320, .height = 240, .focal_length = 400, .centre_u = 159.5, .centre_v = 119.5});
  leak_findings::LeakFindingsParameters parameters;
  parameters.T_base_camera = geometry::SE3(geometry::SO3::from_roll_pitch_yaw({-1.5707963, 0, 0}),
                                           Eigen::Vector3d(0, 0, 1));
  parameters.range_source = leak_findings::RangeSource::kDistance;
  parameters.distance = 8;
  leak_findings::LeakFindings findings(parameters, camera);
  for (int i = 0; i < 100; ++i) {
    const double x = 16 + 0.08 * i;  // m, of the robot
    thermal::Detections seen;
    seen.width = 320;
    seen.height = 240;
    const double u = 159.5 + 400 * (20 - x) / 8;  // pixels, of the leak
    seen.pipes.push_back({.start = {0, 119.5}, .end = {319, 119.5}, .half_width = 4});
    seen.pipes[0].reference_temperature = 140;
    seen.profile.assign(seen.pipes[0].samples = 320, 140.0F);
    seen.leaks.push_back({.stretch = {}, .start = {u - 10, 119.5}, .end = {u + 10, 119.5}});
    seen.leaks[0].delta = seen.leaks[0].peak_delta = 80;
    leak_findings::Frame frame{.time = 0.1 * i, .number = static_cast<std::uint64_t>(i)};
    frame.pose = {.T_map_base = geometry::SE3(geometry::SO3(), Eigen::Vector3d(x, 0, 0)),
                  .covariance = 1e-4 * geometry::Matrix6d::Identity()};
    findings.update(frame, seen);
  }
  for (const leak_findings::Finding& found : findings.findings()) {
    std::cout << "leak at " << found.position->point.transpose() << " m in the map, probability "
              << found.probability << '\n';
  }
  return findings.findings().size() == 1 ? 0 : 1;
}
