// SPDX-License-Identifier: Apache-2.0
#include "medial_axis.hpp"

#include <bit>

namespace pipescout::thermal {
namespace {

/// A chord is kept up to this ratio to the one across: both of a strip at 45 degrees are, with
/// edges that are a pixel off.
constexpr int kTieNumerator = 5;
constexpr int kTieDenominator = 4;
/// Chords for each row and column that pipes make at most.
constexpr std::size_t kChordsPerLine = 16;

/// Set pixels in the row from (x, y) on in both directions, at most `enough`.
int row_run(const BitMask& mask, int x, int y, int enough) {
  const std::uint64_t* const row = mask.row(y);
  int count = 1;
  for (int i = x + 1; i < mask.width() && count < enough;) {
    const int ones = std::countr_one(row[i >> 6] >> (i & 63));
    count += ones;
    if (ones < 64 - (i & 63)) {
      break;
    }
    i += ones;
  }
  for (int i = x - 1; i >= 0 && count < enough;) {
    const int ones = std::countl_one(row[i >> 6] << (63 - (i & 63)));
    count += ones;
    if (ones < (i & 63) + 1) {
      break;
    }
    i -= ones;
  }
  return count;
}

int column_run(const BitMask& mask, int x, int y, int enough) {
  int count = 1;
  for (int i = y + 1; i < mask.height() && count < enough && mask.get(x, i); ++i) {
    ++count;
  }
  for (int i = y - 1; i >= 0 && count < enough && mask.get(x, i); --i) {
    ++count;
  }
  return count;
}

/// The least length across with which a chord is the short way.
int least_across(int length) {
  return (length * kTieDenominator + kTieNumerator - 1) / kTieNumerator;
}

}  // namespace

bool MedialAxis::find(const BitMask& mask, const Limits& limits) {
  columns_.clear();
  rows_.clear();
  capacity_ = kChordsPerLine * static_cast<std::size_t>(mask.width() + mask.height());
  if (find_columns(mask, limits) && find_rows(mask, limits)) {
    return true;
  }
  columns_.clear();
  rows_.clear();
  return false;
}

/// Where a row differs from the one before, runs of columns begin or end.
bool MedialAxis::find_columns(const BitMask& mask, const Limits& limits) {
  const int width = mask.width();
  const int height = mask.height();
  open_.resize(static_cast<std::size_t>(width));
  positions_.assign(static_cast<std::size_t>(width) + 1, 0);
  unsorted_.clear();
  for (int y = 0; y <= height; ++y) {
    const std::uint64_t* const row = y < height ? mask.row(y) : nullptr;
    const std::uint64_t* const before = y > 0 ? mask.row(y - 1) : nullptr;
    for (std::size_t w = 0; w < mask.words_per_row(); ++w) {
      const std::uint64_t here = row != nullptr ? row[w] : 0;
      std::uint64_t changes = here ^ (before != nullptr ? before[w] : 0);
      for (; changes != 0; changes &= changes - 1) {
        const int bit = std::countr_zero(changes);
        const std::size_t x = 64 * w + static_cast<std::size_t>(bit);
        if (((here >> bit) & 1U) != 0) {
          open_[x] = static_cast<std::int16_t>(y);
          continue;
        }
        const int from = open_[x];
        const int length = y - from;
        if (length < limits.least || length > limits.most) {
          continue;
        }
        const int enough = least_across(length);
        if (row_run(mask, static_cast<int>(x), from + (length - 1) / 2, enough) < enough) {
          continue;
        }
        if (unsorted_.size() == capacity_) {
          return false;
        }
        unsorted_.push_back({static_cast<std::int16_t>(x), static_cast<std::int16_t>(from),
                             static_cast<std::int16_t>(y - 1), from == 0 || y == height});
        ++positions_[x + 1];
      }
    }
  }
  for (std::size_t x = 1; x < positions_.size(); ++x) {
    positions_[x] += positions_[x - 1];
  }
  columns_.resize(unsorted_.size());
  for (const Chord& chord : unsorted_) {
    columns_[positions_[static_cast<std::size_t>(chord.line)]++] = chord;
  }
  return true;
}

bool MedialAxis::find_rows(const BitMask& mask, const Limits& limits) {
  const int width = mask.width();
  for (int y = 0; y < mask.height(); ++y) {
    const std::uint64_t* const row = mask.row(y);
    std::uint64_t last = 0;  // the bit to the left of the word
    int from = 0;
    const auto end_run = [&](int x) {
      const int length = x - from;
      if (length < limits.least || length > limits.most) {
        return true;
      }
      const int enough = least_across(length);
      if (column_run(mask, from + (length - 1) / 2, y, enough) < enough) {
        return true;
      }
      if (rows_.size() == capacity_) {
        return false;
      }
      rows_.push_back({static_cast<std::int16_t>(y), static_cast<std::int16_t>(from),
                       static_cast<std::int16_t>(x - 1), from == 0 || x == width});
      return true;
    };
    for (std::size_t w = 0; w < mask.words_per_row(); ++w) {
      const std::uint64_t here = row[w];
      for (std::uint64_t changes = here ^ (here << 1 | last); changes != 0;
           changes &= changes - 1) {
        const int bit = std::countr_zero(changes);
        const int x = static_cast<int>(64 * w) + bit;
        if (((here >> bit) & 1U) != 0) {
          from = x;
        } else if (!end_run(x)) {
          return false;
        }
      }
      last = here >> 63;
    }
    // A width that is no multiple of 64 ends its runs by its zero bits.
    if (last != 0 && !end_run(width)) {
      return false;
    }
  }
  return true;
}

}  // namespace pipescout::thermal
