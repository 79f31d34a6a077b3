// SPDX-License-Identifier: Apache-2.0
#include <cmath>
#include <string>
#include <vector>

#include "pipescout/csv/csv_cell.hpp"
#include "pipescout/geometry/antimeridian.hpp"
#include "pipescout/weld_ledger/weld_ledger_text.hpp"

namespace pipescout {
namespace {

using odometry::LedgerLandmark;
using odometry::LedgerWeld;
using odometry::MapFrame;
using odometry::MapPosition;
using odometry::WeldEvidence;
using odometry::WeldLedger;

std::string json_string(const std::string& text) {
  constexpr char kDigits[] = "0123456789abcdef";
  std::string result = "\"";
  for (const char c : text) {
    const auto byte = static_cast<unsigned char>(c);
    if (c == '"' || c == '\\') {
      result += '\\';
      result += c;
    } else if (byte < 0x20U) {
      result += "\\u00";
      result += kDigits[byte >> 4U];
      result += kDigits[byte & 0xFU];
    } else {
      result += c;
    }
  }
  return result + '"';
}

std::string json_number(double value) {
  return std::isfinite(value) ? format_optional_csv_number(value) : "null";
}

/// GeoJSON has the longitude first.
std::string coordinates(const MapPosition& position) {
  return '[' + json_number(position.coordinates[1]) + ',' + json_number(position.coordinates[0]) +
         ',' + json_number(position.coordinates[2]) + ']';
}

/// The pipe through these points, in pieces where it crosses the antimeridian.
std::string line_geometry(const std::vector<geometry::GeodeticPosition>& points) {
  std::string lines;
  std::size_t count = 0;
  for (const auto& piece : geometry::cut_at_antimeridian(points)) {
    std::string line;
    for (const geometry::GeodeticPosition& p : piece) {
      line += (line.empty() ? "" : ",") +
              coordinates({.coordinates = {p.latitude, p.longitude, p.altitude}});
    }
    lines += (count++ > 0 ? ",[" : "[") + line + ']';
  }
  return count == 1 ? R"({"type":"LineString","coordinates":)" + lines + '}'
                    : R"({"type":"MultiLineString","coordinates":[)" + lines + "]}";
}

std::string feature(const std::string& geometry, const std::string& properties) {
  return "{\"type\":\"Feature\",\"geometry\":" + geometry + ",\"properties\":{" + properties + "}}";
}

}  // namespace

std::string to_geojson(const WeldLedger& ledger) {
  const bool geodetic = ledger.frame == MapFrame::kGeodetic;
  std::vector<geometry::GeodeticPosition> line;
  std::string points;
  const std::vector<WeldEvidence> believed = evidence(ledger);
  for (std::size_t k = 0; k < ledger.welds.size(); ++k) {
    const LedgerWeld& weld = ledger.welds[k];
    std::string geometry = "null";
    std::string properties =
        "\"id\":" + json_string(weld.id) + ",\"chainage_m\":" + json_number(weld.chainage) +
        ",\"chainage_sd_m\":" + json_number(weld.standard_deviation) +
        ",\"joint_length_m\":" + json_number(weld.joint_length) +
        ",\"joint_length_sd_m\":" + json_number(weld.joint_standard_deviation) +
        ",\"seen\":" + std::to_string(believed[k].seen) +
        ",\"passed\":" + std::to_string(believed[k].passed) +
        ",\"verdict\":" + json_string(to_string(believed[k].verdict)) + ",\"runs\":[";
    for (std::size_t s = 0; s < weld.sightings.size(); ++s) {
      properties += s > 0 ? "," : "";
      properties += json_string(ledger.runs[weld.sightings[s].run].name);
    }
    properties += ']';
    if (weld.position) {
      properties += ",\"position_sd_m\":" + json_number(weld.position->standard_deviation);
      if (geodetic) {
        geometry = "{\"type\":\"Point\",\"coordinates\":" + coordinates(*weld.position) + '}';
        const auto& at = weld.position->coordinates;
        line.push_back({at[0], at[1], at[2]});
      } else {
        properties += ",\"x_m\":" + json_number(weld.position->coordinates[0]) +
                      ",\"y_m\":" + json_number(weld.position->coordinates[1]) +
                      ",\"z_m\":" + json_number(weld.position->coordinates[2]);
      }
    }
    points += k > 0 ? ",\n" : "";
    points += feature(geometry, properties);
  }
  for (const LedgerLandmark& landmark : ledger.landmarks) {
    const bool mapped = geodetic && landmark.position;
    points +=
        (points.empty() ? "" : ",\n") +
        feature(mapped
                    ? "{\"type\":\"Point\",\"coordinates\":" + coordinates(*landmark.position) + '}'
                    : "null",
                "\"id\":" + json_string(landmark.id) +
                    ",\"kind\":" + json_string(to_string(landmark.kind)) +
                    ",\"chainage_m\":" + json_number(landmark.chainage) +
                    ",\"chainage_sd_m\":" + json_number(landmark.standard_deviation) +
                    ",\"seen\":" + std::to_string(landmark.sightings.size()));
  }
  std::string text = "{\"type\":\"FeatureCollection\",\"features\":[\n";
  if (line.size() >= 2) {
    text += feature(line_geometry(line), "\"name\":\"pipe\"") + (points.empty() ? "" : ",\n");
  }
  return text + points + "\n]}\n";
}

}  // namespace pipescout
