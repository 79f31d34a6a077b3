// SPDX-License-Identifier: Apache-2.0
#include "pipescout/leak_store/leak_exports.hpp"

#include <chrono>
#include <cmath>
#include <nlohmann/json.hpp>
#include <utility>

#include "markup.hpp"
#include "pipescout/files/utc_text.hpp"

namespace pipescout {
namespace {

using leak_findings::Finding;
// A leak's entries in the order in which they are written.
using OrderedJson = nlohmann::ordered_json;

/// JSON has no NaN.
OrderedJson ordered_number(double value) {
  return std::isfinite(value) ? OrderedJson(value) : OrderedJson(nullptr);
}

std::optional<geometry::GeodeticPosition> place(
    const Finding& finding, const std::optional<geometry::GeodeticPosition>& datum) {
  if (!finding.position || !datum || !finding.position->point.allFinite()) {
    return std::nullopt;
  }
  return geometry::LocalFrame(*datum).geodetic(finding.position->point);
}

/// Name and value of all that is known of a finding, but for its place on the Earth.
std::vector<std::pair<std::string, OrderedJson>> fields(const Finding& f) {
  std::vector<std::pair<std::string, OrderedJson>> all = {
      {"id", f.id},
      {"state", to_string(f.state)},
      {"severity", to_string(f.severity)},
      {"probability", ordered_number(f.probability)},
      {"first_time", iso_time(f.first_time)},
      {"last_time", iso_time(f.last_time)},
      {"frames", f.frames},
      {"passes", f.pass_count},
      {"mean_delta_k", ordered_number(f.mean_delta)},
      {"mean_delta_low_k", ordered_number(f.mean_delta_interval.low)},
      {"mean_delta_high_k", ordered_number(f.mean_delta_interval.high)},
      {"peak_delta_k", ordered_number(f.peak_delta)},
      {"peak_delta_low_k", ordered_number(f.peak_delta_interval.low)},
      {"peak_delta_high_k", ordered_number(f.peak_delta_interval.high)},
      {"length_m", ordered_number(f.length)},
      {"length_deviation_m", ordered_number(f.length_deviation)},
      {"delta_growth_k_per_h", ordered_number(f.delta_growth)},
      {"length_growth_m_per_h", ordered_number(f.length_growth)}};
  const double nan = std::nan("");
  const auto p = f.position.value_or(leak_findings::MapPosition{});
  const auto value = [&](double known) { return ordered_number(f.position ? known : nan); };
  const auto deviation = [&](int i) { return value(std::sqrt(p.covariance(i, i))); };
  all.insert(all.end(), {{"map_x", value(p.point.x())},
                         {"map_y", value(p.point.y())},
                         {"map_z", value(p.point.z())},
                         {"map_x_deviation", deviation(0)},
                         {"map_y_deviation", deviation(1)},
                         {"map_z_deviation", deviation(2)},
                         {"map_xy_covariance", value(p.covariance(0, 1))},
                         {"map_xz_covariance", value(p.covariance(0, 2))},
                         {"map_yz_covariance", value(p.covariance(1, 2))}});
  return all;
}

/// Seven decimals: a centimetre.
OrderedJson degrees(double value) {
  return std::round(value * 1e7) / 1e7;
}

std::string csv_field(const OrderedJson& value) {
  if (value.is_null()) {
    return "";
  }
  // No field holds a comma or a quotation mark: names, times and numbers alone.
  return value.is_string() ? value.get<std::string>() : value.dump();
}

}  // namespace

std::string iso_time(double seconds) {
  constexpr double kYear1 = -62135596800.0;
  constexpr double kYear10000 = 253402300800.0;
  if (!(seconds >= kYear1 && seconds < kYear10000 - 1)) {
    return "";
  }
  const auto milliseconds = static_cast<std::int64_t>(std::floor(seconds * 1000 + 0.5));
  return utc_text(
      std::chrono::sys_time<std::chrono::milliseconds>(std::chrono::milliseconds(milliseconds)),
      UtcForm::kIso);
}

std::string leaks_geojson(std::span<const Finding> findings,
                          const std::optional<geometry::GeodeticPosition>& datum) {
  OrderedJson features = OrderedJson::array();
  for (const Finding& finding : findings) {
    OrderedJson properties = OrderedJson::object();
    for (auto& [name, value] : fields(finding)) {
      properties[name] = value;
    }
    OrderedJson geometry = nullptr;
    if (const auto at = place(finding, datum)) {
      geometry = {{"type", "Point"},
                  {"coordinates",
                   {degrees(at->longitude), degrees(at->latitude),
                    std::round(at->altitude * 1000) / 1000}}};
    }
    features.push_back({{"type", "Feature"},
                        {"id", finding.id},
                        {"geometry", geometry},
                        {"properties", properties}});
  }
  return OrderedJson{{"type", "FeatureCollection"}, {"features", features}}.dump(1) + "\n";
}

std::string leaks_kml(std::span<const Finding> findings,
                      const std::optional<geometry::GeodeticPosition>& datum) {
  std::string kml =
      "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n"
      "<kml xmlns=\"http://www.opengis.net/kml/2.2\">\n<Document>\n<name>Leaks</name>\n";
  for (int i = 0; i < 4; ++i) {
    const auto severity = static_cast<thermal::Severity>(i);
    // KML has alpha, blue, green, red.
    const std::string rgb = severity_colour(severity).substr(1);
    kml += "<Style id=\"" + std::string(to_string(severity)) + "\"><IconStyle><color>ff" +
           rgb.substr(4, 2) + rgb.substr(2, 2) + rgb.substr(0, 2) +
           "</color></IconStyle></Style>\n";
  }
  for (const Finding& finding : findings) {
    kml += "<Placemark id=\"leak" + std::to_string(finding.id) + "\"><name>Leak " +
           std::to_string(finding.id) + ": " + std::string(to_string(finding.severity)) +
           "</name><styleUrl>#" + std::string(to_string(finding.severity)) +
           "</styleUrl><ExtendedData>";
    for (const auto& [name, value] : fields(finding)) {
      kml += "<Data name=\"" + name + "\"><value>" + escaped(csv_field(value)) + "</value></Data>";
    }
    kml += "</ExtendedData>";
    if (const auto at = place(finding, datum)) {
      kml += "<Point><altitudeMode>absolute</altitudeMode><coordinates>" +
             degrees(at->longitude).dump() + "," + degrees(at->latitude).dump() + "," +
             fixed(at->altitude, 3) + "</coordinates></Point>";
    }
    kml += "</Placemark>\n";
  }
  return kml + "</Document>\n</kml>\n";
}

std::string leaks_csv(std::span<const Finding> findings,
                      const std::optional<geometry::GeodeticPosition>& datum) {
  std::string csv;
  for (const auto& [name, value] : fields(Finding{})) {
    csv += name + ",";
  }
  csv += "latitude,longitude,altitude_m\n";
  for (const Finding& finding : findings) {
    for (const auto& [name, value] : fields(finding)) {
      csv += csv_field(value) + ",";
    }
    const auto at = place(finding, datum);
    csv += at ? degrees(at->latitude).dump() + "," + degrees(at->longitude).dump() + "," +
                    fixed(at->altitude, 3)
              : ",,";
    csv += "\n";
  }
  return csv;
}

}  // namespace pipescout
