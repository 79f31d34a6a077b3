// SPDX-License-Identifier: Apache-2.0
#include "apparent_width.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <type_traits>

namespace pipescout::thermal {
namespace {

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
/// Places along the pipe that are looked at, and how many of them have to show its edge.
constexpr int kMostStations = 16;
constexpr int kLeastStations = 5;
/// Values from the axis outwards, and pixels from one to the next at least.
constexpr int kMostSteps = 96;
constexpr double kLeastStep = 0.5;
/// Of what it has fallen by so far: less within a pixel, and the edge has come to its end.
constexpr double kFoot = 0.02;

/// What a black body radiates in the band of thermal cameras (7.5 to 14 um), in a unit of its own:
/// Planck's law as their makers write it, with B = 1500 K. Where an edge is blurred radiances mix,
/// not temperatures.
double radiance(double celsius) {
  return 1 / std::expm1(1500 / (celsius + 273.15));
}

/// Bilinear, of what the file holds; NaN where one of the four is.
template <class Pixel>
float value_at(const ImageView<Pixel>& image, const Eigen::Vector2d& point) {
  const int x = static_cast<int>(point.x());
  const int y = static_cast<int>(point.y());
  const auto u = static_cast<float>(point.x() - x);
  const auto v = static_cast<float>(point.y() - y);
  const auto at = [&](int dx, int dy) { return static_cast<float>(image(x + dx, y + dy)); };
  return (1 - v) * ((1 - u) * at(0, 0) + u * at(1, 0)) + v * ((1 - u) * at(0, 1) + u * at(1, 1));
}

/// What is seen from the axis of a pipe outwards, on one side of it: the median along the pipe,
/// which neither a dead pixel nor a post changes.
class SideProfile {
 public:
  explicit SideProfile(double reach)
      : step_(std::max(kLeastStep, reach / (kMostSteps - 1))),
        size_(static_cast<std::size_t>(reach / step_) + 1) {}

  /// From a place on the axis outwards, unless that leaves the picture, or something is not known.
  template <class Pixel>
  void add(const ImageView<Pixel>& image, const Eigen::Vector2d& middle,
           const Eigen::Vector2d& outwards) {
    const auto inside = [&](const Eigen::Vector2d& p) {
      return p.x() >= 0 && p.y() >= 0 && p.x() < image.width - 1 && p.y() < image.height - 1;
    };
    const Eigen::Vector2d last = middle + static_cast<double>(size_ - 1) * step_ * outwards;
    if (!inside(middle) || !inside(last) || count_ == kMostStations) {
      return;
    }
    for (std::size_t k = 0; k < size_; ++k) {
      const float value =
          value_at(image, Eigen::Vector2d(middle + static_cast<double>(k) * step_ * outwards));
      if (!std::isfinite(value)) {
        return;
      }
      values_[k][static_cast<std::size_t>(count_)] = value;
    }
    ++count_;
  }

  [[nodiscard]] bool enough() const noexcept { return count_ >= kLeastStations; }
  [[nodiscard]] double step() const noexcept { return step_; }

  /// To be called once.
  [[nodiscard]] std::span<const double> medians() {
    for (std::size_t k = 0; k < size_; ++k) {
      const auto middle = values_[k].begin() + count_ / 2;
      std::nth_element(values_[k].begin(), middle, values_[k].begin() + count_);
      medians_[k] = *middle;
    }
    return std::span(medians_).first(size_);
  }

 private:
  double step_;
  std::size_t size_;
  int count_ = 0;
  std::array<std::array<float, kMostStations>, kMostSteps> values_;
  std::array<double, kMostSteps> medians_;
};

/// From values to radiance. Counts below those that have a temperature, such as those of a sky
/// that is colder than what the pipe reflects, go on in a straight line, for counts are radiances.
template <class Pixel>
class Radiance {
 public:
  /// `pipe`: a value that has a temperature.
  Radiance(const Scale<Pixel>& scale, double pipe) : scale_(scale) {
    if constexpr (!std::is_same_v<Pixel, float>) {
      const auto upto = scale.celsius.first(
          std::min(scale.celsius.size(), static_cast<std::size_t>(std::max(pipe, 0.0)) + 1));
      const auto known =
          std::partition_point(upto.begin(), upto.end(), [](float t) { return std::isnan(t); });
      first_ = static_cast<double>(known - upto.begin());
      slope_ = (celsius_radiance(pipe) - celsius_radiance(first_)) / (pipe - first_);
    }
  }

