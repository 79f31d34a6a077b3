// SPDX-License-Identifier: Apache-2.0
#include "pipescout/thermal/pipe_profile.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "pipescout/statistics/quantile.hpp"

namespace pipescout::thermal {
namespace {

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
/// A part that creeps by Delta-T is halved as often at most: ten times Delta-T and more.
constexpr int kHalvings = 4;
/// Of what makes a leak: by as much the pipe may be warmer than it is known to be.
constexpr double kReferenceSlack = 0.5;

/// Of the spread of the sound pipe, and how many standard deviations of a normal distribution lie
/// between them.
constexpr double kLowerQuantile = 0.1;
constexpr double kUpperQuantile = 0.4;
constexpr double kQuantileDistance = 1.0282;

/// The sample that a place lies in.
int sample_at(double place, std::size_t size) {
  return std::clamp(static_cast<int>(std::floor(place)), 0, static_cast<int>(size) - 1);
}

/// Of a stretch, what has the shape of the pipe.
double shaped_width(std::span<const float> t, std::span<const std::uint8_t> pipe_shaped,
                    const LeakStretch& stretch) {
  const double width = stretch.to - stretch.from;
  if (pipe_shaped.empty()) {
    return width;
  }
  const int last = sample_at(std::nextafter(stretch.to, stretch.from), t.size());
  const auto others = std::count(pipe_shaped.begin() + sample_at(stretch.from, t.size()),
                                 pipe_shaped.begin() + last + 1, std::uint8_t{0});
  return width - static_cast<double>(others);
}

/// Where the line through the middles of samples i and i + 1 takes a value.
double crossing(std::span<const float> t, int i, double level) {
  const auto k = static_cast<std::size_t>(i);
  const double rise = t[k + 1] - t[k];
  return i + 0.5 + std::clamp((level - t[k]) / rise, 0.0, 1.0);
}

/// Where a rise to `level` at sample `i` begins, before (`step` -1) or behind (1) it; NaN where
/// that is hidden, or beyond `last`.
double onset_of(std::span<const float> t, int i, int last, int step, double level) {
  while (i != last) {
    const double next = t[static_cast<std::size_t>(i + step)];
    if (!std::isfinite(next)) {
      return kNan;
    }
    if (next < level) {
      return t[static_cast<std::size_t>(i)] < level ? kNan
                                                    : crossing(t, std::min(i, i + step), level);
    }
    i += step;
  }
  return kNan;
}

/// Mean and deviation of samples one after the other.
class Moments {
 public:
  void add(double value) {
    ++count_;
    const double before = value - mean_;
    mean_ += before / static_cast<double>(count_);
    squares_ += before * (value - mean_);
  }
  [[nodiscard]] double mean() const { return count_ == 0 ? kNan : mean_; }
  [[nodiscard]] double deviation() const {
    return count_ == 0 ? kNan : std::sqrt(squares_ / static_cast<double>(count_));
  }

