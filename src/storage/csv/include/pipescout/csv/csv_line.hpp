// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>

#include "pipescout/csv/csv_stamp.hpp"

namespace pipescout {

/// A line of a data file (docs/mission_folder.md), cell after cell. Not thread-safe.
class CsvLine {
 public:
  /// The first cell: seconds with nine decimals.
  explicit CsvLine(Stamp stamp);

  /// With as many digits as a lossless round trip needs; -0 as 0.
  CsvLine& add(double value);
  CsvLine& add(std::uint64_t value);
  /// 0 or 1.
  CsvLine& add(bool value);
  /// Text from a message: its first 200 characters, on one line, quoted by RFC 4180 if necessary.
  CsvLine& add(std::string_view text);
  CsvLine& add(const char* text) { return add(std::string_view(text)); }
  /// With the digits of a float, which are sufficient for uncertainties.
  CsvLine& add_short(double value);
  /// Missing values.
  CsvLine& add_empty(std::size_t cells = 1);
  /// Each of an Eigen vector or a list, in its order.
  template <class Values>
  CsvLine& add_each(const Values& values) {
    for (const double value : values) {
      add(value);
    }
    return *this;
  }
  template <class Values>
  CsvLine& add_each_short(const Values& values) {
    for (const double value : values) {
      add_short(value);
    }
    return *this;
  }

  /// Without line end.
  [[nodiscard]] const std::string& text() const noexcept { return text_; }

 private:
  std::string text_;
};

}  // namespace pipescout
