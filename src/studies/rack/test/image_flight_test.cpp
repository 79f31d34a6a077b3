// SPDX-License-Identifier: Apache-2.0
#include "pipescout/rack_study/image_flight.hpp"

#include <gmock/gmock.h>

#include <cstdint>
#include <numbers>
#include <random>
#include <span>
#include <stdexcept>
#include <vector>

#include "pipescout/rack_study/image_score.hpp"
#include "pipescout/rack_study/image_trials.hpp"
#include "pipescout/rack_vision/rack_localization.hpp"
#include "pipescout/rack_vision/visual_servo.hpp"
#include "pipescout/simulation/rack_image.hpp"
#include "pipescout/simulation/rack_image_light.hpp"

namespace pipescout::rack_study {
namespace {

ImageFlightSettings inspection(double duration, std::uint64_t seed) {
  ImageFlightSettings settings;
  settings.scene.model = rack_on_beams();
  settings.way_points = inspection_way_points(duration, seed);
  settings.flight.duration = duration;
  return settings;
}

TEST(ImageFlight, KeepsThePoseToAFewMillimetres) {
  const auto run = run_image_flight(inspection(2, 1), 1);
  ASSERT_EQ(run.frames.size(), 50U);
  const auto score = score_flight(run.frames);
  EXPECT_EQ(score.with_pose, 50U);
  EXPECT_EQ(score.wrong, 0U);
  EXPECT_LT(run.frames.back().position_error(), 0.015);
  EXPECT_LT(run.frames.back().rotation_error(), 0.0035);
  EXPECT_EQ(run.tracker.losses, 0U);
}

TEST(ImageFlight, SameSeedSameBits) {
  const auto settings = inspection(0.4, 2);
  const auto once = run_image_flight(settings, 2);
  const auto twice = run_image_flight(settings, 2);
  const auto other = run_image_flight(settings, 3);
  ASSERT_EQ(once.frames.size(), twice.frames.size());
  for (std::size_t i = 0; i < once.frames.size(); ++i) {
    EXPECT_EQ(once.frames[i].error, twice.frames[i].error);
    EXPECT_EQ(once.frames[i].pose_nees, twice.frames[i].pose_nees);
  }
  EXPECT_NE(once.frames.back().error, other.frames.back().error);
}

class Outages : public ::testing::TestWithParam<Outage> {};

TEST_P(Outages, GiveNoWrongPose) {
  auto settings = inspection(1.4, 4);
  settings.with_odometry = true;
  settings.loss = ForcedLoss{.kind = GetParam(), .begin = 0.4, .duration = 0.6};
  const auto run = run_image_flight(settings, 4);
  std::size_t outages = 0;
  for (const auto& frame : run.frames) {
    outages += frame.outage ? 1 : 0;
  }
  EXPECT_EQ(outages, 15U);
  const auto recovery = score_recovery(run.frames);
  EXPECT_TRUE(recovery.declared);
  EXPECT_FALSE(recovery.wrong);
}

INSTANTIATE_TEST_SUITE_P(ImageFlight, Outages,
                         ::testing::Values(Outage::kCovered, Outage::kFrozen, Outage::kMissing));

TEST(ImageFlight, ClutterComesWhenItIsDue) {
  auto settings = inspection(0.48, 5);
  const auto clear = run_image_flight(settings, 5);
  settings.scene.clutter_share = 0.4;
  settings.clutter_begin = 0.24;
  const auto run = run_image_flight(settings, 5);
  ASSERT_EQ(run.frames.size(), 12U);
  for (std::size_t i = 0; i < run.frames.size(); ++i) {
    EXPECT_EQ(run.frames[i].error == clear.frames[i].error, i < 6) << i;
    EXPECT_TRUE(run.frames[i].has_pose) << i;
  }
  EXPECT_EQ(clear.cluttered_share, 0);
  EXPECT_NEAR(run.cluttered_share, 0.4, 0.1);
}

// What lies over the pipes by then lines up as well as they do: texture tells where the camera is.
TEST(ImageFlight, ComesBackUnderClutterByTheTextureItHadSeen) {
  auto settings = inspection(2.4, 5);
  settings.scene.clutter_share = 0.4;
  settings.clutter_begin = 1.0;
  settings.loss = ForcedLoss{.kind = Outage::kMissing, .begin = 1.6, .duration = 0.4};
  const auto run = run_image_flight(settings, 5);
  EXPECT_EQ(score_flight(run.frames).wrong, 0U);
  for (const auto& frame : run.frames) {
    EXPECT_EQ(frame.has_pose, !frame.outage) << frame.time;
  }
}

TEST(ImageFlight, RefusesWhatIsNotValid) {
  auto settings = inspection(1, 1);
  settings.scene.clutter_share = 2;
  EXPECT_THROW(static_cast<void>(run_image_flight(settings, 1)), std::invalid_argument);
  settings = inspection(1, 1);
  settings.way_points.clear();
  EXPECT_THROW(static_cast<void>(run_image_flight(settings, 1)), std::invalid_argument);
}

TEST(WrongStarts, ShareTheirImagesAndAreRepeatable) {
  WrongStartSettings settings;
  settings.scene.model = rack_on_beams();
  settings.images = 4;
  const auto once = try_wrong_starts(settings, 3, 1);
  const auto twice = try_wrong_starts(settings, 3, 1);
  ASSERT_EQ(once.size(), 6U);
  for (std::size_t i = 0; i < once.size(); ++i) {
    EXPECT_NEAR(once[i].start_error.head<3>().norm(), settings.position_error, 1e-12);
    EXPECT_NEAR(once[i].start_error.tail<3>().norm(), settings.rotation_error, 1e-12);
    EXPECT_EQ(once[i].last.error, twice[i].last.error);
    EXPECT_EQ(once[i].last.status, twice[i].last.status);
    EXPECT_EQ(once[i].last.time, once[0].last.time);
  }
}

TEST(WrongStarts, SmallOnesConverge) {
  WrongStartSettings settings;
  settings.scene.model = rack_on_beams();
  settings.position_error = 0.005;
  settings.rotation_error = 0.003;
  const auto score = score_wrong_starts(try_wrong_starts(settings, 2, 1));
  EXPECT_EQ(score.trials, 4U);
  EXPECT_EQ(score.converged, 4U);
}

/// Of each image over pipes that lie beside where the model has them, from a level pose that is a
/// few centimetres off: how far too high the pose is, m.
std::vector<double> height_errors(std::uint64_t seed, double duration) {
  using rack_vision::WayPoint;
  std::mt19937_64 engine(seed);
  const auto light = simulation::ChangingRackLight({}, engine());
  CameraFlightSettings flight;
  flight.duration = duration;
  flight.wind_at_20_feet = 4;
  const auto motions = fly_camera(
      std::vector<WayPoint>{
          {.position = {0.9, 4, 2.6}, .yaw = 0.5 * std::numbers::pi, .hold = 2},
          {.position = {1.1, 6, 2.6}, .yaw = 0.5 * std::numbers::pi + 0.2, .hold = 2}},
      flight, engine());
  const rack_vision::RackModel model = rack_on_beams();
  simulation::RackScene scene;
  scene.model = model;
  scene.model.pipes[1].start.x() += 0.012;
  scene.model.pipes[2].start.x() -= 0.008;
  scene.model.pipes[3].start.x() += 0.015;
  scene.seed = engine();
  const geometry::Camera camera;
  simulation::RackImageRenderer renderer(scene, camera);
  std::vector<std::uint8_t> grey(static_cast<std::size_t>(camera.parameters().width) *
                                 static_cast<std::size_t>(camera.parameters().height));

  rack_vision::RackLocalizationParameters parameters;
  parameters.tracker.offset_sigma = 0.02;
  rack_vision::RackLocalization localization(model, camera, parameters);
  const geometry::SE3 truth = motions.front().T_camera_rack.inverse();
  const geometry::SO3 R_body_camera = rack_vision::downward_camera().rotation();
  const double yaw = (truth.rotation() * R_body_camera.inverse()).roll_pitch_yaw()[2];
  geometry::Vector6d deviations;
  deviations << 0.03, 0.03, 0.03, 0.05, 0.05, 0.02;
  localization.set_pose({geometry::SO3::about_z(yaw) * R_body_camera,
                         truth.translation() + Eigen::Vector3d(0.03, -0.02, -0.03)},
                        deviations.cwiseAbs2().asDiagonal());
  std::vector<double> errors;
  for (std::uint32_t i = 0; i < motions.size(); ++i) {
    const CameraMotion& motion = motions[i];
    renderer.render(view_of(motion, light, i), grey);
    const auto result = localization.track({.pixels = grey.data(),
                                            .width = camera.parameters().width,
                                            .height = camera.parameters().height,
                                            .stride = camera.parameters().width},
                                           motion.time, std::nullopt);
    EXPECT_EQ(result.status, rack_vision::TrackStatus::kTracking) << seed << ": " << i;
    errors.push_back(result.T_rack_camera.translation().z() -
                     motion.T_camera_rack.inverse().translation().z());
  }
  return errors;
}

/// The end of a beam beside a gutter or a stripe, which is 6 px farther out: the camera seemed 1 %
/// nearer, 3 cm.
TEST(WrongStarts, TheEndOfABeamIsNotTakenForWhatIsBesideIt) {
  for (const std::uint64_t seed : {63U, 110U}) {
    EXPECT_NEAR(height_errors(seed, 0.04).front(), 0, 0.01) << seed;
  }
}

/// Stripes and shadows are taken for contours there, and the camera seems 2 cm nearer. Images that
/// follow show it, but the offsets are believed by then.
TEST(WrongStarts, AreForgottenOnceImagesAreExplainedBetterWithoutThem) {
  const std::vector<double> errors = height_errors(38, 6);
  EXPECT_LT(errors.front(), -0.02) << "another seed would test more";
  for (const double error : std::span(errors).last(10)) {
    EXPECT_NEAR(error, 0, 0.01);
  }
}

TEST(WrongStarts, AtTheEdgeOfTheRackAreNotTakenForThePlaceBeside) {
  // The pipe that defines the frame is out of view there, and 4 cm aside contours of other pipes
  // line up too.
  constexpr std::uint64_t kPlace = 259;
  WrongStartSettings settings;
  settings.scene.model = rack_on_beams();
  const auto score = score_wrong_starts(try_wrong_starts(settings, 5, kPlace));
  EXPECT_EQ(score.silent_wrong, 0U);
  EXPECT_GE(score.converged, 9U);
}

}  // namespace
}  // namespace pipescout::rack_study