 private:
  std::size_t count_ = 0;
  double mean_ = 0;
  double squares_ = 0;
};

}  // namespace

void absolute_change(std::span<const float> temperatures, int distance,
                     std::vector<float>& change) {
  const auto d = static_cast<std::size_t>(std::max(distance, 1));
  change.clear();
  for (std::size_t i = 0; i + d < temperatures.size(); ++i) {
    change.push_back(std::abs(temperatures[i + d] - temperatures[i]));
  }
}

ProfileAnalysis::ProfileAnalysis(const ProfileParameters& parameters) : parameters_(parameters) {
  parameters_.validate();
}

void ProfileAnalysis::analyse(std::span<const float> temperatures,
                              std::span<const std::uint8_t> pipe_shaped,
                              const Conditions& conditions) {
  parts_.clear();
  leaks_.clear();
  least_width_ = parameters_.min_part_width;
  if (conditions.metres_per_sample > 0) {
    least_width_ = std::max(ProfileParameters::kLeastSamples,
                            parameters_.min_part_width_m / conditions.metres_per_sample);
  }
  collect(temperatures, pipe_shaped);
  reference_ = quantile(parameters_.reference_quantile);
  // Between two low quantiles, that neither a leak nor a cold joint reaches.
  spread_ = (quantile(kUpperQuantile) - quantile(kLowerQuantile)) / kQuantileDistance;
  choose_rise(conditions);
  if (conditions.reference_temperature &&
      !(reference_ <= *conditions.reference_temperature + kReferenceSlack * least_rise())) {
    reference_ = *conditions.reference_temperature;
  }
  divide(temperatures);
  if (parameters_.split_creeping) {
    divide_creeping(temperatures);
  }
  label(temperatures, pipe_shaped);
  join_leaks(temperatures);
}

double ProfileAnalysis::least_rise() const {
  return parameters_.leak_delta ? rise_ : split_;
}

void ProfileAnalysis::choose_rise(const Conditions& conditions) {
  split_ = parameters_.split_delta;
  rise_ = parameters_.leak_delta.value_or(split_);
  const double spread = conditions.spread.value_or(std::isfinite(spread_) ? spread_ : 0);
  const double least =
      std::max(parameters_.leak_spreads * spread, parameters_.leak_share * conditions.contrast);
  if (least > rise_) {
    split_ *= least / rise_;
    rise_ = least;
  }
}

void ProfileAnalysis::collect(Temperatures t, Shapes pipe_shaped) {
  shown_.clear();
  for (std::size_t i = 0; i < t.size(); ++i) {
    if (std::isfinite(t[i]) && (pipe_shaped.empty() || pipe_shaped[i] != 0)) {
      shown_.push_back(t[i]);
    }
  }
}

double ProfileAnalysis::quantile(double share) {
  return shown_.empty() ? kNan : statistics::quantile_in_place(shown_, share);
}

void ProfileAnalysis::divide(Temperatures t) {
  const int size = static_cast<int>(t.size());
  for (int from = 0; from < size;) {
    const bool seen = std::isfinite(t[static_cast<std::size_t>(from)]);
    int to = from + 1;
    while (to < size && std::isfinite(t[static_cast<std::size_t>(to)]) == seen) {
      ++to;
    }
    if (seen) {
      divide_at_edges(t, from, to);
    } else {
      parts_.push_back({static_cast<double>(from), static_cast<double>(to), kNan, kNan, kNan,
                        PartKind::kHidden});
    }
    from = to;
  }
}

/// Samples that change alike by Delta-T, one after the other, are one edge. It lies at the centre
/// of gravity of the change.
void ProfileAnalysis::divide_at_edges(Temperatures t, int from, int to) {
  const auto at = [&](int i) { return static_cast<double>(t[static_cast<std::size_t>(i)]); };
  const int d = parameters_.split_distance;
  const auto sign = [&](int i) {
    const double change = at(i + d) - at(i);
    return change >= split_ ? 1 : change <= -split_ ? -1 : 0;
  };
  double start = from;
  for (int i = from; i + d < to;) {
    const int direction = sign(i);
    if (direction == 0) {
      ++i;
      continue;
    }
    int last = i;
    while (last + 1 + d < to && sign(last + 1) == direction) {
      ++last;
    }
    double weight = 0;
    double moment = 0;
    for (int j = i; j < last + d; ++j) {
      const double change = std::max(0.0, direction * (at(j + 1) - at(j)));
      weight += change;
      moment += change * (j + 1);
    }
    const double edge = moment / weight;
    if (edge > start + 0.5 && edge < to - 0.5) {
      parts_.push_back({start, edge, 0, 0, 0, PartKind::kPipe});
      measure(t, parts_.back());
      start = edge;
    }
    i = last + 1;
  }
  parts_.push_back({start, static_cast<double>(to), 0, 0, 0, PartKind::kPipe});
  measure(t, parts_.back());
}

void ProfileAnalysis::divide_creeping(Temperatures t) {
  for (int halving = 0; halving < kHalvings; ++halving) {
    scratch_.clear();
    for (const PipePart& part : parts_) {
      const double width = part.to - part.from;
      const double margin = std::min(0.5 * parameters_.split_distance, 0.25 * width);
      const int first = sample_at(part.from + margin, t.size());
      const int last = sample_at(part.to - margin, t.size());
      if (part.kind == PartKind::kHidden || last - first < 2) {
        scratch_.push_back(part);
        continue;
      }
      const auto [least, most] = std::minmax_element(t.begin() + first, t.begin() + last + 1);
      if (*most - *least <= split_) {
        scratch_.push_back(part);
        continue;
      }
      const double level = 0.5 * (*most + *least);
      double start = part.from;
      for (int i = first; i < last; ++i) {
        const auto k = static_cast<std::size_t>(i);
        if ((t[k] < level) != (t[k + 1] < level)) {
          const double edge = crossing(t, i, level);
          scratch_.push_back({start, edge, 0, 0, 0, PartKind::kPipe});
          measure(t, scratch_.back());
          start = edge;
        }
      }
      scratch_.push_back({start, part.to, 0, 0, 0, PartKind::kPipe});
      measure(t, scratch_.back());
    }
    const bool divided = scratch_.size() != parts_.size();
    std::swap(parts_, scratch_);
    if (!divided) {
      return;
    }
  }
}

void ProfileAnalysis::measure(Temperatures t, PipePart& part) const {
  const double width = part.to - part.from;
  const double margin = std::min(0.5 * parameters_.split_distance, 0.25 * width);
  Moments moments;
  part.peak = -std::numeric_limits<double>::infinity();
  const int last = sample_at(std::nextafter(part.to, part.from), t.size());
  for (int i = sample_at(part.from, t.size()); i <= last; ++i) {
    const double value = t[static_cast<std::size_t>(i)];
    const double middle = i + 0.5;
    part.peak = std::max(part.peak, value);
    if (middle >= part.from + margin && middle <= part.to - margin) {
      moments.add(value);
    }
  }
  part.mean = moments.mean();
  part.deviation = moments.deviation();
  if (std::isnan(part.mean)) {  // less than a sample wide
    part.mean = t[static_cast<std::size_t>(sample_at(0.5 * (part.from + part.to), t.size()))];
    part.deviation = 0;
  }
}

bool ProfileAnalysis::is_warm(const PipePart& part) const {
  return part.kind != PartKind::kHidden &&
         ((parameters_.leak_delta && part.mean >= reference_ + rise_) ||
          (parameters_.maximum_temperature && part.mean > *parameters_.maximum_temperature));
}

void ProfileAnalysis::label(Temperatures t, Shapes pipe_shaped) {
  for (PipePart& part : parts_) {
    if (part.kind == PartKind::kHidden) {
      continue;
    }
    if (!pipe_shaped.empty()) {
      const int first = sample_at(part.from, t.size());
      const int last = sample_at(std::nextafter(part.to, part.from), t.size());
      const auto shaped = std::count_if(pipe_shaped.begin() + first, pipe_shaped.begin() + last + 1,
                                        [](std::uint8_t value) { return value != 0; });
      if (2 * shaped < last - first + 1) {
        part.kind = PartKind::kNotThisPipe;
        continue;
      }
    }
    part.kind = part.to - part.from < least_width_ ? PartKind::kShort : PartKind::kPipe;
  }
  const auto leaks = [this](const PipePart& part) {
    return part.kind != PartKind::kNotThisPipe && is_warm(part);
  };
  for (std::size_t first = 0; first < parts_.size(); ++first) {
    if (!leaks(parts_[first])) {
      continue;
    }
    std::size_t last = first;
    while (last + 1 < parts_.size() && leaks(parts_[last + 1])) {
      ++last;
    }
    label_warm(t, pipe_shaped, first, last);
    first = last;
  }
}

/// Parts `first` to `last` are warm and touch. How wide they are is taken half-way up: that does
/// not depend on blur.
void ProfileAnalysis::label_warm(Temperatures t, Shapes pipe_shaped, std::size_t first,
                                 std::size_t last) {
  LeakStretch stretch{.from = parts_[first].from, .to = parts_[last].to};
  double weight = 0;
  double squares = 0;
  stretch.peak = -std::numeric_limits<double>::infinity();
  for (std::size_t i = first; i <= last; ++i) {
    const double width = parts_[i].to - parts_[i].from;
    weight += width;
    stretch.mean += width * parts_[i].mean;
    squares +=
        width * (parts_[i].mean * parts_[i].mean + parts_[i].deviation * parts_[i].deviation);
    stretch.peak = std::max(stretch.peak, parts_[i].peak);
  }
  stretch.mean /= weight;
  stretch.deviation = std::sqrt(std::max(0.0, squares / weight - stretch.mean * stretch.mean));

  const double base = std::isfinite(reference_) ? std::min(reference_, stretch.mean) : stretch.mean;
  const double level = 0.5 * (base + stretch.mean);
  const auto above = [&](int i) {
    return i >= 0 && i < static_cast<int>(t.size()) && t[static_cast<std::size_t>(i)] >= level;
  };
  const auto known = [&](int i) {
    return i >= 0 && i < static_cast<int>(t.size()) &&
           std::isfinite(t[static_cast<std::size_t>(i)]);
  };
  // Not into another body: the flank of what stands before the pipe is no leak.
  const int reach = static_cast<int>(std::ceil(least_width_));
  const bool body_before = first > 0 && parts_[first - 1].kind == PartKind::kNotThisPipe;
  const bool body_behind =
      last + 1 < parts_.size() && parts_[last + 1].kind == PartKind::kNotThisPipe;
  const int middle = sample_at(0.5 * (stretch.from + stretch.to), t.size());
  int start = sample_at(stretch.from, t.size());
  const int earliest = body_before ? start : start - reach;
  while (start < middle && !above(start)) {
    ++start;
  }
  while (start > earliest && above(start - 1)) {
    --start;
  }
  int end = sample_at(std::nextafter(stretch.to, stretch.from), t.size());
  const int latest = body_behind ? end : end + reach;
  while (end > middle && !above(end)) {
    --end;
  }
  while (end < latest && above(end + 1)) {
    ++end;
  }
  // What hides the pipe, or the border, blurs: an edge as near to it may be its own.
  const int blur = parameters_.split_distance;
  stretch.open_at_start = !known(start - blur);
  stretch.open_at_end = !known(end + blur);
  stretch.from = !known(start - 1) || above(start - 1) || !above(start)
                     ? start
                     : crossing(t, start - 1, level);
  stretch.to = !known(end + 1) || above(end + 1) || !above(end) ? end + 1 : crossing(t, end, level);
  const double onset = std::min(level, base + kReferenceSlack * least_rise());
  stretch.onset_from = onset_of(t, start, body_before ? earliest : 0, -1, onset);
  stretch.onset_to =
      onset_of(t, end, body_behind ? latest : static_cast<int>(t.size()) - 1, 1, onset);

  // A joint beside a warm post is no leak, though together they are as long as one.
  const bool leak = shaped_width(t, pipe_shaped, stretch) >= least_width_;
  for (std::size_t i = first; i <= last; ++i) {
    parts_[i].kind = leak ? PartKind::kLeak : PartKind::kShort;
  }
  if (leak) {
    leaks_.push_back(stretch);
  }
}

/// What lies between two stretches belongs to them when it is shorter than a part of the pipe.
void ProfileAnalysis::join_leaks(Temperatures t) {
  std::size_t kept = 0;
  for (std::size_t i = 1; i < leaks_.size(); ++i) {
    LeakStretch& before = leaks_[kept];
    const LeakStretch& next = leaks_[i];
    const auto hidden = std::any_of(t.begin() + sample_at(before.to, t.size()),
                                    t.begin() + sample_at(next.from, t.size()),
                                    [](float value) { return !std::isfinite(value); });
    if (next.from - before.to >= least_width_ || hidden) {
      leaks_[++kept] = next;
      continue;
    }
    const double a = before.to - before.from;
    const double b = next.to - next.from;
    const double apart = next.mean - before.mean;
    before.deviation =
        std::sqrt((a * before.deviation * before.deviation + b * next.deviation * next.deviation +
                   a * b / (a + b) * apart * apart) /
                  (a + b));
    before.mean += b / (a + b) * apart;
    before.peak = std::max(before.peak, next.peak);
    before.to = next.to;
    before.onset_to = next.onset_to;
    before.open_at_end = next.open_at_end;
  }
  if (!leaks_.empty()) {
    leaks_.resize(kept + 1);
  }
}

}  // namespace pipescout::thermal
