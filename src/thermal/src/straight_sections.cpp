// SPDX-License-Identifier: Apache-2.0
#include "straight_sections.hpp"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <utility>

namespace pipescout::thermal {
namespace {

/// Lines that a chain steps over: defects of the picture, a joint that mirrors the sky.
constexpr int kMaxStep = 4;
/// Points of a piece that is worth a line.
constexpr int kLeastPoints = 6;
/// Pieces that are looked at, the ones with most points.
constexpr std::size_t kMaxPieces = 128;
/// Widths of one pipe differ by no more.
constexpr double kWidthRatio = 1.6;

/// Pixels of which a middle or a width may be off when edges are ragged.
double slack(int length) {
  return 1.5 + 0.12 * length;
}

bool alike(double a, double b) {
  return std::abs(a - b) <= 3 || (a <= kWidthRatio * b && b <= kWidthRatio * a);
}

}  // namespace

void Straight::add(const Eigen::Vector2d& point, int chord_length, bool column) {
  if (points_ == 0) {
    origin_ = point;
    first_ = point;
  }
  last_ = point;
  ++points_;
  const Eigen::Vector2d d = point - origin_;
  sum_ += d;
  squares_ += d * d.transpose();
  (column ? column_lengths_ : row_lengths_) += chord_length;
}

void Straight::join(const Straight& other) {
  // The other's sums about this origin.
  const Eigen::Vector2d shift = other.origin_ - origin_;
  const double n = other.points_;
  squares_ += other.squares_ + other.sum_ * shift.transpose() + shift * other.sum_.transpose() +
              n * shift * shift.transpose();
  sum_ += other.sum_ + n * shift;
  points_ += other.points_;
  column_lengths_ += other.column_lengths_;
  row_lengths_ += other.row_lengths_;
  fit();
  for (const Eigen::Vector2d& point : {other.first_, other.last_}) {
    if (along(point) < along(first_)) {
      first_ = point;
    } else if (along(point) > along(last_)) {
      last_ = point;
    }
  }
  fit();
}

void Straight::fit() {
  const double n = points_;
  const Eigen::Vector2d mean = sum_ / n;
  const Eigen::Matrix2d spread = squares_ / n - mean * mean.transpose();
  const double angle = 0.5 * std::atan2(2 * spread(0, 1), spread(0, 0) - spread(1, 1));
  direction_ = {std::cos(angle), std::sin(angle)};
  const Eigen::Vector2d normal(-direction_.y(), direction_.x());
  deviation_ = std::sqrt(std::max(0.0, normal.dot(spread * normal)));
  if (direction_.dot(last_ - first_) < 0) {
    std::swap(first_, last_);
  }
  const Eigen::Vector2d centre = origin_ + mean;
  start_ = centre + direction_.dot(first_ - centre) * direction_;
  end_ = centre + direction_.dot(last_ - centre) * direction_;
  half_width_ =
      0.5 * (column_lengths_ * std::abs(direction_.x()) + row_lengths_ * std::abs(direction_.y())) /
      n;
}

void StraightSections::find(const MedialAxis& axis, const Limits& limits) {
  sections_.clear();
  for (const bool column : {true, false}) {
    const std::span<const Chord> chords = column ? axis.columns() : axis.rows();
    link(chords);
    for (const Chain& chain : finished_) {
      divide(chords, chain, column, limits);
    }
  }
  if (sections_.size() > kMaxPieces) {
    std::nth_element(sections_.begin(), sections_.begin() + kMaxPieces, sections_.end(),
                     [](const Straight& a, const Straight& b) { return a.points() > b.points(); });
    sections_.resize(kMaxPieces);
  }
  const auto longer = [](const Straight& a, const Straight& b) {
    return std::pair(a.length(), a.start().x()) > std::pair(b.length(), b.start().x());
  };
  std::sort(sections_.begin(), sections_.end(), longer);
  join(limits);
  drop_remains(limits);
  std::sort(sections_.begin(), sections_.end(), longer);
  sections_.resize(std::min(sections_.size(), limits.max_sections));
}

/// Each chord goes to the chain whose course it continues best.
void StraightSections::link(std::span<const Chord> chords) {
  next_.assign(chords.size(), -1);
  active_.clear();
  finished_.clear();
  int line = -1;
  for (int i = 0; i < static_cast<int>(chords.size()); ++i) {
    const Chord& chord = chords[static_cast<std::size_t>(i)];
    if (chord.line != line) {
      line = chord.line;
      std::erase_if(active_, [&](const Chain& chain) {
        const bool over = line - chords[static_cast<std::size_t>(chain.tail)].line > kMaxStep;
        if (over && chain.count >= kLeastPoints) {
          finished_.push_back(chain);
        }
        return over;
      });
    }
    Chain* best = nullptr;
    double least = slack(chord.length());
    for (Chain& chain : active_) {
      const Chord& tail = chords[static_cast<std::size_t>(chain.tail)];
      const int step = line - tail.line;
      if (step == 0 || tail.cut != chord.cut || !alike(tail.length(), chord.length())) {
        continue;
      }
      const double off = std::abs(chord.middle() - (chain.middle + step * chain.slope));
      if (off <= least) {
        least = off;
        best = &chain;
      }
    }
    if (best == nullptr) {
      active_.push_back({i, i, 1, chord.middle(), 0});
      continue;
    }
    // Both follow slowly: single middles are half a pixel off and more.
    const int step = line - chords[static_cast<std::size_t>(best->tail)].line;
    const double predicted = best->middle + step * best->slope;
    const double off = chord.middle() - predicted;
    const double gain = std::max(0.15, 1.0 / (best->count + 1));
    best->middle = predicted + std::max(0.3, gain) * off;
    best->slope = std::clamp(best->slope + 0.5 * gain * off / step, -1.3, 1.3);
    next_[static_cast<std::size_t>(best->tail)] = i;
    best->tail = i;
    ++best->count;
  }
  for (const Chain& chain : active_) {
    if (chain.count >= kLeastPoints) {
      finished_.push_back(chain);
    }
  }
}

/// Divides a chain at the point farthest from the line between its ends (Ramer 1972, Douglas and
/// Peucker 1973) until all are near.
void StraightSections::divide(std::span<const Chord> chords, const Chain& chain, bool column,
                              const Limits& limits) {
  order_.clear();
  for (int i = chain.head; i >= 0; i = next_[static_cast<std::size_t>(i)]) {
    order_.push_back(i);
  }
  const auto chord_at = [&](int i) -> const Chord& {
    return chords[static_cast<std::size_t>(order_[static_cast<std::size_t>(i)])];
  };
  pending_.clear();
  pending_.push_back({0, static_cast<int>(order_.size()) - 1});
  while (!pending_.empty()) {
    const auto [first, last] = pending_.back();
    pending_.pop_back();
    if (last - first + 1 < kLeastPoints) {
      continue;
    }
    const Chord& a = chord_at(first);
    const Chord& b = chord_at(last);
    const double slope = (b.middle() - a.middle()) / (b.line - a.line);
    const double to_distance = 1 / std::sqrt(1 + slope * slope);
    double farthest = limits.straightness;
    int at = -1;
    for (int i = first + 1; i < last; ++i) {
      const Chord& c = chord_at(i);
      const double off =
          to_distance * std::abs(c.middle() - (a.middle() + slope * (c.line - a.line)));
      if (off > farthest) {
        farthest = off;
        at = i;
      }
    }
    if (at >= 0) {
      pending_.push_back({at, last});
      pending_.push_back({first, at});
      continue;
    }
    Straight piece;
    piece.cut = a.cut;
    for (int i = first; i <= last; ++i) {
      const Chord& c = chord_at(i);
      const double line = c.line;
      piece.add(column ? Eigen::Vector2d(line, c.middle()) : Eigen::Vector2d(c.middle(), line),
                c.length(), column);
    }
    piece.fit();
    sections_.push_back(piece);
  }
}

/// Joins a piece to a longer one when both lie on the line of the two together and the gap between
/// them is not too wide; pieces of the same place, by columns and by rows, join likewise.
void StraightSections::join(const Limits& limits) {
  for (std::size_t i = 0; i < sections_.size(); ++i) {
    for (std::size_t j = i + 1; j < sections_.size();) {
      const Straight& a = sections_[i];
      const Straight& b = sections_[j];
      const double tolerance = limits.straightness + 0.15 * a.half_width();
      const auto near = [&](const Straight& line, const Straight& piece) {
        return std::abs(line.offset(piece.start())) <= tolerance &&
               std::abs(line.offset(piece.end())) <= tolerance;
      };
      const auto gap = [&] {
        const double low = std::min(a.along(b.start()), a.along(b.end()));
        const double high = std::max(a.along(b.start()), a.along(b.end()));
        return std::max(low - a.length(), -high);
      };
      // A short piece far away is no evidence of a pipe in between.
      const double reach = std::min(limits.max_gap, 0.5 * (a.length() + b.length()));
      bool joins =
          a.cut == b.cut && alike(2 * a.half_width(), 2 * b.half_width()) && gap() <= reach;
      if (joins) {
        Straight both = a;
        both.join(b);
        joins = near(both, a) && near(both, b) && both.deviation() <= limits.straightness;
        if (joins) {
          sections_[i] = both;
          sections_.erase(sections_.begin() + static_cast<std::ptrdiff_t>(j));
          j = i + 1;  // the line has changed: those passed over may fit now
          continue;
        }
      }
      ++j;
    }
  }
}

/// Drops what is too short, and what the border leaves of a pipe that is seen whole before it gets
/// there.
void StraightSections::drop_remains(const Limits& limits) {
  std::erase_if(sections_, [&](const Straight& s) {
    return s.length() < limits.min_length ||
           s.length() < limits.min_elongation * 2 * s.half_width();
  });
  order_.clear();
  for (std::size_t i = 0; i < sections_.size(); ++i) {
    const Straight& remains = sections_[i];
    for (const Straight& whole : sections_) {
      const double reach = 4 * whole.half_width() + kMaxStep;
      const auto touches = [&](const Eigen::Vector2d& end) {
        return (end - remains.start()).norm() < reach || (end - remains.end()).norm() < reach;
      };
      if (remains.cut && !whole.cut && whole.length() > 0.5 * remains.length() &&
          (touches(whole.start()) || touches(whole.end()))) {
        order_.push_back(static_cast<int>(i));
        break;
      }
    }
  }
  for (auto it = order_.rbegin(); it != order_.rend(); ++it) {
    sections_.erase(sections_.begin() + *it);
  }
}

}  // namespace pipescout::thermal
