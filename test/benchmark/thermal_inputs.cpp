// SPDX-License-Identifier: Apache-2.0
#include "thermal_inputs.hpp"

#include "pipescout/simulation/thermal_patrol.hpp"

namespace pipescout::benchmarks {
namespace {

constexpr double kFramePeriod = 0.04;  // s
constexpr std::size_t kShots = 40;
constexpr double kLeakPlace = 22.0;  // m

}  // namespace

thermal::CountView ThermalRecording::view(std::size_t shot) const {
  const int width = camera.parameters().width;
  return {shots[shot].counts.data(), width, camera.parameters().height, width};
}

leak_findings::Frame ThermalRecording::frame(std::size_t round, std::size_t shot) const {
  leak_findings::Frame frame;
  frame.number = round * shots.size() + shot;
  frame.time = kFramePeriod * static_cast<double>(frame.number);
  leak_findings::FramePose pose;
  pose.T_map_base = shots[shot].T_map_camera;
  pose.covariance.diagonal() << 0.01, 0.01, 0.01, 8e-5, 8e-5, 8e-5;
  frame.pose = pose;
  return frame;
}

ThermalRecording thermal_recording(bool large, std::uint64_t seed) {
  simulation::ThermalPatrolParameters p;
  p.camera = large ? simulation::ThermalCameraParameters::vga()
                   : simulation::ThermalCameraParameters::qvga();
  p.scene.length = 60;
  p.scene.leaks.push_back({kLeakPlace, 0.5, 120, 0.05});
  p.scene.seed = p.camera.seed = p.seed = seed;
  p.end = 50;
  simulation::ThermalPatrol patrol(p);
  ThermalRecording recording;
  recording.camera = patrol.renderer().camera();
  recording.table =
      thermal::TemperatureTable(thermal::Radiometry(p.camera.constants, p.scene.object));
  double time = 0;
  while (patrol.place() < kLeakPlace - 4) {
    time += kFramePeriod;
    patrol.drive_until(time);
  }
  for (std::size_t i = 0; i < kShots; ++i) {
    time += kFramePeriod;
    patrol.drive_until(time);
    ThermalRecording::Shot shot;
    shot.T_map_camera = patrol.view(i).T_map_camera;
    shot.counts.resize(static_cast<std::size_t>(p.camera.camera.width) *
                       static_cast<std::size_t>(p.camera.camera.height));
    patrol.render(i, shot.counts);
    recording.shots.push_back(std::move(shot));
  }
  return recording;
}

thermal::LeakDetectorParameters thermal_detector_parameters() {
  thermal::LeakDetectorParameters p;
  p.pipe_diameter = 0.12;
  return p;
}

leak_findings::LeakFindingsParameters thermal_findings_parameters() {
  leak_findings::LeakFindingsParameters p;
  p.range_source = leak_findings::RangeSource::kDiameter;
  p.pipe_diameter = 0.12;
  return p;
}

}  // namespace pipescout::benchmarks
