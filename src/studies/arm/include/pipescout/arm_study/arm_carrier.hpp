// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <memory>

#include "pipescout/arm_study/arm_drive.hpp"
#include "pipescout/leak_study/sequence_run.hpp"
#include "pipescout/tracking/shape_tracker.hpp"

/// Leak inspection with the camera on the arm: the tracker tracks the tube in the images of the
/// inspection, and the arm follows the track.
namespace pipescout::arm_study {

struct CarrierSettings {
  tracking::PipeShape shape{};
  tracking::PipeTrackerParameters tracker{};
  /// m, [1, 1000]: range of the pipes along the camera's axis, for the tracker.
  double distance = 10;
  manipulation::ArmControllerParameters controller{};
  /// Only latency of the track, odometry and arm are used; ground, robot and tube are those of the
  /// patrol.
  DriveSettings drive{};

  /// Throws std::invalid_argument naming the field, the value and the range.
  void validate() const;
};

/// For one sequence. The same arguments and calls give the same bits.
class ArmCarrier final : public leak_study::CameraCarrier {
 public:
  /// Throws as CarrierSettings::validate and ArmController.
  ArmCarrier(const CarrierSettings& settings, const geometry::Camera& camera, std::uint64_t seed);
  ~ArmCarrier() override;

  void step(simulation::ThermalPatrol& patrol) override;
  [[nodiscard]] geometry::SE3 T_base_camera() const override;
  void see(const leak_findings::Frame& frame, const thermal::Detections& detections) override;

 private:
  class Implementation;
  std::unique_ptr<Implementation> implementation_;
};

}  // namespace pipescout::arm_study
