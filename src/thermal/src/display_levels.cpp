// SPDX-License-Identifier: Apache-2.0
#include "pipescout/thermal/display_levels.hpp"

#include <algorithm>
#include <cmath>

#include "pipescout/statistics/quantile.hpp"
#include "pipescout/validation/check.hpp"

namespace pipescout::thermal {
namespace {

constexpr double kBlackShare = 0.01;
constexpr double kWhiteShare = 0.999;
constexpr double kWhite = 255;

}  // namespace

template <class Pixel>
std::vector<std::uint8_t> display_levels(const ImageView<Pixel>& image) {
  if (!image.valid()) {
    validation::refuse("image: has no pixels");
  }
  const std::size_t pixels =
      static_cast<std::size_t>(image.width) * static_cast<std::size_t>(image.height);
  std::vector<double> values;
  values.reserve(pixels);
  for (int y = 0; y < image.height; ++y) {
    for (int x = 0; x < image.width; ++x) {
      if (const auto value = static_cast<double>(image(x, y)); std::isfinite(value)) {
        values.push_back(value);
      }
    }
  }
  std::vector<std::uint8_t> levels(pixels, 0);
  if (values.empty()) {
    return levels;
  }
  const double black = statistics::quantile_in_place(values, kBlackShare);
  const double span = std::max(statistics::quantile_in_place(values, kWhiteShare) - black, 1e-9);
  auto level = levels.begin();
  for (int y = 0; y < image.height; ++y) {
    for (int x = 0; x < image.width; ++x, ++level) {
      const double share = (static_cast<double>(image(x, y)) - black) / span;
      if (std::isfinite(share)) {
        *level = static_cast<std::uint8_t>(std::lround(kWhite * std::clamp(share, 0.0, 1.0)));
      }
    }
  }
  return levels;
}

template std::vector<std::uint8_t> display_levels(const TemperatureView& image);
template std::vector<std::uint8_t> display_levels(const CountView& image);
template std::vector<std::uint8_t> display_levels(const GreyView& image);

}  // namespace pipescout::thermal
