// SPDX-License-Identifier: Apache-2.0
#include "pipescout/thermal/leak_detector.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "apparent_width.hpp"
#include "known_pipes.hpp"
#include "straight_sections.hpp"
#include "threshold_mask.hpp"

namespace pipescout::thermal {
namespace {

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
constexpr int kMostAcross = 9;
/// Of the warmth of a pipe: what is beside it and as warm is one body with what is seen in its
/// place.
constexpr double kSameBody = 0.7;
/// Of how much a section differs from one side of it, by how much it has to differ from the other
/// one at least. Beside a warm edge the mean of the surroundings is warm, and all along it there is
/// a strip that is colder than that, though nothing ends there: it differs from one side only. In
/// pictures of real cameras such strips have shares up to 0.25, pipes and tubes 0.45 and more.
constexpr double kWeakerSide = 0.3;

bool set_at(const BitMask& mask, const Eigen::Vector2d& point) {
  const int x = static_cast<int>(std::lround(point.x()));
  const int y = static_cast<int>(std::lround(point.y()));
  return mask.contains(x, y) && mask.get(x, y);
}

/// Whether all is set from the edge of a pipe, `half_width` from its axis, to a point beside it. A
/// pipe that runs next to it is set too, but not what is between them.
bool connected(const BitMask& mask, const Eigen::Vector2d& axis, const Eigen::Vector2d& beside,
               double half_width) {
  const double distance = (beside - axis).norm();
  const Eigen::Vector2d outwards = (beside - axis) / distance;
  if (!set_at(mask, beside)) {
    return false;
  }
  for (double from_axis = half_width + 1; from_axis < distance; ++from_axis) {
    if (!set_at(mask, axis + from_axis * outwards)) {
      return false;
    }
  }
  return true;
}

/// Bilinear; NaN outside, and where one of the four is.
template <class Pixel>
float temperature_at(const ImageView<Pixel>& image, const Scale<Pixel>& scale,
                     const Eigen::Vector2d& point) {
  if (!(point.x() >= 0 && point.y() >= 0 && point.x() <= image.width - 1 &&
        point.y() <= image.height - 1)) {
    return std::numeric_limits<float>::quiet_NaN();
  }
  const int x = static_cast<int>(point.x());
  const int y = static_cast<int>(point.y());
  const auto u = static_cast<float>(point.x() - x);
  const auto v = static_cast<float>(point.y() - y);
  const int right = u > 0 ? x + 1 : x;
  const int bottom = v > 0 ? y + 1 : y;
  const float upper = (1 - u) * scale(image(x, y)) + u * scale(image(right, y));
  const float lower = (1 - u) * scale(image(x, bottom)) + u * scale(image(right, bottom));
  return (1 - v) * upper + v * lower;
}

/// How much a section differs from what is on one side of it, K.
class SideContrast {
 public:
  void add(double value) {
    if (std::isfinite(value)) {
      sum_ += value;
      ++count_;
    }
  }
  /// NaN where nothing is seen of that side.
  [[nodiscard]] double mean() const { return count_ == 0 ? kNan : sum_ / count_; }

 private:
  double sum_ = 0;
  int count_ = 0;
};

/// By what is known of the radiometry, from the apparent temperatures of the leak and its pipe.
void set_degrees(const RadiometryPosterior& posterior, double reference, LeakDetection& leak) {
  const TemperatureInterval mean = posterior.difference(leak.stretch.mean, reference);
  const TemperatureInterval peak = posterior.difference(leak.stretch.peak, reference);
  leak.delta = mean.mean;
  leak.delta_deviation = mean.deviation;
  leak.delta_low = mean.low;
  leak.delta_high = mean.high;
  leak.peak_delta = peak.mean;
  leak.peak_delta_deviation = peak.deviation;
  leak.peak_delta_low = peak.low;
  leak.peak_delta_high = peak.high;
}

/// The mean without the smallest and the largest value, one of which a dead pixel may be.
float trimmed_mean(const std::array<float, kMostAcross>& values, int count) {
  float sum = 0;
  float low = std::numeric_limits<float>::max();
  float high = std::numeric_limits<float>::lowest();
  for (int i = 0; i < count; ++i) {
    const float value = values[static_cast<std::size_t>(i)];
    sum += value;
    low = std::min(low, value);
    high = std::max(high, value);
  }
  return count < 3 ? sum / static_cast<float>(count)
                   : (sum - low - high) / static_cast<float>(count - 2);
}

}  // namespace

const PipeSection* Detections::main_pipe() const noexcept {
  const PipeSection* best = nullptr;
  for (const PipeSection& pipe : pipes) {
    const bool long_enough = 2 * pipe.length() >= pipes.front().length();
    if (best == nullptr || (long_enough && pipe.contrast > best->contrast)) {
      best = &pipe;
    }
  }
  return best;
}

struct LeakDetector::Implementation {
  LeakDetectorParameters parameters;
  ThresholdMask threshold;
  MedialAxis axis;
  StraightSections straights;
  KnownPipes known;
  ProfileAnalysis analysis;
  std::vector<std::uint8_t> pipe_shaped;
  std::size_t unhidden = 0;        // samples of the latest section that no other known pipe hides
  bool differs_from_both = false;  // of the latest section: from what is on either side of it
  double contrast = 0;             // K, of the latest section, to the side that differs less
  std::vector<float> turned;       // the profile of a cold pipe with its sign changed
  Detections detections;

