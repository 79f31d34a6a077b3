// SPDX-License-Identifier: Apache-2.0
#include "pipescout/csv/csv_line.hpp"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>

#include "pipescout/csv/csv_cell.hpp"

namespace pipescout {

namespace {

/// Characters of a text that are kept.
constexpr std::size_t kLongestText = 200;

}  // namespace

CsvLine::CsvLine(Stamp stamp) : text_(format_stamp(stamp.time_since_epoch())) {}

CsvLine& CsvLine::add(double value) {
  text_ += "," + format_csv_number(value + 0.0);
  return *this;
}

CsvLine& CsvLine::add(std::uint64_t value) {
  text_ += "," + std::to_string(value);
  return *this;
}

CsvLine& CsvLine::add(bool value) {
  text_ += value ? ",1" : ",0";
  return *this;
}

CsvLine& CsvLine::add(std::string_view text) {
  std::string kept(text.substr(0, kLongestText));
  std::replace_if(
      kept.begin(), kept.end(), [](unsigned char c) { return c < 0x20 || c == 0x7f; }, ' ');
  text_ += ',' + csv_cell(kept);
  return *this;
}

CsvLine& CsvLine::add_short(double value) {
  if (std::isnan(value)) {
    text_ += ",nan";
    return *this;
  }
  std::array<char, 32> buffer{};
  const auto result =
      std::to_chars(buffer.data(), buffer.data() + buffer.size(), static_cast<float>(value));
  text_.append(",").append(buffer.data(), result.ptr);
  return *this;
}

CsvLine& CsvLine::add_empty(std::size_t cells) {
  text_.append(cells, ',');
  return *this;
}

}  // namespace pipescout
