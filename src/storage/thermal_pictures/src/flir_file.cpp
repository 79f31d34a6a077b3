// SPDX-License-Identifier: Apache-2.0
#include "flir_file.hpp"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <nlohmann/json.hpp>

#include "base64.hpp"
#include "picture_time.hpp"
#include "pipescout/statistics/median.hpp"

namespace pipescout {
namespace {

using Json = nlohmann::json;

constexpr std::string_view kBase64 = "base64:";  // begins what exiftool gives of bytes

/// With six digits, whatever the locale.
std::string short_number(double value) {
  std::array<char, 32> text{};
  const auto [end, error] =
      std::to_chars(text.data(), text.data() + text.size(), value, std::chars_format::general, 6);
  return {text.data(), end};
}

/// What a person can read of a text that a camera has put into a field of bytes: exiftool gives it
/// in base64 where it is not UTF-8. Of that the characters of ASCII; control characters are left
/// out. Empty where there is none.
std::string readable(const std::string& text) {
  std::string bytes = text;
  bool ascii_only = false;
  if (text.starts_with(kBase64)) {
    const auto decoded = decode_base64(std::string_view(text).substr(kBase64.size()));
    bytes = decoded ? std::string(decoded->begin(), decoded->end()) : "";
    ascii_only = true;
  }
  std::string kept;
  for (const char c : bytes) {
    const auto code = static_cast<unsigned char>(c);
    if (code >= 0x20 && code != 0x7f && !(ascii_only && code > 0x7f)) {
      kept += c;
    }
  }
  const auto first = kept.find_first_not_of(' ');
  return first == std::string::npos ? ""
                                    : kept.substr(first, kept.find_last_not_of(' ') - first + 1);
}

class Tags {
 public:
  Tags(const Json& json, std::vector<std::string>& doubts) : json_(json), doubts_(doubts) {}

  /// Some numbers come as text, so that no digit is lost.
  [[nodiscard]] std::optional<double> number(const char* name) const {
    const auto found = json_.find(name);
    if (found == json_.end()) {
      return std::nullopt;
    }
    if (found->is_number()) {
      return found->get<double>();
    }
    if (found->is_string()) {
      const auto& text = found->get_ref<const std::string&>();
      const char* const last = text.data() + text.size();
      double value = 0;
      const auto [end, error] = std::from_chars(text.data(), last, value);
      if (error == std::errc{} && end == last && std::isfinite(value)) {
        return value;
      }
    }
    return std::nullopt;
  }

  [[nodiscard]] double needed(const char* name) const {
    const auto value = number(name);
    if (!value) {
      throw FlirError(std::string("its thermal block has no ") + name);
    }
    return *value;
  }

  void replace(double& target, const char* name, const char* field) const {
    if (const auto value = number(name)) {
      target = *value;
    } else {
      doubts_.push_back(std::string(field) + ": not in the file; " + short_number(target) +
                        " is used");
    }
  }

  [[nodiscard]] std::string text(const char* name) const {
    const auto found = json_.find(name);
    if (found == json_.end()) {
      return "";
    }
    return found->is_string() ? found->get<std::string>() : found->dump();
  }

