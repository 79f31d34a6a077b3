// SPDX-License-Identifier: Apache-2.0
#include "pipescout/rack_vision/edge_search.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <stdexcept>
#include <vector>

#include "drawn_rack.hpp"

namespace pipescout::rack_vision {
namespace {

constexpr int kWidth = 160;
constexpr int kHeight = 120;

geometry::Camera small_camera(double k1 = 0) {
  geometry::CameraParameters parameters;
  parameters.width = kWidth;
  parameters.height = kHeight;
  parameters.focal_length = 150;
  parameters.centre_u = 80;
  parameters.centre_v = 60;
  parameters.k1 = k1;
  return geometry::Camera(parameters);
}

double blurred_step(double distance) {
  return 0.5 * std::erfc(-distance / (0.9 * std::numbers::sqrt2));
}

/// A line through (80.3, 60) at `angle` to the vertical; `inside` is left of it.
struct Line {
  double angle;
  [[nodiscard]] Eigen::Vector2d normal() const { return {std::cos(angle), std::sin(angle)}; }
  [[nodiscard]] double distance(const Eigen::Vector2d& p) const {
    return normal().dot(p - Eigen::Vector2d(80.3, 60));
  }
  [[nodiscard]] VisibleEdge edge(double off) const {
    const Eigen::Vector2d along(-normal().y(), normal().x());
    const Eigen::Vector2d middle = Eigen::Vector2d(80.3, 60) + off * normal();
    VisibleEdge edge;
    edge.image_start = middle - 40 * along;
    edge.image_end = middle + 40 * along;
    return edge;
  }
};

template <typename Grey>
std::vector<std::uint8_t> draw_distances(const Line& line, const geometry::Camera& camera,
                                         const Grey& grey) {
  std::vector<std::uint8_t> pixels(static_cast<std::size_t>(kWidth * kHeight));
  for (int v = 0; v < kHeight; ++v) {
    for (int u = 0; u < kWidth; ++u) {
      const Eigen::Vector2d pixel(u, v);
      const double d = line.distance(camera.undistort(pixel).value_or(pixel));
      pixels[static_cast<std::size_t>(v * kWidth + u)] =
          static_cast<std::uint8_t>(std::lround(grey(d)));
    }
  }
  return pixels;
}

double mean_distance(const std::vector<SearchedSample>& samples, const Line& line) {
  double sum = 0;
  int count = 0;
  for (const SearchedSample& sample : samples) {
    if (sample.count > 0) {
      sum += line.distance(sample.candidates.front().pixel);
      ++count;
    }
  }
  EXPECT_GE(count, 18);
  return sum / count;
}

class EdgeSearchAtAngle : public ::testing::TestWithParam<double> {};

TEST_P(EdgeSearchAtAngle, FindsAStepOfEitherSignToAFractionOfAPixel) {
  const geometry::Camera camera = small_camera();
  const Line line{GetParam()};
  EdgeSearch search(camera, {});
  for (const double contrast : {60.0, -60.0}) {
    const auto pixels = draw_distances(
        line, camera, [contrast](double d) { return 120 + contrast * blurred_step(d); });
    std::vector<SearchedSample> samples;
    search.search({pixels.data(), kWidth, kHeight, kWidth}, line.edge(2.4), 7, line.normal(), 6, {},
                  samples);
    ASSERT_EQ(samples.size(), 20U);
    EXPECT_EQ(samples.front().edge, 7U);
    EXPECT_NEAR(mean_distance(samples, line), 0, 0.05);
    EXPECT_NEAR(samples.front().candidates.front().contrast, contrast, 8);
  }
}

INSTANTIATE_TEST_SUITE_P(Angles, EdgeSearchAtAngle, ::testing::Values(0.0, 0.31, 0.79, 1.2, 2.5));

TEST(EdgeSearch, IsNotMisledByTheShadingOfARoundPipe) {
  // No step at the contour at all: brightness begins there with a root. The steepest place of this
  // image lies 0.5 px inside.
  const geometry::Camera camera = small_camera();
  const Line line{0.2};
  const auto limb = [](double d) { return d < 0 ? std::sqrt(-d * (80 + d)) / 40 : 0.0; };
  const auto pixels = draw_distances(line, camera, [&limb](double d) {
    double sum = 0;
    double weights = 0;
    for (int i = -20; i <= 20; ++i) {
      const double weight = std::exp(-0.5 * (i / 7.0) * (i / 7.0));
      sum += weight * limb(d + 0.9 * i / 7.0);
      weights += weight;
    }
    return 60 + 150 * sum / weights;
  });
  EdgeSearch search(camera, {});
  std::vector<SearchedSample> samples;
  search.search({pixels.data(), kWidth, kHeight, kWidth}, line.edge(-1.0), 0, line.normal(), 6, {},
                samples);
  EXPECT_NEAR(mean_distance(samples, line), 0, 0.2);
}

TEST(EdgeSearch, TellsAContourFromAShadowBesideItWhereTheEdgeIsKnown) {
  constexpr double kBorder = 2.2;  // px outside of the contour
  const geometry::Camera camera = small_camera();
  const Line line{0.2};
  const auto pixels = draw_distances(line, camera, [](double d) {
    return 60 + 40 * blurred_step(d) + 50 * blurred_step(d - kBorder);
  });
  EdgeSearch search(camera, {});
  const auto found = [&](double expected, double looks) {
    std::vector<SearchedSample> samples;
    search.search({pixels.data(), kWidth, kHeight, kWidth}, line.edge(expected), 0, line.normal(),
                  6, {.contrast = 80, .spread = 10, .samples = looks, .agreement = 1}, samples);
    return samples;
  };
  const auto first = found(-0.2, 20);
  EXPECT_GT(mean_distance(first, line), 0.4) << "nothing to tell apart";

  const auto known = found(-0.2, 200);
  EXPECT_NEAR(mean_distance(known, line), 0, 0.2);
  for (const SearchedSample& sample : known) {
    ASSERT_EQ(sample.count, 2);
    EXPECT_NEAR(line.distance(sample.candidates[1].pixel), kBorder, 0.5);
  }

  // Where the edge is expected beyond, one step is nearer.
  EXPECT_DOUBLE_EQ(mean_distance(found(3, 200), line), mean_distance(found(3, 20), line));
}

TEST(EdgeSearch, ReportsIdealPixelsOfADistortingCamera) {
  const geometry::Camera camera = small_camera(-0.15);
  const Line line{0.4};
  const auto pixels =
      draw_distances(line, camera, [](double d) { return 90 + 70 * blurred_step(d); });
  EdgeSearch search(camera, {});
  std::vector<SearchedSample> samples;
  search.search({pixels.data(), kWidth, kHeight, kWidth}, line.edge(1.5), 0, line.normal(), 6, {},
                samples);
  EXPECT_NEAR(mean_distance(samples, line), 0, 0.06);
}

TEST(EdgeSearch, KeepsSeveralCandidatesAndUsesWhatItKnowsOfTheEdge) {
  const geometry::Camera camera = small_camera();
  const Line line{0};
  const auto pixels = draw_distances(
      line, camera, [](double d) { return 100 + 60 * blurred_step(d) - 60 * blurred_step(d - 9); });
  EdgeSearch search(camera, {});
  std::vector<SearchedSample> samples;
  const ImageView image{pixels.data(), kWidth, kHeight, kWidth};
  search.search(image, line.edge(4), 0, line.normal(), 12, {}, samples);
  EXPECT_EQ(samples.front().count, 2);

  EdgeMemory memory(test::drawn_rack());
  const EdgeId id{.kind = EdgeKind::kPipe, .body = 1, .part = 0, .side = 1};
  EXPECT_FALSE(memory.look(id).decides_sign());
  for (int i = 0; i < 30; ++i) {
    memory.learn(id, -55);
  }
  EXPECT_TRUE(memory.look(id).decides_sign());
  EXPECT_EQ(memory.look({.body = 1, .part = 0, .side = 0}).samples, 0);
  samples.clear();
  search.search(image, line.edge(4), 0, line.normal(), 12, memory.look(id), samples);
  ASSERT_EQ(samples.front().count, 1);
  EXPECT_NEAR(samples.front().candidates.front().distance, 5, 0.2);
  memory.clear();
  EXPECT_EQ(memory.look(id).samples, 0);
}

TEST(EdgeSearch, FindsNothingInAPlainImageAndKeepsWithinTheImage) {
  const geometry::Camera camera = small_camera();
  const std::vector<std::uint8_t> plain(static_cast<std::size_t>(kWidth * kHeight), 80);
  EdgeSearch search(camera, {});
  std::vector<SearchedSample> samples;
  VisibleEdge edge;
  edge.image_start = {-30, -20};
  edge.image_end = {kWidth + 20.0, kHeight + 30.0};
  search.search({plain.data(), kWidth, kHeight, kWidth}, edge, 0,
                Eigen::Vector2d(0.6, -0.8).normalized(), 40, {}, samples);
  for (const SearchedSample& sample : samples) {
    EXPECT_EQ(sample.count, 0);
  }
  EXPECT_FALSE(samples.front().searched);
  EXPECT_TRUE(samples[10].searched);
}

TEST(EdgeSearch, RefusesParametersOutOfRange) {
  EdgeSearchParameters parameters;
  parameters.filter_sigma = 0.1;
  EXPECT_THROW(EdgeSearch(small_camera(), parameters), std::invalid_argument);
  parameters = {};
  parameters.samples_per_edge = 1;
  EXPECT_THROW(parameters.validate(), std::invalid_argument);
  parameters = {};
  parameters.least_contrast = std::nan("");
  EXPECT_THROW(parameters.validate(), std::invalid_argument);
}

}  // namespace
}  // namespace pipescout::rack_vision
