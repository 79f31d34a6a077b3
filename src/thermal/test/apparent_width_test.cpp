// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <numbers>
#include <random>

#include "camera_helpers.hpp"
#include "pipescout/thermal/leak_detector.hpp"

namespace pipescout::thermal {
namespace {

using Eigen::Vector2d;

constexpr int kWidth = 320;
constexpr int kHeight = 240;

/// The radiance of a pipe and of what is around it, as a lens and pixels blur it.
struct Scene {
  Vector2d middle{158.3, 121.4};
  double angle = 0;
  double width = 9.3;
  double blur = 0.8;  // pixels
  double pipe = 14000;
  double around = 12000;  // counts

  /// Blurred by a Gaussian, an edge is an error function.
  [[nodiscard]] double at(double x, double y) const {
    const Vector2d normal(-std::sin(angle), std::cos(angle));
    const double off = normal.dot(Vector2d(x, y) - middle);
    const double scale = std::sqrt(2.0) * blur;
    const double share =
        0.5 * (std::erf((0.5 * width - off) / scale) + std::erf((0.5 * width + off) / scale));
    return around + share * (pipe - around);
  }
};

template <class Pixel>
struct Picture {
  std::vector<Pixel> pixels = std::vector<Pixel>(std::size_t{kWidth} * kHeight);