  [[nodiscard]] double operator()(double value) const {
    return value < first_ ? celsius_radiance(first_) + (value - first_) * slope_
                          : celsius_radiance(value);
  }

 private:
  [[nodiscard]] double celsius_radiance(double value) const {
    if constexpr (std::is_same_v<Pixel, float>) {
      return radiance(value);
    } else {
      const auto below = static_cast<Pixel>(value);
      const double rest = value - below;
      const double t = scale_(below);
      return radiance(rest > 0 ? t + rest * (scale_(static_cast<Pixel>(below + 1)) - t) : t);
    }
  }

  const Scale<Pixel>& scale_;
  double first_ = std::numeric_limits<double>::lowest();
  double slope_ = 0;
};

/// Whether a value says no more than that the sensor, or the range of the greys, has ended.
template <class Pixel>
bool at_the_end(double value) {
  return !std::is_same_v<Pixel, float> &&
         (value < 0.5 || value > std::numeric_limits<Pixel>::max() - 0.5);
}

/// Pixels from the axis to the edge; NaN where that is not seen.
template <class Pixel>
double edge_of(std::span<const double> values, double step, double half_width,
               const Scale<Pixel>& scale, Polarity polarity) {
  const auto core = static_cast<std::size_t>(0.4 * half_width / step) + 1;
  const auto pixel = std::max<std::size_t>(1, static_cast<std::size_t>(std::lround(1 / step)));
  double inside = 0;
  for (const double value : values.first(core)) {
    inside += value / static_cast<double>(core);
  }
  const double sign = polarity == Polarity::kHot ? 1 : -1;
  const auto fall = [&](std::size_t k) { return sign * (values[k] - values[k + pixel]); };
  std::size_t foot = core;
  for (std::size_t k = core; k + pixel < values.size(); ++k) {
    foot = fall(k) > fall(foot) ? k : foot;
  }
  while (foot + pixel < values.size() && fall(foot) > kFoot * sign * (inside - values[foot])) {
    ++foot;
  }
  const double outside = values[foot];
  if (foot + pixel >= values.size() || at_the_end<Pixel>(inside) || at_the_end<Pixel>(outside)) {
    return kNan;
  }
  const Radiance<Pixel> radiance_of(scale, inside);
  const double level = 0.5 * (radiance_of(inside) + radiance_of(outside));
  double before = radiance_of(values[core - 1]);
  for (std::size_t k = core; k <= foot; ++k) {
    const double here = radiance_of(values[k]);
    if (sign * (here - level) <= 0) {
      return step * (static_cast<double>(k) - (level - here) / (before - here));
    }
    before = here;
  }
  return kNan;
}

}  // namespace

template <class Pixel>
double apparent_width(const ImageView<Pixel>& image, const Scale<Pixel>& scale,
                      const PipeSection& pipe, std::span<const std::uint8_t> pipe_shaped,
                      Polarity polarity) {
  const Eigen::Vector2d direction = (pipe.end - pipe.start).normalized();
  const Eigen::Vector2d normal(-direction.y(), direction.x());
  const auto samples = static_cast<int>(pipe_shaped.size());
  const int stride = std::max(1, (samples + kMostStations - 1) / kMostStations);
  double width = 0;
  for (const double side : {-1.0, 1.0}) {
    SideProfile profile(1.5 * pipe.half_width + 6);
    for (int i = stride / 2; i < samples; i += stride) {
      if (pipe_shaped[static_cast<std::size_t>(i)] != 0) {
        profile.add(image, pipe.at(i), side * normal);
      }
    }
    if (!profile.enough()) {
      return kNan;
    }
    width += edge_of(profile.medians(), profile.step(), pipe.half_width, scale, polarity);
  }
  return width;
}

template double apparent_width(const TemperatureView&, const Scale<float>&, const PipeSection&,
                               std::span<const std::uint8_t>, Polarity);
template double apparent_width(const CountView&, const Scale<std::uint16_t>&, const PipeSection&,
                               std::span<const std::uint8_t>, Polarity);
template double apparent_width(const GreyView&, const Scale<std::uint8_t>&, const PipeSection&,
                               std::span<const std::uint8_t>, Polarity);

}  // namespace pipescout::thermal
