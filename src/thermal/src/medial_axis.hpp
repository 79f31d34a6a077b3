// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "bit_mask.hpp"

namespace pipescout::thermal {

/// A run of set pixels along a column or a row.
struct Chord {
  std::int16_t line = 0;  ///< x of the column, or y of the row
  std::int16_t from = 0;  ///< first pixel
  std::int16_t to = 0;    ///< last pixel
  bool cut = false;       ///< it ends at the border of the picture: it may be longer

  [[nodiscard]] double middle() const { return 0.5 * (from + to); }
  [[nodiscard]] int length() const { return to - from + 1; }
};

/// The middles of the chords that cross what is set the short way: columns that are not longer than
/// the row through their middle, and rows likewise; of a direction between, both. On a strip with
/// parallel edges these are its medial axis, whatever its direction.
class MedialAxis {
 public:
  struct Limits {
    double least = 3;   ///< pixels, of a chord
    double most = 170;  ///< pixels, of a chord
  };

  /// Returns false, with nothing found, when there are more chords than pipes make.
  bool find(const BitMask& mask, const Limits& limits);

  /// By line, then by place.
  [[nodiscard]] std::span<const Chord> columns() const noexcept { return columns_; }
  [[nodiscard]] std::span<const Chord> rows() const noexcept { return rows_; }

 private:
  bool find_columns(const BitMask& mask, const Limits& limits);
  bool find_rows(const BitMask& mask, const Limits& limits);

  std::size_t capacity_ = 0;
  std::vector<std::int16_t> open_;        // of each column, where the run began that is not over
  std::vector<std::uint32_t> positions_;  // of each column, in the sorted list
  std::vector<Chord> unsorted_;
  std::vector<Chord> columns_;
  std::vector<Chord> rows_;
};

}  // namespace pipescout::thermal
