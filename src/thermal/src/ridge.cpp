// SPDX-License-Identifier: Apache-2.0
#include "ridge.hpp"

#include <algorithm>
#include <cmath>

#include "pipescout/statistics/quantile.hpp"

namespace pipescout::thermal {
namespace {

using statistics::quantile_in_place;

constexpr int kProbes = 32;            // columns, and as many rows
constexpr double kLeastInliers = 0.5;  // of the probes, that are on one line
/// Of the width of a ridge: what lies between it and its sides, for blur.
constexpr double kBlurredEdge = 0.25;

/// Of the levels along a ridge: a leak may be over four fifths of it.
constexpr double kSoundQuantile = 0.2;

}  // namespace

template <class Pixel>
Ridge RidgeFinder::find(const ImageView<Pixel>& image, const Scale<Pixel>& scale,
                        const LeakDetectorParameters& parameters) {
  double longest = 0;
  best_.clear();
  for (const bool columns : {true, false}) {
    find_crests(image, scale, parameters, columns);
    const double length = keep_line();
    if (length > longest) {
      longest = length;
      std::swap(best_, crests_);
    }
  }
  return levels();
}

template <class Pixel>
void RidgeFinder::find_crests(const ImageView<Pixel>& image, const Scale<Pixel>& scale,
                              const LeakDetectorParameters& parameters, bool columns) {
  const int probes_over = columns ? image.width : image.height;
  const int length = columns ? image.height : image.width;
  const int most_width =
      static_cast<int>(parameters.max_width * std::min(image.width, image.height));
  const double sign = parameters.polarity == Polarity::kHot ? 1 : -1;
  crests_.clear();
  for (int probe = 0; probe < std::min(kProbes, probes_over); ++probe) {
    const int along = (2 * probe + 1) * probes_over / (2 * std::min(kProbes, probes_over));
    sums_.assign(1, 0.0);
    double known = 0;
    for (int i = 0; i < length; ++i) {
      const double value = scale(columns ? image(along, i) : image(i, along));
      known = std::isfinite(value) ? sign * value : known;
      sums_.push_back(sums_.back() + known);
    }
    add_crest(along, most_width, parameters);
  }
}

/// Of one column or row: over all places and widths. The three parts are as wide as each other, so
/// that sums are compared and not means.
void RidgeFinder::add_crest(double along, int most_width,
                            const LeakDetectorParameters& parameters) {
  const int length = static_cast<int>(sums_.size()) - 1;
  Crest best;
  double most = parameters.min_contrast;
  const int least_width = std::max(3, static_cast<int>(std::ceil(parameters.min_width)));
  for (int width = least_width; width <= most_width; width += std::max(1, width / 2)) {
    const int gap = std::max(1, static_cast<int>(std::lround(kBlurredEdge * width)));
    const auto sum = [this, width](int from) {
      const double* const first = sums_.data() + from;
      return first[width] - *first;
    };
    double least_rise = most * width;
    for (int from = width + gap; from + 2 * width + gap <= length; ++from) {
      const double level = sum(from);
      const double side = std::max(sum(from - gap - width), sum(from + width + gap));
      if (level - side > least_rise) {
        least_rise = level - side;
        best = {from + 0.5 * (width - 1), along, level / width, side / width,
                static_cast<double>(width)};
      }
    }
    most = least_rise / width;
  }
  if (best.width > 0) {
    crests_.push_back(best);
  }
}

/// By medians of slopes (Theil 1950, Sen 1968) between crests half of the picture apart.
double RidgeFinder::keep_line() {
  const std::size_t half = kProbes / 2;
  if (crests_.size() < half + 2) {
    return 0;
  }
  values_.clear();
  for (std::size_t i = 0; i + half < crests_.size(); ++i) {
    values_.push_back((crests_[i + half].across - crests_[i].across) /
                      (crests_[i + half].along - crests_[i].along));
  }
  const double slope = quantile_in_place(values_, 0.5);
  values_.clear();
  for (const Crest& crest : crests_) {
    values_.push_back(crest.across - slope * crest.along);
  }
  const double start = quantile_in_place(values_, 0.5);
  std::erase_if(crests_, [&](const Crest& crest) {
    return std::abs(crest.across - slope * crest.along - start) > std::max(3.0, crest.width);
  });
  if (static_cast<double>(crests_.size()) < kLeastInliers * kProbes) {
    return 0;
  }
  return (crests_.back().along - crests_.front().along) * std::hypot(1, slope) *
         static_cast<double>(crests_.size()) / kProbes;
}

Ridge RidgeFinder::levels() {
  if (best_.empty()) {
    return {};
  }
  const auto of = [this](double Crest::*field, double share) {
    values_.clear();
    for (const Crest& crest : best_) {
      values_.push_back(crest.*field);
    }
    return quantile_in_place(values_, share);
  };
  return {of(&Crest::level, kSoundQuantile), of(&Crest::side, 0.5)};
}

template Ridge RidgeFinder::find(const TemperatureView&, const Scale<float>&,
                                 const LeakDetectorParameters&);
template Ridge RidgeFinder::find(const CountView&, const Scale<std::uint16_t>&,
                                 const LeakDetectorParameters&);
template Ridge RidgeFinder::find(const GreyView&, const Scale<std::uint8_t>&,
                                 const LeakDetectorParameters&);

}  // namespace pipescout::thermal
