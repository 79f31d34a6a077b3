// SPDX-License-Identifier: Apache-2.0
// What is seen where: projection and radiometry, by closed forms.
#include "pipescout/simulation/thermal_camera.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <random>
#include <stdexcept>

#include "thermal_views.hpp"

namespace pipescout::simulation {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;
using test::bare_scene;
using test::level_view;
using test::perfect_camera;
using test::ThermalImage;

TEST(ThermalCamera, CountsOfTubeAndLeakMeanTheirTemperatures) {
  ThermalSceneParameters parameters = bare_scene();
  parameters.leaks = {{.place = 20.5, .length = 0.3, .rise = 75, .shoulder = 0.05},
                      {.place = 19, .length = 0.6, .rise = 400}};
  ThermalCameraParameters camera = perfect_camera();
  camera.highest = 300;
  for (const double emissivity : {0.02, 0.04, 0.3}) {
    parameters.object.emissivity = emissivity;
    ThermalRenderer renderer(ThermalScene(parameters), camera);
    const ThermalView view = level_view(20);
    const ThermalImage image(renderer, view);
    ThermalTruth truth;
    renderer.truth(view, truth);
    ASSERT_TRUE(truth.tube);
    ASSERT_EQ(truth.leaks.size(), 2U);
    // A count is less than 0.1 K of the tube.
    const thermal::Radiometry radiometry(camera.constants, parameters.object);
    const auto degrees = [&](const Vector2d& pixel) {
      return radiometry.temperature(image.at(pixel));
    };
    EXPECT_NEAR(degrees((truth.tube->from + truth.tube->to) / 2), 150, 0.1);
    const PipeInImage& faint = truth.leaks[0].stretch;
    EXPECT_NEAR(degrees((faint.from + faint.to) / 2), 225, 0.1);
    const PipeInImage& strong = truth.leaks[1].stretch;
    EXPECT_NEAR(degrees((strong.from + strong.to) / 2), 300, 0.1);
    EXPECT_EQ(image.at((strong.from + strong.to) / 2), renderer.highest_counts());
    // The wall is black and cold.
    EXPECT_NEAR(camera.constants.planck.temperature(image(5, 5)), -10, 0.02);
  }
}

TEST(ThermalCamera, AxisIsThatOfTheProjectedTube) {
  const ThermalScene scene(bare_scene());
  const ThermalRenderer renderer(scene, perfect_camera());
  std::mt19937_64 engine(3);
  const auto draw = [&engine](double low, double high) {
    return std::uniform_real_distribution<double>(low, high)(engine);
  };
  for (int i = 0; i < 300; ++i) {
    ThermalView view = level_view(draw(0, 40), draw(1, 4), draw(-3, 3));
    view.T_map_camera =
        view.T_map_camera *
        geometry::SE3(geometry::SO3::exp({draw(-0.1, 0.1), draw(-0.4, 0.4), 0}), Vector3d::Zero());
    ThermalTruth truth;
    renderer.truth(view, truth);
    if (!truth.tube) {
      continue;
    }
    const PipeInImage& tube = *truth.tube;
    EXPECT_LT(tube.from_place, tube.to_place);
    const auto pixel_of = [&](double place) {
      return *renderer.camera().project(view.T_map_camera.inverse() * scene.on_tube(place));
    };
    EXPECT_LT((pixel_of(tube.from_place) - tube.from).norm(), 1e-6);
    EXPECT_LT((pixel_of(tube.to_place) - tube.to).norm(), 1e-6);
    // It ends at the border or where the tube ends, and nowhere else.
    for (const auto& [pixel, place] :
         {std::pair(tube.from, tube.from_place), std::pair(tube.to, tube.to_place)}) {
      const double to_border = std::min({pixel.x(), pixel.y(), 319 - pixel.x(), 239 - pixel.y()});
      const double to_end = std::min(std::abs(place), std::abs(place - 40));
      EXPECT_LT(std::min(std::abs(to_border), to_end), 1e-6);
    }
  }
}

TEST(ThermalCamera, AxisAndWidthAreSeenWhereTheyAreSaidToBe) {
  const ThermalScene scene(bare_scene());
  ThermalRenderer renderer(scene, perfect_camera());
  for (const double roll : {0.0, 0.35, -0.7}) {
    const ThermalView view = level_view(20, 2.4, roll);
    ThermalTruth truth;
    renderer.truth(view, truth);
    ASSERT_TRUE(truth.tube);
    const Vector2d along = (truth.tube->to - truth.tube->from).normalized();
    const ThermalImage image(renderer, view);
    const double tube = renderer.counts(150);
    const double wall = image(2, 2);
    for (const int column : {100, 160, 220}) {
      double weight = 0;
      double moment = 0;
      for (int y = 0; y < 240; ++y) {
        const double share = (image(column, y) - wall) / (tube - wall);
        weight += share;
        moment += share * y;
      }
      const double axis =
          truth.tube->from.y() + (column - truth.tube->from.x()) * along.y() / along.x();
      EXPECT_NEAR(moment / weight, axis, 0.03) << roll;
      EXPECT_NEAR(weight * along.x(), truth.tube->width, 0.003 * truth.tube->width) << roll;
    }
  }
}

TEST(ThermalCamera, WidthIsThatOfTheTangentPlanes) {
  // Seen from 10 m, 0.6 m below: f (tan(a + b) - tan(a - b)), with a the elevation and b the half
  // angle of the cylinder.
  const ThermalScene scene(bare_scene());
  const ThermalRenderer renderer(scene, perfect_camera());
  ThermalTruth truth;
  renderer.truth(level_view(20, 2.4), truth);
  ASSERT_TRUE(truth.tube);
  const double elevation = std::atan(0.06);
  const double half = std::asin(0.06 / std::hypot(10, 0.6));
  const double focal_length = renderer.camera().parameters().focal_length;
  EXPECT_NEAR(truth.tube->width,
              focal_length * (std::tan(elevation + half) - std::tan(elevation - half)), 1e-3);
}

TEST(ThermalCamera, LeakIsAsLongAsItsPlaces) {
  ThermalSceneParameters parameters = bare_scene();
  parameters.leaks = {{.place = 20.3, .length = 0.3, .rise = 75, .shoulder = 0}};
  const ThermalScene scene(parameters);
  ThermalRenderer renderer(scene, perfect_camera());
  const ThermalView view = level_view(20);
  ThermalTruth truth;
  renderer.truth(view, truth);
  ASSERT_EQ(truth.leaks.size(), 1U);
  EXPECT_TRUE(truth.leaks[0].whole);
  const PipeInImage& stretch = truth.leaks[0].stretch;
  EXPECT_NEAR(stretch.from_place, 20.15, 1e-9);
  EXPECT_NEAR(stretch.to_place, 20.45, 1e-9);
  const double focal_length = renderer.camera().parameters().focal_length;
  EXPECT_NEAR((stretch.to - stretch.from).norm(), 0.3 * focal_length / 10, 1e-6);
  // Seen along the axis, by how much is hot.
  const ThermalImage image(renderer, view);
  const int row = static_cast<int>(std::lround(stretch.from.y()));
  const double sound = renderer.counts(150);
  const double hot = renderer.counts(225);
  double length = 0;
  double moment = 0;
  for (int x = 0; x < 320; ++x) {
    const double share = (image(x, row) - sound) / (hot - sound);
    length += share;
    moment += share * x;
  }
  EXPECT_NEAR(length, (stretch.to - stretch.from).norm(), 0.1);
  EXPECT_NEAR(moment / length, (stretch.from.x() + stretch.to.x()) / 2, 0.1);
  // At the border it is cut off.
  renderer.truth(level_view(20.3 + 2.2), truth);
  ASSERT_EQ(truth.leaks.size(), 1U);
  EXPECT_FALSE(truth.leaks[0].whole);
  renderer.truth(level_view(30), truth);
  EXPECT_TRUE(truth.leaks.empty());
}

TEST(ThermalCamera, TubeThatIsNotInViewIsNotThere) {
  const ThermalScene scene(bare_scene());
  ThermalRenderer renderer(scene, perfect_camera());
  ThermalTruth truth;
  ThermalView away = level_view(20);
  away.T_map_camera =
      away.T_map_camera * geometry::SE3(geometry::SO3::exp({0, 3.14, 0}), Vector3d::Zero());
  for (const ThermalView& view : {level_view(20, 6), level_view(-10), away}) {
    renderer.truth(view, truth);
    EXPECT_FALSE(truth.tube);
    EXPECT_TRUE(truth.leaks.empty());
    const ThermalImage image(renderer, view);
    const auto [coldest, warmest] = std::ranges::minmax(image.counts());
    EXPECT_LE(warmest - coldest, 1);
  }
}

TEST(ThermalCamera, DecoysAreWhereTheyBelong) {
  const ThermalView view = level_view(20);
  const auto image_with = [&](const ThermalDecoy& decoy) {
    ThermalSceneParameters parameters = bare_scene();
    parameters.decoys = {decoy};
    ThermalRenderer renderer(ThermalScene(parameters), perfect_camera());
    return ThermalImage(renderer, view);
  };
  const ThermalScene scene(bare_scene());
  ThermalRenderer renderer(scene, perfect_camera());
  const ThermalImage plain(renderer, view);
  const double hot = renderer.counts(250);
  const double pixels_a_metre = renderer.camera().parameters().focal_length / 10;
  const auto column = [&](double place) {
    return static_cast<int>(std::lround(159.5 + (place - 20) * pixels_a_metre));
  };
  constexpr int kTube = 120;  // rows
  constexpr int kBelow = 180;

  const ThermalImage pixels = image_with({.kind = ThermalDecoyKind::kHotPixels,
                                          .place = 20,
                                          .size = 2,
                                          .rise = 100,
                                          .reach = 10,
                                          .pixel = {0.25, 0.1}});
  EXPECT_NEAR(pixels(79, 23), hot, 1);
  EXPECT_NEAR(pixels(80, 24), hot, 1);
  EXPECT_EQ(pixels(81, 24), plain(81, 24));

  const ThermalImage support =
      image_with({.kind = ThermalDecoyKind::kWarmSupport, .place = 20.5, .size = 0.2, .rise = 100});
  EXPECT_NEAR(support(column(20.5), kTube), hot, 1);
  EXPECT_NEAR(support(column(20.5), kBelow), hot, 1);
  EXPECT_EQ(support(column(20.9), kTube), plain(column(20.9), kTube));

  const ThermalImage body = image_with({.kind = ThermalDecoyKind::kHotBody,
                                        .place = 20,
                                        .size = 1,
                                        .rise = 100,
                                        .behind = 2,
                                        .height = 2.5,
                                        .foot = 1});
  EXPECT_NEAR(body(column(20), kBelow), hot, 1);
  EXPECT_EQ(body(column(20), kTube), plain(column(20), kTube));

  // Half-way after a camera that is 1 m past its place.
  const ThermalImage reflection = image_with({.kind = ThermalDecoyKind::kSunGlint,
                                              .place = 19,
                                              .size = 0.3,
                                              .rise = 100,
                                              .reach = 3,
                                              .follow = 0.5});
  EXPECT_NEAR(reflection(column(19.5), kTube), hot, 1);
  EXPECT_EQ(reflection(column(19), kTube), plain(column(19), kTube));
  EXPECT_EQ(reflection(column(19.5), kBelow), plain(column(19.5), kBelow));
  const ThermalImage gone = image_with({.kind = ThermalDecoyKind::kSunGlint,
                                        .place = 19,
                                        .size = 0.3,
                                        .rise = 100,
                                        .reach = 1.9,
                                        .follow = 0.5});
  EXPECT_EQ(gone.counts(), plain.counts());
}

TEST(ThermalCamera, PostsHideTheTubeAndPipesHangFromItsEnds) {
  ThermalSceneParameters parameters = bare_scene();
  parameters.support_width = 0.14;
  parameters.swivel_joints = true;
  const ThermalScene scene(parameters);
  ThermalRenderer renderer(scene, perfect_camera());
  const double tube = renderer.counts(150);
  const ThermalImage post(renderer, level_view(scene.supports()[1]));
  EXPECT_LT(post(160, 120), tube - 1000);
  EXPECT_NEAR(post(100, 120), tube, 1);
  const ThermalImage end(renderer, level_view(0));
  EXPECT_NEAR(end(200, 120), tube, 1);
  EXPECT_LT(end(100, 120), tube - 1000);
  EXPECT_NEAR(end(160, 200), renderer.counts(142), 1);
}

TEST(ThermalCamera, RefusesWhatItCannotRender) {
  const ThermalScene scene(bare_scene());
  ThermalRenderer renderer(scene, perfect_camera());
  std::array<std::uint16_t, 4> small{};
  EXPECT_THROW(renderer.render(level_view(20), small), std::invalid_argument);
  std::vector<std::uint16_t> counts(320 * 240);
  ThermalView view = level_view(20);
  view.velocity[2] = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THROW(renderer.render(view, counts), std::invalid_argument);
  ThermalCameraParameters camera = perfect_camera();
  camera.camera.k1 = 0.1;
  EXPECT_THROW(ThermalRenderer(scene, camera), std::invalid_argument);
  camera = perfect_camera();
  camera.netd = -1;
  EXPECT_THROW(ThermalRenderer(scene, camera), std::invalid_argument);
  camera = perfect_camera();
  camera.constants.planck.r1 = 0;
  EXPECT_THROW(ThermalRenderer(scene, camera), std::invalid_argument);
}

TEST(ThermalGreys, AreEvenlyFromLowestToHighest) {
  const thermal::Radiometry radiometry(simulated_thermal_constants(),
                                       thermal::ibarguren2013_object());
  const ThermalGreys greys(radiometry, 100, 300);
  std::vector<std::uint16_t> counts;
  for (const double temperature : {50.0, 100.0, 151.0, 201.0, 300.0, 400.0}) {
    counts.push_back(static_cast<std::uint16_t>(std::lround(radiometry.counts(temperature))));
  }
  counts.push_back(0);  // below what is reflected
  std::vector<std::uint8_t> levels(counts.size());
  greys.convert(counts, levels);
  EXPECT_THAT(levels, ::testing::ElementsAre(0, 0, 65, 129, 255, 255, 0));
  EXPECT_THROW(greys.convert(counts, std::span(levels).first(2)), std::invalid_argument);
  EXPECT_THROW(ThermalGreys(radiometry, 300, 300), std::invalid_argument);
}

TEST(ThermalCamera, ItsRadiationIsWhatTheCameraIsCalibratedFor) {
  // Two sets of formulas: they agree on a black body, and on air but for how it is modelled.
  const thermal::ObjectParameters object = thermal::ibarguren2013_object();
  ThermalSceneParameters scene = bare_scene();
  scene.object = object;
  const ThermalRenderer renderer(ThermalScene(scene), perfect_camera());
  const thermal::Radiometry radiometry(perfect_camera().constants, object);
  for (const double temperature : {-40.0, 20.0, 150.0, 400.0}) {
    EXPECT_NEAR(radiometry.temperature(renderer.counts(temperature)), temperature, 0.2);
  }
}

TEST(ThermalAutomaticGain, FollowsTheSceneWithALag) {
  std::vector<std::uint16_t> counts(10000);
  std::vector<std::uint8_t> greys(counts.size());
  for (std::size_t i = 0; i < counts.size(); ++i) {
    counts[i] = static_cast<std::uint16_t>(5000 + i / 10);
  }
  ThermalAutomaticGain gain;
  gain.convert(counts, greys);
  EXPECT_EQ(greys.front(), 0);
  EXPECT_EQ(greys.back(), 255);
  const std::uint8_t before = greys[5000];
  std::fill(counts.begin() + 9000, counts.end(), std::uint16_t{9000});
  gain.convert(counts, greys);
  const std::uint8_t after = greys[5000];
  EXPECT_LT(after, before);
  for (int i = 0; i < 100; ++i) {
    gain.convert(counts, greys);
  }
  EXPECT_LT(greys[5000], after);
  EXPECT_THROW(gain.convert(counts, std::span(greys).first(3)), std::invalid_argument);
}

}  // namespace
}  // namespace pipescout::simulation
