// SPDX-License-Identifier: Apache-2.0
#include "picture_time.hpp"

#include <algorithm>
#include <charconv>
#include <chrono>
#include <cmath>
#include <nlohmann/json.hpp>
#include <string_view>

#include "flir_file.hpp"

namespace pipescout {
namespace {

using Json = nlohmann::json;

constexpr double kYear2001 = 978307200;  // s since 1970

/// Takes a text apart from its beginning.
class Scanner {
 public:
  explicit Scanner(std::string_view text) : rest_(text) {}

  /// So many digits.
  std::optional<int> digits(std::size_t count) {
    int value = 0;
    const std::string_view word = rest_.substr(0, count);
    const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), value);
    if (word.size() != count || error != std::errc{} || end != word.data() + count || value < 0) {
      return std::nullopt;
    }
    rest_.remove_prefix(count);
    return value;
  }
  /// A number with decimals; no sign.
  std::optional<double> decimal() {
    const std::size_t size = std::min(rest_.find_first_not_of("0123456789."), rest_.size());
    double value = 0;
    const auto [end, error] = std::from_chars(rest_.data(), rest_.data() + size, value);
    if (error != std::errc{} || end != rest_.data() + size) {
      return std::nullopt;
    }
    rest_.remove_prefix(size);
    return value;
  }
  bool take(char c) {
    if (!rest_.starts_with(c)) {
      return false;
    }
    rest_.remove_prefix(1);
    return true;
  }
  [[nodiscard]] bool at_end() const { return rest_.empty(); }

 private:
  std::string_view rest_;
};

/// min; "", "Z", "+01:00"
std::optional<int> zone_offset(Scanner& text) {
  if (text.at_end() || (text.take('Z') && text.at_end())) {
    return 0;
  }
  const bool west = text.take('-');
  if (!west && !text.take('+')) {
    return std::nullopt;
  }
  const auto hours = text.digits(2);
  const bool colon = text.take(':');
  const auto minutes = text.digits(2);
  if (!hours || !colon || !minutes || !text.at_end()) {
    return std::nullopt;
  }
  return (west ? -1 : 1) * (60 * *hours + *minutes);
}

std::string text_of_tag(const Json& tags, const char* name) {
  const auto found = tags.find(name);
  if (found == tags.end()) {
    return "";
  }
  // Fractions of a second, "25", come as a number.
  return found->is_string() ? found->get<std::string>() : found->dump();
}

PictureTime picture_time(const Json& tags) {
  PictureTime time;
  const std::string flir = text_of_tag(tags, "FLIR:DateTimeOriginal");
  time.taken = exif_time(flir);
  if (time.taken && is_plausible_time(*time.taken)) {
    return time;
  }
  std::string exif = text_of_tag(tags, "ExifIFD:DateTimeOriginal");
  const std::string fraction = text_of_tag(tags, "ExifIFD:SubSecTimeOriginal");
  std::string zone = text_of_tag(tags, "ExifIFD:OffsetTimeOriginal");
  zone = zone.empty() ? text_of_tag(tags, "ExifIFD:OffsetTime") : zone;
  const bool is_whole = exif.find_first_of("+-Z.") != std::string::npos;
  exif += is_whole ? "" : (fraction.empty() ? "" : "." + fraction) + zone;
  const bool has_zone = exif.find_first_of("+-Z") != std::string::npos;
  time.taken = exif_time(exif);
  if (!time.taken || !is_plausible_time(*time.taken)) {
    time.taken.reset();
    return time;
  }
  if (!flir.empty()) {
    time.doubts.push_back("taken: EXIF's " + exif + " is used");
  }
  if (!has_zone) {
    time.doubts.push_back("taken: EXIF's " + exif + " has no time zone and is taken for UTC");
  }
  return time;
}

}  // namespace

const std::vector<std::string>& time_tags() {
  static const std::vector<std::string> kTags{"-G1",
                                              "-fast",
                                              "-FLIR:DateTimeOriginal",
                                              "-ExifIFD:DateTimeOriginal",
                                              "-ExifIFD:SubSecTimeOriginal",
                                              "-ExifIFD:OffsetTimeOriginal",
                                              "-ExifIFD:OffsetTime"};
  return kTags;
}

std::vector<PictureTime> picture_times(const std::string& json, std::size_t files) {
  const Json documents = Json::parse(json, nullptr, false);
  if (!documents.is_array() || documents.size() != files) {
    throw FlirError("the output of exiftool is not JSON of " + std::to_string(files) + " files");
  }
  std::vector<PictureTime> times;
  for (const Json& tags : documents) {
    times.push_back(tags.is_object() ? picture_time(tags) : PictureTime{});
  }
  return times;
}

std::optional<double> exif_time(const std::string& text) {
  Scanner scanner(text);
  const auto year = scanner.digits(4);
  const bool first = scanner.take(':');
  const auto month = scanner.digits(2);
  const bool second_colon = scanner.take(':');
  const auto day = scanner.digits(2);
  const bool blank = scanner.take(' ');
  const auto hour = scanner.digits(2);
  const bool third = scanner.take(':');
  const auto minute = scanner.digits(2);
  const bool fourth = scanner.take(':');
  const auto second = scanner.decimal();
  if (!year || !month || !day || !hour || !minute || !second || !first || !second_colon || !blank ||
      !third || !fourth) {
    return std::nullopt;
  }
  const std::chrono::year_month_day date{std::chrono::year(*year),
                                         std::chrono::month(static_cast<unsigned>(*month)),
                                         std::chrono::day(static_cast<unsigned>(*day))};
  const auto offset = zone_offset(scanner);
  if (!date.ok() || *hour > 23 || *minute > 59 || *second >= 61 || !offset) {
    return std::nullopt;
  }
  const auto days = std::chrono::sys_days(date).time_since_epoch().count();
  return static_cast<double>(days) * 86400.0 + 3600.0 * *hour + 60.0 * (*minute - *offset) +
         *second;
}

bool is_plausible_time(double taken) noexcept {
  return taken >= kYear2001;
}

}  // namespace pipescout
