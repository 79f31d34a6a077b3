// SPDX-License-Identifier: Apache-2.0
#include "pipescout/recording/csv_line.hpp"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>

#include "pipescout/odometer_replay/csv_table.hpp"
#include "pipescout/odometer_replay/readings_csv.hpp"

namespace pipescout {

namespace {

/// Characters of a text that are kept.
constexpr std::size_t kLongestText = 200;

}  // namespace

CsvLine::CsvLine(Time stamp) : text_(format_stamp(stamp.time_since_epoch())) {}

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
  text_ += ',';
  if (kept.find_first_of(",\"") == std::string::npos) {
    text_ += kept;
    return *this;
  }
  text_ += '"';
  for (const char c : kept) {
    text_.append(c == '"' ? 2 : 1, c);
  }
  text_ += '"';
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