 private:
  const Json& json_;
  std::vector<std::string>& doubts_;
};

std::string joined(const std::string& a, const std::string& b) {
  return a.empty() || b.empty() ? a + b : a + " " + b;
}

/// Begins with the markers of an image (SOI) and of a JPEG-LS frame (SOF55, ITU-T T.87).
bool is_jpeg_ls(const std::vector<std::uint8_t>& bytes) {
  constexpr std::array<std::uint8_t, 4> kMarkers{0xff, 0xd8, 0xff, 0xf7};
  return bytes.size() > kMarkers.size() &&
         std::equal(kMarkers.begin(), kMarkers.end(), bytes.begin());
}

Pixels<std::uint16_t> raw_picture(const Tags& tags) {
  const std::string encoded = tags.text("RawThermalImage");
  const auto bytes = encoded.starts_with(kBase64)
                         ? decode_base64(std::string_view(encoded).substr(kBase64.size()))
                         : std::nullopt;
  if (!bytes) {
    throw FlirError("its thermal block contains no image");
  }
  if (is_jpeg_ls(*bytes)) {
    throw FlirError(
        "its image is compressed as JPEG-LS (CSQ), which is not read; export it as SEQ");
  }
  AnyPixels any;
  try {
    any = decode_pixels(*bytes);
  } catch (const PixelError& error) {
    throw FlirError(std::string("the image in its thermal block ") + error.what());
  }
  auto* const counts = std::get_if<Pixels<std::uint16_t>>(&any);
  if (counts == nullptr) {
    throw FlirError("the image in its thermal block does not have 16 bits");
  }
  if (counts->width != static_cast<int>(tags.needed("RawThermalImageWidth")) ||
      counts->height != static_cast<int>(tags.needed("RawThermalImageHeight"))) {
    throw FlirError("the image in its thermal block differs in size from its header");
  }
  return std::move(*counts);
}

std::vector<std::uint16_t> swapped(std::vector<std::uint16_t> counts) {
  for (std::uint16_t& count : counts) {
    count = static_cast<std::uint16_t>((count << 8U) | (count >> 8U));
  }
  return counts;
}

/// Most cameras put their little-endian numbers into PNG, which takes them for big-endian ones; not
/// all do. The camera has written down the median, which tells.
void order_bytes(std::vector<std::uint16_t>& counts, const Tags& tags,
                 std::vector<std::string>& doubts) {
  const double told = tags.number("RawValueMedian").value_or(0);
  const double span = tags.number("RawValueRange").value_or(0);
  const bool tells = told > 0 && span > 0;
  const auto fits = [&](const std::vector<std::uint16_t>& candidate) {
    return std::abs(statistics::median(candidate) - told) <= span;
  };
  if (tags.text("RawThermalImageType") == "PNG") {
    std::vector<std::uint16_t> other = swapped(counts);
    if (!tells || fits(other) || !fits(counts)) {
      counts = std::move(other);
    }
  }
  if (tells && !fits(counts)) {
    const double median = statistics::median(counts);
    doubts.push_back("counts: their median is " + std::to_string(std::lround(median)) +
                     ", and the camera noted " + std::to_string(std::lround(told)));
  }
}

thermal::CameraConstants camera_of(const Tags& tags) {
  thermal::CameraConstants camera;
  camera.planck = {.r1 = tags.needed("PlanckR1"),
                   .r2 = tags.needed("PlanckR2"),
                   .b = tags.needed("PlanckB"),
                   .f = tags.needed("PlanckF"),
                   .o = tags.needed("PlanckO")};
  thermal::AtmosphereConstants& air = camera.atmosphere;
  tags.replace(air.alpha1, "AtmosphericTransAlpha1", "atmosphere.alpha1");
  tags.replace(air.alpha2, "AtmosphericTransAlpha2", "atmosphere.alpha2");
  tags.replace(air.beta1, "AtmosphericTransBeta1", "atmosphere.beta1");
  tags.replace(air.beta2, "AtmosphericTransBeta2", "atmosphere.beta2");
  tags.replace(air.x, "AtmosphericTransX", "atmosphere.x");
  return camera;
}

thermal::ObjectParameters object_of(const Tags& tags) {
  thermal::ObjectParameters object;
  tags.replace(object.emissivity, "Emissivity", "emissivity");
  tags.replace(object.reflected_temperature, "ReflectedApparentTemperature",
               "reflected_temperature");
  tags.replace(object.distance, "ObjectDistance", "distance");
  tags.replace(object.atmospheric_temperature, "AtmosphericTemperature", "atmospheric_temperature");
  tags.replace(object.relative_humidity, "RelativeHumidity", "relative_humidity");
  tags.replace(object.window_temperature, "IRWindowTemperature", "window_temperature");
  tags.replace(object.window_transmission, "IRWindowTransmission", "window_transmission");
  return object;
}

thermal::CountRange range_of(const Tags& tags) {
  const double least = tags.number("RawValueRangeMin").value_or(0);
  const double most = tags.number("RawValueRangeMax").value_or(65535);
  if (!(least >= 0 && least < most && most <= 65535)) {
    return {};
  }
  return {static_cast<std::uint16_t>(least), static_cast<std::uint16_t>(most)};
}

}  // namespace

const std::vector<std::string>& flir_tags() {
  static const std::vector<std::string> kTags = [] {
    std::vector<std::string> tags{"-Error", "-Warning", "-GPSLatitude", "-GPSLongitude",
                                  "-GPSAltitude"};
    for (const char* name : {"RawThermalImage",
                             "RawThermalImageWidth",
                             "RawThermalImageHeight",
                             "RawThermalImageType",
                             "PlanckR1",
                             "PlanckR2",
                             "PlanckB",
                             "PlanckF",
                             "PlanckO",
                             "AtmosphericTransAlpha1",
                             "AtmosphericTransAlpha2",
                             "AtmosphericTransBeta1",
                             "AtmosphericTransBeta2",
                             "AtmosphericTransX",
                             "Emissivity",
                             "ReflectedApparentTemperature",
                             "ObjectDistance",
                             "AtmosphericTemperature",
                             "RelativeHumidity",
                             "IRWindowTemperature",
                             "IRWindowTransmission",
                             "RawValueRangeMin",
                             "RawValueRangeMax",
                             "RawValueMedian",
                             "RawValueRange",
                             "CameraModel",
                             "CameraSerialNumber",
                             "LensModel",
                             "LensSerialNumber",
                             "DateTimeOriginal"}) {
      // The maker notes have an emissivity too, which exiftool ranks below that of the block.
      tags.push_back(std::string("-FLIR:") + name);
    }
    return tags;
  }();
  return kTags;
}

std::optional<FlirContent> flir_content(const std::string& json, std::string& complaint) {
  const Json documents = Json::parse(json, nullptr, false);
  if (!documents.is_array() || documents.empty() || !documents[0].is_object()) {
    throw FlirError("the output of exiftool is not JSON");
  }
  FlirContent content;
  const Tags tags(documents[0], content.doubts);
  complaint = tags.text("Error");
  if (complaint.empty()) {
    complaint = tags.text("Warning");
  }
  if (tags.text("RawThermalImage").empty()) {
    return std::nullopt;
  }
  content.counts = raw_picture(tags);
  order_bytes(content.counts.values, tags, content.doubts);
  content.camera = camera_of(tags);
  content.object = object_of(tags);
  content.range = range_of(tags);
  content.camera_name =
      joined(readable(tags.text("CameraModel")), readable(tags.text("CameraSerialNumber")));
  content.lens = joined(readable(tags.text("LensModel")), readable(tags.text("LensSerialNumber")));
  const std::string taken = tags.text("DateTimeOriginal");
  content.taken = exif_time(taken);
  if (!content.taken) {
    content.doubts.push_back(taken.empty() ? "taken: not in the file"
                                           : "taken: '" + taken + "' is not a time");
  } else if (!is_plausible_time(*content.taken)) {
    content.taken.reset();
    content.doubts.push_back("taken: " + taken + ": the camera's clock was not set");
  }
  const auto latitude = tags.number("GPSLatitude");
  const auto longitude = tags.number("GPSLongitude");
  if (latitude && longitude) {
    content.place = GeographicPlace{*latitude, *longitude, tags.number("GPSAltitude")};
  }
  return content;
}

}  // namespace pipescout
