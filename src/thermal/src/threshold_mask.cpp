// SPDX-License-Identifier: Apache-2.0
#include "threshold_mask.hpp"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstring>

#include "pipescout/thermal/radiometry.hpp"

namespace pipescout::thermal {
namespace {

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
/// Bins of temperatures that come without counts: 0.05 K from -100 degC on.
constexpr double kBinsPerKelvin = 20;
constexpr double kFirstBin = -100;
constexpr std::size_t kBins = 65536;
/// Of the root mean square of what pixels differ from their surroundings: what stands out of them.
constexpr double kLocalFactor = 0.7;
/// Largest differences that count no more than the next smaller one: dead pixels, the sun.
constexpr double kClippedPart = 0.02;
/// Bins of differences from the surroundings: 0.05 K up to 205 K, the last takes all beyond.
constexpr std::size_t kDifferenceBins = 4096;

/// What the pixels of a picture are compared with: those from `low` to `high` are set.
template <class Pixel>
struct Band {
  Pixel low{};
  Pixel high{};
  bool empty = false;
};

/// Sets the bits of a row. The comparison fills bytes, which the compiler does in vectors; eight
/// bytes of 0 or 1 become eight bits by a multiplication.
template <class Test, class Pixel>
void set_bits(const Pixel* pixels, int width, std::uint64_t* words, const Test& test) {
  static_assert(std::endian::native == std::endian::little);
  std::array<std::uint8_t, 64> bytes{};
  for (int x = 0; x < width; x += 64) {
    const int count = std::min(64, width - x);
    if (count == 64) {
      for (std::size_t i = 0; i < 64; ++i) {
        bytes[i] = static_cast<std::uint8_t>(test(pixels[static_cast<std::size_t>(x) + i]));
      }
    } else {
      bytes.fill(0);
      for (int i = 0; i < count; ++i) {
        bytes[static_cast<std::size_t>(i)] = static_cast<std::uint8_t>(test(pixels[x + i]));
      }
    }
    std::uint64_t word = 0;
    for (unsigned i = 0; i < 8; ++i) {
      std::uint64_t eight = 0;
      std::memcpy(&eight, bytes.data() + 8 * i, 8);
      word |= (eight * 0x0102040810204080ULL >> 56) << (8 * i);
    }
    words[x / 64] = word;
  }
}

/// What is finite in a table; nothing where it falls, or does not lie together.
std::span<const float> rising_part(std::span<const float> celsius) {
  int falls = 0;
  int begins = 0;
  std::uint32_t begin = 0;  // the sum of all, of which there should be one
  int finite = 0;
  const int last = static_cast<int>(celsius.size()) - 1;
  for (int i = 0; i < last; ++i) {
    const float t = celsius[static_cast<std::size_t>(i)];
    const float next = celsius[static_cast<std::size_t>(i) + 1];
    const int here = t != t && next == next ? 1 : 0;
    falls += next < t ? 1 : 0;
    begins += here;
    begin += static_cast<std::uint32_t>(here * (i + 1));
    finite += t == t ? 1 : 0;
  }
  if (!celsius.empty()) {
    begins += celsius.front() == celsius.front() ? 1 : 0;
    finite += celsius.back() == celsius.back() ? 1 : 0;
  }
  if (falls != 0 || begins != 1) {
    return {};
  }
  return celsius.subspan(begin, static_cast<std::size_t>(finite));
}

/// What is above a threshold (hot) or below it (cold).
Band<float> band_of_temperatures(double threshold, Polarity polarity) {
  const auto t = static_cast<float>(threshold);
  constexpr auto kMost = static_cast<float>(kHottestBody);
  return polarity == Polarity::kHot
             ? Band<float>{std::nextafter(t, kMost), kMost, false}
             : Band<float>{static_cast<float>(-kZeroCelsius), std::nextafter(t, -kMost), false};
}

/// The same of counts: a grey level that stands for all that is not above is no pipe. `known`: the
/// part of the table `celsius` that rises.
template <class Pixel>
Band<Pixel> band_of_counts(std::span<const float> celsius, std::span<const float> known,
                           double threshold, Polarity polarity) {
  const auto before = known.data() - celsius.data();
  constexpr std::ptrdiff_t kCounts = std::ptrdiff_t{std::numeric_limits<Pixel>::max()} + 1;
  const auto reachable = known.first(
      static_cast<std::size_t>(std::clamp<std::ptrdiff_t>(kCounts - before, 0, std::ssize(known))));
  const bool hot = polarity == Polarity::kHot;
  const auto from = hot ? std::ranges::upper_bound(reachable, threshold) : reachable.begin();
  const auto to = hot ? reachable.end() : std::ranges::lower_bound(reachable, threshold);
  const auto count = [&](auto place) {
    return static_cast<Pixel>(before + (place - reachable.begin()));
  };
  return from == to ? Band<Pixel>{0, 0, true} : Band<Pixel>{count(from), count(to - 1), false};
}

template <class Pixel>
std::size_t bin_of(Pixel value) {
  if constexpr (std::is_same_v<Pixel, float>) {
    const double bin = (value - kFirstBin) * kBinsPerKelvin;
    return std::isfinite(bin) ? static_cast<std::size_t>(std::clamp(bin, 0.0, kBins - 1.0)) : 0;
  } else {
    return value;
  }
}

template <class Pixel>
double celsius_of_bin(std::size_t bin, const Scale<Pixel>& scale) {
  if constexpr (std::is_same_v<Pixel, float>) {
    return kFirstBin + (static_cast<double>(bin) + 0.5) / kBinsPerKelvin;
  } else {
    return scale(static_cast<Pixel>(bin));
  }
}

/// Smallest and largest value; NaN are left out.
template <class Pixel>
std::pair<Pixel, Pixel> extremes(const ImageView<Pixel>& image) {
  // Side by side, because a comparison of floats waits for the one before.
  constexpr int kLanes = 16;
  std::array<Pixel, kLanes> lows{};
  std::array<Pixel, kLanes> highs{};
  lows.fill(std::numeric_limits<Pixel>::max());
  highs.fill(std::numeric_limits<Pixel>::lowest());
  const auto take = [&](Pixel value, std::size_t lane) {
    // In this order a NaN is never taken.
    lows[lane] = value < lows[lane] ? value : lows[lane];
    highs[lane] = value > highs[lane] ? value : highs[lane];
  };
  for (int y = 0; y < image.height; ++y) {
    const Pixel* const row = image.row(y);
    int x = 0;
    for (; x + kLanes <= image.width; x += kLanes) {
      for (std::size_t lane = 0; lane < kLanes; ++lane) {
        take(row[static_cast<std::size_t>(x) + lane], lane);
      }
    }
    for (; x < image.width; ++x) {
      take(row[x], 0);
    }
  }
  return {*std::ranges::min_element(lows), *std::ranges::max_element(highs)};
}

/// Whether no value between these has a temperature. `known`: of the table, those that are some.
template <class Pixel>
bool has_none(const Scale<Pixel>& scale, std::span<const float> known, Pixel low, Pixel high) {
  if constexpr (std::is_same_v<Pixel, float>) {
    return low >= static_cast<float>(kHottestBody) || high <= static_cast<float>(-kZeroCelsius);
  } else {
    const auto first = static_cast<std::size_t>(known.data() - scale.celsius.data());
    return high < first || low >= first + known.size();
  }
}

/// Root mean square of the differences in a histogram, K; the largest, `kClippedPart` of all, are
/// clipped to the largest of the others.
double clipped_root_mean_square(std::span<const std::uint32_t> histogram) {
  double all = 0;
  for (const std::uint32_t count : histogram) {
    all += count;
  }
  double above = 0;
  std::size_t last = histogram.size() - 1;
  while (last > 0 && above + histogram[last] <= kClippedPart * all) {
    above += histogram[last--];
  }
  const auto square = [](std::size_t bin) {
    const double middle = (static_cast<double>(bin) + 0.5) / kBinsPerKelvin;
    return middle * middle;
  };
  double squares = above * square(last);
  for (std::size_t bin = 0; bin <= last; ++bin) {
    squares += histogram[bin] * square(bin);
  }
  return std::sqrt(squares / all);
}

/// What the pixels of a row differ from the means of the squares around them. `columns`: of each
/// column, the sum of the `rows` rows of the squares.
void differences_of_row(const float* row, const double* columns, int width, int radius, int rows,
                        float sign, float* differences) {
  double sum = 0;
  for (int x = 0; x < std::min(radius, width); ++x) {
    sum += columns[x];
  }
  const auto slide = [&](int x) {
    const double enters = x + radius < width ? columns[x + radius] : 0;
    const double leaves = x - radius - 1 >= 0 ? columns[x - radius - 1] : 0;
    sum += enters - leaves;
    const int count = rows * (std::min(x + radius, width - 1) - std::max(x - radius, 0) + 1);
    differences[x] = sign * (row[x] - static_cast<float>(sum / count));
  };
  int x = 0;
  for (; x < std::min(radius + 1, width); ++x) {
    slide(x);
  }
  // Away from the border by two: additions that wait for each other are what takes the time.
  const double share = 1.0 / (rows * (2.0 * radius + 1));
  for (; x + 1 + radius < width; x += 2) {
    const double first = columns[x + radius] - columns[x - radius - 1];
    const double second = columns[x + 1 + radius] - columns[x - radius];
    const double one = sum + first;
    sum += first + second;
    differences[x] = sign * (row[x] - static_cast<float>(one * share));
    differences[x + 1] = sign * (row[x + 1] - static_cast<float>(sum * share));
  }
  for (; x < width; ++x) {
    slide(x);
  }
}

}  // namespace

template <class Pixel>
FrameFault ThresholdMask::make(const ImageView<Pixel>& image, const Scale<Pixel>& scale,
                               const LeakDetectorParameters& parameters,
                               const FrameConditions& conditions) {
  threshold_ = kNan;
  if (!image.valid() || image.width > std::numeric_limits<std::int16_t>::max() ||
      image.height > std::numeric_limits<std::int16_t>::max()) {
    mask_.resize(0, 0);
    return FrameFault::kBadShape;
  }
  mask_.resize(image.width, image.height);
  const std::span<const float> known = rising_part(scale.celsius);
  if (!std::is_same_v<Pixel, float> && known.empty()) {
    return FrameFault::kBadTable;
  }
  const auto [low, high] = extremes(image);
  if (low > high || has_none(scale, known, low, high)) {
    return FrameFault::kNoTemperature;
  }
  if (low == high) {
    return FrameFault::kSaturated;
  }
  if (parameters.threshold_rule == ThresholdRule::kLocal) {
    make_local(image, scale, parameters);
    return FrameFault::kNone;
  }
  switch (parameters.threshold_rule) {
    case ThresholdRule::kScene:
      threshold_ = scene_threshold(image, scale, parameters);
      break;
    case ThresholdRule::kContrast:
      threshold_ = contrast_threshold(image, scale, parameters, conditions);
      break;
    case ThresholdRule::kFixed:
    case ThresholdRule::kLocal:
      threshold_ = parameters.threshold;
      break;
  }
  if (std::isnan(threshold_)) {
    return FrameFault::kNone;
  }
  Band<Pixel> band;
  if constexpr (std::is_same_v<Pixel, float>) {
    band = band_of_temperatures(threshold_, parameters.polarity);
  } else {
    band = band_of_counts<Pixel>(scale.celsius, known, threshold_, parameters.polarity);
  }
  if (band.empty || high < band.low || low > band.high) {
    return FrameFault::kNone;
  }
  for (int y = 0; y < image.height; ++y) {
    if constexpr (std::is_same_v<Pixel, float>) {
      set_bits(image.row(y), image.width, mask_.row(y),
               [band](float value) { return (value >= band.low) & (value <= band.high); });
    } else {
      const auto span = static_cast<Pixel>(band.high - band.low);
      set_bits(image.row(y), image.width, mask_.row(y),
               [band, span](Pixel value) { return static_cast<Pixel>(value - band.low) <= span; });
    }
  }
  return FrameFault::kNone;
}

/// At a share of the way from the surroundings of the tube to its level. A leak that is as long as
/// the picture does not raise it above what the tube has been in other pictures.
template <class Pixel>
double ThresholdMask::contrast_threshold(const ImageView<Pixel>& image, const Scale<Pixel>& scale,
                                         const LeakDetectorParameters& parameters,
                                         const FrameConditions& conditions) {
  const double sign = parameters.polarity == Polarity::kHot ? 1 : -1;
  Ridge ridge = ridges_.find(image, scale, parameters);
  if (conditions.sound && !conditions.levels) {
    const double sound = sign * conditions.sound->temperature;
    if (sound - ridge.side >= parameters.min_contrast) {
      ridge.level = std::min(ridge.level, sound);
    }
  }
  return sign * (ridge.side + parameters.contrast_level * (ridge.level - ridge.side));
}

/// Otsu (1979): the threshold with the largest variance between the classes. Of every second pixel
/// of every second row. Dead pixels, a thousandth at either end, have no say.
template <class Pixel>
double ThresholdMask::scene_threshold(const ImageView<Pixel>& image, const Scale<Pixel>& scale,
                                      const LeakDetectorParameters& parameters) {
  histogram_.assign(kBins, 0);
  std::uint32_t total = 0;
  for (int y = 0; y < image.height; y += 2) {
    const Pixel* const row = image.row(y);
    for (int x = 0; x < image.width; x += 2) {
      if (!std::isnan(scale(row[x]))) {
        ++histogram_[bin_of(row[x])];
        ++total;
      }
    }
  }
  const std::uint32_t outliers = total / 1000;
  std::size_t first = 0;
  for (std::uint32_t sum = 0; first < kBins; ++first) {
    sum += histogram_[first];
    if (sum > outliers) {
      break;
    }
  }
  std::size_t last = kBins - 1;
  for (std::uint32_t sum = 0; last > first; --last) {
    sum += histogram_[last];
    if (sum > outliers) {
      break;
    }
  }
  double count = 0;
  double sum = 0;
  for (std::size_t bin = first; bin <= last; ++bin) {
    if (histogram_[bin] != 0) {
      count += histogram_[bin];
      sum += histogram_[bin] * celsius_of_bin(bin, scale);
    }
  }
  double below = 0;
  double below_sum = 0;
  double best = 0;
  double contrast = 0;
  double threshold = kNan;
  for (std::size_t bin = first; bin < last; ++bin) {
    if (histogram_[bin] == 0) {
      continue;
    }
    below += histogram_[bin];
    below_sum += histogram_[bin] * celsius_of_bin(bin, scale);
    const double above = count - below;
    if (above <= 0) {
      break;
    }
    const double apart = (sum - below_sum) / above - below_sum / below;
    const double between = below * above * apart * apart;
    if (between > best) {
      best = between;
      contrast = apart;
      threshold = 0.5 * (celsius_of_bin(bin, scale) + celsius_of_bin(bin + 1, scale));
    }
  }
  return contrast >= parameters.min_contrast ? threshold : kNan;
}

/// Compares each pixel with the mean of the square around it, by sums that slide. What stands out
/// is measured by how much all pixels differ from their surroundings.
template <class Pixel>
void ThresholdMask::make_local(const ImageView<Pixel>& image, const Scale<Pixel>& scale,
                               const LeakDetectorParameters& parameters) {
  const auto width = static_cast<std::size_t>(image.width);
  const int radius =
      std::max(2, static_cast<int>(parameters.local_radius * std::min(image.width, image.height)));
  temperatures_.resize(width * static_cast<std::size_t>(image.height));
  differences_.resize(temperatures_.size());
  float known = 0;
  for (int y = 0; y < image.height; ++y) {
    float* const to = temperatures_.data() + static_cast<std::size_t>(y) * width;
    int missing = 0;
    for (int x = 0; x < image.width; ++x) {
      to[x] = scale(image(x, y));
      missing |= to[x] != to[x] ? 1 : 0;
    }
    for (int x = 0; missing != 0 && x < image.width; ++x) {
      to[x] = std::isnan(to[x]) ? known : to[x];
      known = to[x];
    }
    known = to[image.width - 1];
  }
  column_sums_.assign(width, 0.0);
  const auto row_of = [&](int y) {
    return temperatures_.data() + static_cast<std::size_t>(y) * width;
  };
  const auto take = [&](const float* row, double sign) {
    for (std::size_t x = 0; x < width; ++x) {
      column_sums_[x] += sign * row[x];
    }
  };
  for (int y = 0; y < std::min(radius, image.height); ++y) {
    take(row_of(y), 1);
  }
  const auto sign = parameters.polarity == Polarity::kHot ? 1.0F : -1.0F;
  histogram_.assign(kDifferenceBins, 0);
  for (int y = 0; y < image.height; ++y) {
    const bool enters = y + radius < image.height;
    const bool leaves = y - radius - 1 >= 0;
    if (enters && leaves) {
      const float* const entering = row_of(y + radius);
      const float* const leaving = row_of(y - radius - 1);
      for (std::size_t x = 0; x < width; ++x) {
        column_sums_[x] += double{entering[x]} - double{leaving[x]};
      }
    } else if (enters) {
      take(row_of(y + radius), 1);
    } else if (leaves) {
      take(row_of(y - radius - 1), -1);
    }
    const int rows = std::min(y + radius, image.height - 1) - std::max(y - radius, 0) + 1;
    differences_of_row(row_of(y), column_sums_.data(), image.width, radius, rows, sign,
                       differences_.data() + static_cast<std::size_t>(y) * width);
  }
  constexpr auto kLast = static_cast<float>(kDifferenceBins - 1);
  for (int y = 0; y < image.height; y += 2) {
    const float* const row = differences_.data() + static_cast<std::size_t>(y) * width;
    for (std::size_t x = 0; x < width; x += 2) {
      const float bin = std::abs(row[x]) * static_cast<float>(kBinsPerKelvin);
      ++histogram_[static_cast<std::size_t>(std::min(kLast, bin))];
    }
  }
  const auto least = static_cast<float>(
      std::max(parameters.min_contrast, kLocalFactor * clipped_root_mean_square(histogram_)));
  for (int y = 0; y < image.height; ++y) {
    set_bits(differences_.data() + static_cast<std::size_t>(y) * width, image.width, mask_.row(y),
             [least](float value) { return value >= least; });
  }
}

template FrameFault ThresholdMask::make(const TemperatureView&, const Scale<float>&,
                                        const LeakDetectorParameters&, const FrameConditions&);
template FrameFault ThresholdMask::make(const CountView&, const Scale<std::uint16_t>&,
                                        const LeakDetectorParameters&, const FrameConditions&);
template FrameFault ThresholdMask::make(const GreyView&, const Scale<std::uint8_t>&,
                                        const LeakDetectorParameters&, const FrameConditions&);

}  // namespace pipescout::thermal
