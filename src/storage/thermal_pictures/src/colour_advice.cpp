// SPDX-License-Identifier: Apache-2.0
#include "colour_advice.hpp"

#include <algorithm>
#include <nlohmann/json.hpp>

#include "exiftool.hpp"

namespace pipescout {
namespace {

/// In lower case; empty where EXIF does not have it.
std::string maker_of(const std::string& exiftool, std::span<const std::uint8_t> content) {
  const auto documents =
      nlohmann::json::parse(exiftool_json(exiftool, {"-EXIF:Make"}, content), nullptr, false);
  if (!documents.is_array() || documents.empty() || !documents[0].is_object()) {
    return {};
  }
  const auto make = documents[0].find("Make");
  std::string text =
      make != documents[0].end() && make->is_string() ? make->get<std::string>() : "";
  std::ranges::transform(text, text.begin(), [](char c) {
    return c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c;
  });
  return text;
}

}  // namespace

std::string colour_advice(const std::string& exiftool, std::span<const std::uint8_t> content) {
  const std::string maker = maker_of(exiftool, content);
  std::string text =
      "instead of pictures in colours export what has the temperatures: FLIR's radiometric JPEG, "
      "FFF "
      "or SEQ; TIFF of 32-bit temperatures; or PNG or TIFF of 16-bit counts, with their scale in "
      "thermal.yaml";
  if (maker.starts_with("flir")) {
    text +=
        ". These have FLIR as their maker and no thermal block: take the files as the camera saved "
        "them, in its setting 'radiometric JPEG', before any program edited them";
  } else if (maker.starts_with("dji")) {
    text +=
        ". These have DJI as their maker: its R-JPEG (H20T and later) is converted to such TIFF by "
        "DJI's Thermal SDK; an XT2 saves FLIR's";
  }
  return text;
}

}  // namespace pipescout