  Picture(const Scene& scene, const std::function<double(double)>& value) {
    for (int y = 0; y < kHeight; ++y) {
      for (int x = 0; x < kWidth; ++x) {
        at(x, y) = static_cast<Pixel>(value(scene.at(x, y)));
      }
    }
  }
  [[nodiscard]] Pixel& at(int x, int y) { return pixels[static_cast<std::size_t>(y * kWidth + x)]; }
  [[nodiscard]] ImageView<Pixel> view() const { return {pixels.data(), kWidth, kHeight, kWidth}; }
};

/// Temperatures of counts, NaN where none explains them.
std::vector<float> table_of(const Radiometry& radiometry) {
  std::vector<float> table(65536);
  for (std::size_t i = 0; i < table.size(); ++i) {
    table[i] = static_cast<float>(radiometry.temperature(static_cast<double>(i)));
  }
  return table;
}

double rounded(double counts) {
  return std::round(counts);
}

double width_in(const Detections& detections) {
  EXPECT_EQ(detections.pipes.size(), 1U);
  return detections.pipes.size() == 1 ? detections.pipes[0].width
                                      : std::numeric_limits<double>::infinity();
}

TEST(ApparentWidth, DependsNeitherOnTheThresholdNorOnBlurNorOnTheDirection) {
  const Radiometry radiometry(test::sc660(), {});
  const std::vector<float> table = table_of(radiometry);
  for (const double threshold : {60.0, 90.0, 130.0}) {
    LeakDetector detector({.threshold = threshold, .pipe_diameter = 0.12});
    for (const double width : {6.2, 9.3, 31.7}) {
      // Of more blur than this the middle of the pipe has a part, too.
      for (const double blur : {0.3, 0.8, std::min(1.5, width / 7)}) {
        for (int degrees = 0; degrees < 180; degrees += 15) {
          const Scene scene{.angle = degrees * std::numbers::pi / 180,
                            .width = width,
                            .blur = blur,
                            .pipe = radiometry.counts(150),
                            .around = radiometry.counts(12)};
          const Picture<std::uint16_t> picture(scene, rounded);
          EXPECT_NEAR(width_in(detector.detect(picture.view(), table)), width, 0.25)
              << threshold << " degC, " << blur << " px, " << degrees << " degrees";
        }
      }
    }
  }
}

TEST(ApparentWidth, IsFoundWhereWhatIsBesideThePipeHasNoTemperature) {
  const Radiometry radiometry(test::sc660(), ibarguren2013_object());
  const std::vector<float> table = table_of(radiometry);
  LeakDetector detector({.threshold = 90, .pipe_diameter = 0.12});
  const Scene scene{
      .angle = 0.3, .pipe = radiometry.counts(150), .around = radiometry.floor_counts() - 2000};
  const Picture<std::uint16_t> picture(scene, rounded);
  const Detections& d = detector.detect(picture.view(), table);
  EXPECT_NEAR(width_in(d), scene.width, 0.25);
  // What is above the threshold is far narrower.
  EXPECT_LT(2 * d.pipes[0].half_width, scene.width - 1);
}

TEST(ApparentWidth, IsThatOfTemperaturesToo) {
  const Radiometry radiometry(test::sc660(), {});
  const auto celsius = [&](double counts) { return radiometry.temperature(counts); };
  for (const bool hot : {true, false}) {
    const Scene scene{
        .angle = 0.8, .pipe = radiometry.counts(hot ? 250 : -30), .around = radiometry.counts(20)};
    LeakDetector detector({.polarity = hot ? Polarity::kHot : Polarity::kCold,
                           .threshold = hot ? 60.0 : 10.0,
                           .pipe_diameter = 0.12});
    const Picture<float> picture(scene, celsius);
    EXPECT_NEAR(width_in(detector.detect(picture.view())), scene.width, 0.25);
  }
}

TEST(ApparentWidth, NeitherDeadPixelsNorPostsNorNoiseChangeIt) {
  const Radiometry radiometry(test::sc660(), {});
  const std::vector<float> table = table_of(radiometry);
  const Scene scene{.angle = 0.1, .pipe = radiometry.counts(150), .around = radiometry.counts(12)};
  std::mt19937_64 engine(5);
  std::normal_distribution<double> noise(0, 10);
  Picture<std::uint16_t> picture(scene,
                                 [&](double counts) { return rounded(counts + noise(engine)); });
  std::uniform_int_distribution<int> x(0, kWidth - 1);
  std::uniform_int_distribution<int> y(0, kHeight - 1);
  for (int i = 0; i < 400; ++i) {
    picture.at(x(engine), y(engine)) = i % 2 == 0 ? 0 : 65535;
  }
  const auto post = static_cast<std::uint16_t>(radiometry.counts(15));
  const auto beam = static_cast<std::uint16_t>(radiometry.counts(200));
  for (int row = 0; row < kHeight; ++row) {
    for (int column = 80; column < 88; ++column) {
      picture.at(column, row) = post;
      picture.at(column + 120, row) = beam;
    }
  }
  LeakDetector detector({.threshold = 90, .pipe_diameter = 0.12});
  const Detections& d = detector.detect(picture.view(), table);
  ASSERT_FALSE(d.pipes.empty());
  EXPECT_NEAR(d.pipes[0].width, scene.width, 0.25);
}

TEST(ApparentWidth, IsNotKnownWhereAnEdgeIsNotSeen) {
  const Radiometry radiometry(test::sc660(), {});
  const Scene scene{.pipe = radiometry.counts(150), .around = radiometry.counts(12)};
  LeakDetector detector({.threshold = 110, .pipe_diameter = 0.12});

  // Greys from 100 to 300 degC: what is beside the pipe is black.
  std::vector<float> greys(256);
  for (std::size_t i = 0; i < greys.size(); ++i) {
    greys[i] = static_cast<float>(100 + static_cast<double>(i) * 200 / 255);
  }
  const Picture<std::uint8_t> grey(scene, [&](double counts) {
    return rounded(std::clamp((radiometry.temperature(counts) - 100) * 255 / 200, 0.0, 255.0));
  });
  const Detections& d = detector.detect(grey.view(), greys);
  EXPECT_TRUE(std::isnan(width_in(d)));
  EXPECT_EQ(d.pipes[0].best_width(), 2 * d.pipes[0].half_width);

  // The same where what is beside it has no temperature, in a picture of temperatures.
  const Picture<float> unknown(scene, [&](double counts) {
    const double celsius = radiometry.temperature(counts);
    return celsius < 100 ? std::numeric_limits<double>::quiet_NaN() : celsius;
  });
  EXPECT_TRUE(std::isnan(width_in(detector.detect(unknown.view()))));

  // The border of the picture cuts it lengthwise.
  Scene cut = scene;
  cut.middle.y() = 2;
  const Picture<float> picture(cut, [&](double counts) { return radiometry.temperature(counts); });
  const Detections& at_border = detector.detect(picture.view());
  EXPECT_TRUE(std::isnan(width_in(at_border)));
}

}  // namespace
}  // namespace pipescout::thermal