  explicit Implementation(const LeakDetectorParameters& p)
      : parameters((p.validate(), p)), analysis(profile_parameters(p)) {}

  static ProfileParameters profile_parameters(const LeakDetectorParameters& p) {
    ProfileParameters profile = p.profile;
    if (p.polarity == Polarity::kCold) {
      profile.maximum_temperature.reset();
    }
    return profile;
  }

  template <class Pixel>
  const Detections& detect(const ImageView<Pixel>& image, const Scale<Pixel>& scale,
                           const FrameConditions& conditions);
  template <class Pixel>
  void search(const ImageView<Pixel>& image, const Scale<Pixel>& scale,
              const FrameConditions& conditions);
  // `known_axis`: of a known pipe; null for one that was searched for.
  template <class Pixel>
  void add(const ImageView<Pixel>& image, const Scale<Pixel>& scale, PipeSection pipe,
           const KnownPipes::Axis* known_axis, const FrameConditions& conditions);
  template <class Pixel>
  void sample(const ImageView<Pixel>& image, const Scale<Pixel>& scale, const PipeSection& pipe,
              const KnownPipes::Axis* known_axis);
  template <class Pixel>
  [[nodiscard]] double across(const ImageView<Pixel>& image, const Scale<Pixel>& scale,
                              const PipeSection& pipe, const KnownPipes::Axis* known_axis,
                              const LeakDetection& leak) const;
  [[nodiscard]] double half_width_at(const PipeSection& pipe, const KnownPipes::Axis* known_axis,
                                     const Eigen::Vector2d& point) const {
    return known_axis == nullptr ? pipe.half_width : known.half_width(*known_axis, point);
  }
  void extend(Eigen::Vector2d& end, const Eigen::Vector2d& direction, double half_width) const;
  [[nodiscard]] double visible_share(const PipeSection& pipe) const;
  [[nodiscard]] double scale_of(const PipeSection& pipe, const FrameConditions& conditions) const;
  void analyse(PipeSection& pipe, const FrameConditions& conditions);
};

template <class Pixel>
const Detections& LeakDetector::Implementation::detect(const ImageView<Pixel>& image,
                                                       const Scale<Pixel>& scale,
                                                       const FrameConditions& conditions) {
  Detections& d = detections;
  d.pipes.clear();
  d.leaks.clear();
  d.profile.clear();
  d.parts.clear();
  d.width = image.width;
  d.height = image.height;
  d.fault = threshold.make(image, scale, parameters, conditions);
  d.threshold = threshold.threshold();
  if (d.fault != FrameFault::kNone) {
    return d;
  }
  if (conditions.strips.empty()) {
    search(image, scale, conditions);
    return d;
  }
  known.set(conditions.strips, image.width, image.height);
  for (const KnownPipes::Axis& known_axis : known.axes()) {
    PipeSection pipe;
    pipe.start = known_axis.start;
    pipe.end = known_axis.end;
    pipe.half_width = known_axis.half_width;
    pipe.metres_per_pixel = known_axis.metres_per_pixel;
    if (d.pipes.size() < parameters.max_pipes && 2 * pipe.half_width >= parameters.min_width) {
      add(image, scale, pipe, &known_axis, conditions);
    }
  }
  return d;
}

/// For the straight sections of what is above the threshold.
template <class Pixel>
void LeakDetector::Implementation::search(const ImageView<Pixel>& image, const Scale<Pixel>& scale,
                                          const FrameConditions& conditions) {
  Detections& d = detections;
  const double shorter = std::min(image.width, image.height);
  const double longer = std::max(image.width, image.height);
  // A chord of a strip is longer than the strip is wide, by the root of 2 at most.
  if (!axis.find(threshold.mask(),
                 {parameters.min_width, std::sqrt(2.0) * parameters.max_width * shorter})) {
    d.fault = FrameFault::kCluttered;
    return;
  }
  straights.find(
      axis, {parameters.straightness, parameters.max_gap * longer, parameters.min_length * longer,
             parameters.min_elongation, parameters.max_pipes});
  for (const Straight& s : straights.sections()) {
    if (2 * s.half_width() > parameters.max_width * shorter) {
      continue;
    }
    PipeSection pipe;
    pipe.start = s.start();
    pipe.end = s.end();
    pipe.half_width = s.half_width();
    pipe.deviation = s.deviation();
    pipe.cut_along = s.cut;
    extend(pipe.start, -s.direction(), s.half_width());
    extend(pipe.end, s.direction(), s.half_width());
    add(image, scale, pipe, nullptr, conditions);
  }
}

template <class Pixel>
void LeakDetector::Implementation::add(const ImageView<Pixel>& image, const Scale<Pixel>& scale,
                                       PipeSection pipe, const KnownPipes::Axis* known_axis,
                                       const FrameConditions& conditions) {
  Detections& d = detections;
  pipe.first_sample = d.profile.size();
  sample(image, scale, pipe, known_axis);
  pipe.samples = d.profile.size() - pipe.first_sample;
  pipe.visible = visible_share(pipe);
  const bool stands_out = known_axis != nullptr ||
                          parameters.threshold_rule != ThresholdRule::kLocal || differs_from_both;
  // How warm a pipe is, a short piece between others that hide it does not tell.
  const bool long_enough =
      known_axis == nullptr ||
      static_cast<double>(unhidden) >= parameters.min_length * std::max(image.width, image.height);
  if (pipe.visible < parameters.min_visible || !stands_out || !long_enough) {
    d.profile.resize(pipe.first_sample);
    return;
  }
  if (parameters.pipe_diameter > 0) {
    pipe.width = apparent_width(image, scale, pipe, pipe_shaped, parameters.polarity);
  }
  const std::size_t first_leak = d.leaks.size();
  analyse(pipe, conditions);
  for (std::size_t i = first_leak; i < d.leaks.size(); ++i) {
    d.leaks[i].across = across(image, scale, pipe, known_axis, d.leaks[i]);
  }
  d.pipes.push_back(pipe);
}

/// Where the border cuts a pipe at an angle, or another pipe crosses, no chord is whole; the axis
/// goes on for about a width, as long as it stays amid what is set.
void LeakDetector::Implementation::extend(Eigen::Vector2d& end, const Eigen::Vector2d& direction,
                                          double half_width) const {
  const BitMask& mask = threshold.mask();
  const Eigen::Vector2d side = 0.7 * half_width * Eigen::Vector2d(-direction.y(), direction.x());
  const auto clear_at = [&](const Eigen::Vector2d& point) {
    const int x = static_cast<int>(std::lround(point.x()));
    const int y = static_cast<int>(std::lround(point.y()));
    return mask.contains(x, y) && !mask.get(x, y);
  };
  const int steps = static_cast<int>(3 * half_width) + 2;
  for (int i = 0; i < steps; ++i) {
    const Eigen::Vector2d next = end + direction;
    if (!set_at(mask, next) || clear_at(next + side) || clear_at(next - side)) {
      return;
    }
    end = next;
  }
}

/// Appends the temperatures along the axis, one a pixel, at the middle of sample i, and fills
/// `pipe_shaped`: set within the edges, and not as warm outside of them, where a post before the
/// pipe or a body behind it would be. Tells `unhidden` and `differs_from_both` too.
template <class Pixel>
void LeakDetector::Implementation::sample(const ImageView<Pixel>& image, const Scale<Pixel>& scale,
                                          const PipeSection& pipe,
                                          const KnownPipes::Axis* known_axis) {
  const BitMask& mask = threshold.mask();
  const Eigen::Vector2d direction = (pipe.end - pipe.start).normalized();
  const Eigen::Vector2d normal(-direction.y(), direction.x());
  const int samples = static_cast<int>(std::floor(pipe.length())) + 1;
  const double sign = parameters.polarity == Polarity::kHot ? 1 : -1;
  pipe_shaped.clear();
  unhidden = 0;
  std::array<SideContrast, 2> sides;
  std::array<float, kMostAcross> values{};
  for (int i = 0; i < samples; ++i) {
    const Eigen::Vector2d middle = pipe.start + i * direction;
    const double half_width = half_width_at(pipe, known_axis, middle);
    const double reach = parameters.profile_width * half_width;
    const int across = std::clamp(2 * static_cast<int>(std::lround(reach)) + 1, 3, kMostAcross);
    const double step = 2 * reach / (across - 1);
    int seen = 0;
    int below = 0;
    int hidden = 0;
    for (int k = 0; k < across; ++k) {
      const Eigen::Vector2d point = middle + (k * step - reach) * normal;
      if (known_axis != nullptr && known.hidden(*known_axis, point)) {
        ++hidden;
        continue;
      }
      if (!set_at(mask, point)) {
        ++below;
        continue;
      }
      const float value = temperature_at(image, scale, point);
      if (std::isfinite(value)) {
        values[static_cast<std::size_t>(seen++)] = value;
      }
    }
    unhidden += 2 * hidden > across ? 0U : 1U;
    detections.profile.push_back(2 * (below + hidden) > across || seen == 0
                                     ? std::numeric_limits<float>::quiet_NaN()
                                     : trimmed_mean(values, seen));
    const double here = detections.profile.back();
    // Warmth counts from the threshold; where that varies, all that is set is as warm.
    const double own = sign * (here - threshold.threshold());
    const Eigen::Vector2d inside = 0.6 * half_width * normal;
    const Eigen::Vector2d outside = (1.6 * half_width + 2) * normal;
    bool flanked = false;
    for (std::size_t side = 0; side < 2; ++side) {
      const Eigen::Vector2d beyond = middle + (side == 0 ? -1.0 : 1.0) * outside;
      if (known_axis != nullptr && known.on_another(*known_axis, beyond)) {
        continue;
      }
      const double there = temperature_at(image, scale, beyond);
      sides[side].add(sign * (here - there));
      flanked |= connected(mask, middle, beyond, half_width) &&
                 !(sign * (there - threshold.threshold()) < kSameBody * own);
    }
    const bool shaped =
        !flanked && (set_at(mask, middle + inside) || set_at(mask, middle - inside));
    pipe_shaped.push_back(shaped ? 1 : 0);
  }
  const double one = sides[0].mean();
  const double other = sides[1].mean();
  contrast = std::fmin(one, other);
  // NaN, of a side that the border hides, is no evidence.
  differs_from_both = one > 0 && one >= kWeakerSide * other && other >= kWeakerSide * one;
}

/// The centroid of what is warmer, in the image, than half of the mean rise. All count alike: a
/// dead pixel is one of many.
template <class Pixel>
double LeakDetector::Implementation::across(const ImageView<Pixel>& image,
                                            const Scale<Pixel>& scale, const PipeSection& pipe,
                                            const KnownPipes::Axis* known_axis,
                                            const LeakDetection& leak) const {
  const Eigen::Vector2d direction = (pipe.end - pipe.start).normalized();
  const Eigen::Vector2d normal(-direction.y(), direction.x());
  const double sign = parameters.polarity == Polarity::kHot ? 1 : -1;
  const int reach = static_cast<int>(half_width_at(pipe, known_axis, leak.centre()));
  const int samples = static_cast<int>((leak.end - leak.start).norm()) + 1;
  // Of the image: `leak.delta` may be in kelvins of the pipe, or missing.
  const double half_rise = 0.5 * sign * (leak.stretch.mean - pipe.reference_temperature);
  double sum = 0;
  int count = 0;
  for (int i = 0; i < samples; ++i) {
    for (int k = -reach; k <= reach; ++k) {
      const Eigen::Vector2d point = leak.start + (i + 0.5) * direction + k * normal;
      if (known_axis != nullptr && known.hidden(*known_axis, point)) {
        continue;
      }
      const double there = temperature_at(image, scale, point);
      if (sign * (there - pipe.reference_temperature) > half_rise) {
        sum += k;
        ++count;
      }
    }
  }
  return count == 0 ? 0 : sum / count;
}

double LeakDetector::Implementation::visible_share(const PipeSection& pipe) const {
  const std::span<const float> profile = detections.profile_of(pipe);
  std::size_t seen = 0;
  for (std::size_t i = 0; i < profile.size(); ++i) {
    seen += std::isfinite(profile[i]) && pipe_shaped[i] != 0 ? 1U : 0U;
  }
  return unhidden == 0 ? 0 : static_cast<double>(seen) / static_cast<double>(unhidden);
}

/// m per pixel: of its strips, of all pipes, or by its diameter; 0: unknown.
double LeakDetector::Implementation::scale_of(const PipeSection& pipe,
                                              const FrameConditions& conditions) const {
  if (pipe.metres_per_pixel > 0) {
    return pipe.metres_per_pixel;
  }
  if (conditions.metres_per_pixel > 0) {
    return conditions.metres_per_pixel;
  }
  return parameters.pipe_diameter > 0 && !pipe.cut_along
             ? parameters.pipe_diameter / pipe.best_width()
             : 0;
}

void LeakDetector::Implementation::analyse(PipeSection& pipe, const FrameConditions& conditions) {
  Detections& d = detections;
  const double sign = parameters.polarity == Polarity::kHot ? 1 : -1;
  std::span<const float> profile = d.profile_of(pipe);
  pipe.metres_per_pixel = scale_of(pipe, conditions);
  if (sign < 0) {
    turned.resize(profile.size());
    std::transform(profile.begin(), profile.end(), turned.begin(), std::negate<>());
    profile = turned;
  }
  ProfileAnalysis::Conditions c{.metres_per_sample = pipe.metres_per_pixel,
                                .contrast = std::isfinite(contrast) ? contrast : 0};
  if (conditions.sound && conditions.sound->may_be((pipe.end - pipe.start).normalized())) {
    if (!conditions.levels) {
      c.reference_temperature = sign * conditions.sound->temperature;
    }
    c.spread = conditions.sound->spread;
  }
  analysis.analyse(profile, pipe_shaped, c);
  pipe.reference_temperature = sign * analysis.reference_temperature();
  pipe.spread = analysis.spread();
  pipe.contrast = contrast;
  pipe.first_part = d.parts.size();
  for (PipePart part : analysis.parts()) {
    part.mean *= sign;
    part.peak *= sign;
    d.parts.push_back(part);
  }
  pipe.parts = d.parts.size() - pipe.first_part;
  for (LeakStretch stretch : analysis.leaks()) {
    LeakDetection leak;
    leak.pipe = d.pipes.size();
    leak.delta = stretch.mean - analysis.reference_temperature();
    leak.peak_delta = stretch.peak - analysis.reference_temperature();
    stretch.mean *= sign;
    stretch.peak *= sign;
    leak.stretch = stretch;
    if (conditions.errors) {
      const TemperatureErrors& errors = *conditions.errors;
      leak.delta_deviation = errors.of_difference(stretch.mean, pipe.reference_temperature);
      leak.peak_delta_deviation = errors.of_difference(stretch.peak, pipe.reference_temperature);
    }
    if (conditions.posterior != nullptr) {
      set_degrees(*conditions.posterior, pipe.reference_temperature, leak);
    }
    if (conditions.levels) {
      leak.delta = leak.peak_delta = kNan;
    }
    // Sample i reaches from half a pixel before its middle to half a pixel behind it.
    leak.start = pipe.at(stretch.from - 0.5);
    leak.end = pipe.at(stretch.to - 0.5);
    leak.length =
        pipe.metres_per_pixel > 0 ? pipe.metres_per_pixel * (stretch.to - stretch.from) : kNan;
    leak.severity = parameters.severity.of(leak.delta, leak.length);
    d.leaks.push_back(leak);
  }
}

LeakDetector::LeakDetector(const LeakDetectorParameters& parameters)
    : implementation_(std::make_unique<Implementation>(parameters)) {}
LeakDetector::~LeakDetector() = default;
LeakDetector::LeakDetector(LeakDetector&& other) noexcept = default;
LeakDetector& LeakDetector::operator=(LeakDetector&& other) noexcept = default;

const LeakDetectorParameters& LeakDetector::parameters() const noexcept {
  return implementation_->parameters;
}

const Detections& LeakDetector::detect(const TemperatureView& image,
                                       const FrameConditions& conditions) {
  return implementation_->detect(image, Scale<float>{}, conditions);
}

const Detections& LeakDetector::detect(const CountView& image, std::span<const float> celsius,
                                       const FrameConditions& conditions) {
  return implementation_->detect(image, Scale<std::uint16_t>{celsius}, conditions);
}

const Detections& LeakDetector::detect(const GreyView& image, std::span<const float> celsius,
                                       const FrameConditions& conditions) {
  return implementation_->detect(image, Scale<std::uint8_t>{celsius}, conditions);
}

}  // namespace pipescout::thermal
