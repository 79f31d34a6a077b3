// SPDX-License-Identifier: Apache-2.0
#include "pipescout/arm_study/arm_carrier.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <stdexcept>

namespace pipescout::arm_study {
namespace {

/// One row with a leak, along which the ground rises by a metre and a half.
leak_study::SequencePlan uphill() {
  const leak_study::CampaignSettings settings{
      .sequences = 1, .faint_leaks = 0, .other_leaks = 1, .decoys = 0, .length = 60};
  leak_study::SequencePlan plan = leak_study::plan_campaign(settings, 1).front();
  const Eigen::Vector3d along = plan.patrol.scene.T_map_row.rotation() * Eigen::Vector3d::UnitX();
  plan.patrol.terrain.slope = 0.05 * along.head<2>();
  plan.patrol.scene.T_map_row = {plan.patrol.scene.T_map_row.rotation(), Eigen::Vector3d::Zero()};
  return plan;
}

TEST(ArmCarrier, KeepsTheTubeInViewWhereAFixedCameraLosesIt) {
  const leak_study::SequencePlan plan = uphill();
  const auto fixed = leak_study::run_sequence(plan, {}, 1);
  ArmCarrier carrier({.distance = plan.patrol.distance},
                     geometry::Camera(plan.patrol.camera.camera), 1);
  const auto on_arm = leak_study::run_sequence(plan, {}, 1, &carrier);
  EXPECT_LT(fixed.metres_seen, 0.8 * fixed.metres);
  EXPECT_GT(on_arm.metres_seen, 0.95 * on_arm.metres);
  ASSERT_EQ(on_arm.found.size(), 1U);
  EXPECT_TRUE(on_arm.found[0]);
}

TEST(ArmCarrier, NamesWhatIsWrong) {
  const geometry::Camera camera(simulation::ThermalCameraParameters::qvga().camera);
  EXPECT_THROW(ArmCarrier({.distance = NAN}, camera, 1), std::invalid_argument);
  CarrierSettings settings;
  settings.drive.track.latency = -1;
  EXPECT_THROW(ArmCarrier(settings, camera, 1), std::invalid_argument);
}

}  // namespace
}  // namespace pipescout::arm_study
