// SPDX-License-Identifier: Apache-2.0
#include "evidence_text.hpp"

#include <cmath>
#include <limits>
#include <nlohmann/json.hpp>

namespace pipescout {
namespace {

using Json = nlohmann::json;

/// JSON has no NaN.
Json number(double value) {
  return std::isfinite(value) ? Json(value) : Json(nullptr);
}

double value(const Json& json) {
  return json.is_null() ? std::numeric_limits<double>::quiet_NaN() : json.get<double>();
}

Json line(const OverlayLine& l) {
  return {l.start.x(), l.start.y(), l.end.x(), l.end.y(), l.half_width};
}

OverlayLine read_line(const Json& json) {
  OverlayLine l;
  l.start = {json.at(0).get<double>(), json.at(1).get<double>()};
  l.end = {json.at(2).get<double>(), json.at(3).get<double>()};
  l.half_width = json.at(4).get<double>();
  return l;
}

thermal::PartKind kind_of(const std::string& name) {
  for (int i = 0; i < 5; ++i) {
    if (to_string(static_cast<thermal::PartKind>(i)) == name) {
      return static_cast<thermal::PartKind>(i);
    }
  }
  return thermal::PartKind::kHidden;
}

}  // namespace

std::string evidence_details(const Evidence& e) {
  Json profile = Json::array();
  for (const float degrees : e.profile) {
    // Hundredths of a kelvin: what is beyond is noise, and would triple the text.
    profile.push_back(number(std::round(double{degrees} * 100) / 100));
  }
  Json parts = Json::array();
  for (const ProfilePart& part : e.parts) {
    parts.push_back({{"from", part.from},
                     {"to", part.to},
                     {"mean", number(part.mean)},
                     {"kind", to_string(part.kind)}});
  }
  const Thumbnail& t = e.thumbnail;
  return Json{{"width", t.width},
              {"height", t.height},
              {"coldest", number(t.coldest)},
              {"hottest", number(t.hottest)},
              {"pipe", line(e.pipe)},
              {"leak", line(e.leak)},
              {"profile", profile},
              {"parts", parts},
              {"leak_from", e.leak_from},
              {"leak_to", e.leak_to},
              {"metres_per_sample", e.metres_per_sample},
              {"reference_temperature", number(e.reference_temperature)},
              {"split_distance", e.split_distance},
              {"split_delta", e.split_delta}}
      .dump();
}

bool read_evidence_details(const std::string& text, Evidence& e) {
  try {
    const Json json = Json::parse(text);
    e.thumbnail.width = json.at("width");
    e.thumbnail.height = json.at("height");
    e.thumbnail.coldest = value(json.at("coldest"));
    e.thumbnail.hottest = value(json.at("hottest"));
    e.pipe = read_line(json.at("pipe"));
    e.leak = read_line(json.at("leak"));
    for (const Json& degrees : json.at("profile")) {
      e.profile.push_back(static_cast<float>(value(degrees)));
    }
    for (const Json& part : json.at("parts")) {
      e.parts.push_back({part.at("from"), part.at("to"), value(part.at("mean")),
                         kind_of(part.at("kind").get<std::string>())});
    }
    e.leak_from = json.at("leak_from");
    e.leak_to = json.at("leak_to");
    e.metres_per_sample = json.at("metres_per_sample");
    e.reference_temperature = value(json.at("reference_temperature"));
    e.split_distance = json.at("split_distance");
    e.split_delta = json.at("split_delta");
    return true;
  } catch (const Json::exception&) {
    return false;
  }
}

}  // namespace pipescout
