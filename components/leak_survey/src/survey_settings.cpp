// SPDX-License-Identifier: Apache-2.0
#include "pipescout/leak_survey/survey_settings.hpp"

#include <numbers>

#include "pipescout/thermal_files/yaml_entries.hpp"

namespace pipescout {
namespace {

constexpr double kDegree = std::numbers::pi / 180;

class Reader : public YamlEntries {
 public:
  using YamlEntries::YamlEntries;

  void read(const YAML::Node& root, SurveySettings& settings) const {
    Eigen::Vector3d position = Eigen::Vector3d::Zero();
    // As the robots' own cameras unless told: straight down, the upper border forward.
    Eigen::Vector3d angles(std::numbers::pi, 0, -std::numbers::pi / 2);
    leak_findings::LeakFindingsParameters& findings = settings.findings;
    entries(root, "the file",
            {{"preset",
              [&](const YAML::Node& n) { settings.preset = chosen(n, thermal::kDetectorPresets); }},
             {"field_of_view",
              [&](const YAML::Node& n) {
                settings.field_of_view = kDegree * in_range(n, number(n), 0.1, 170, "degrees");
              }},
             {"camera_position", [&](const YAML::Node& n) { position = three(n); }},
             {"camera_roll_pitch_yaw", [&](const YAML::Node& n) { angles = kDegree * three(n); }},
             {"range", [&](const YAML::Node& n) { range(n, findings); }},
             {"lines", [&](const YAML::Node& n) { lines(n, findings); }},
             {"pose_deviation",
              [&](const YAML::Node& n) {
                entries(n, "pose_deviation",
                        {{"position",
                          [&](const YAML::Node& v) {
                            settings.position_deviation = in_range(v, number(v), 1e-6, 1e4, "m");
                          }},
                         {"orientation", [&](const YAML::Node& v) {
                            settings.orientation_deviation =
                                kDegree * in_range(v, number(v), 1e-6, 180, "degrees");
                          }}});
              }},
             {"frame_rate",
              [&](const YAML::Node& n) {
                settings.frame_rate = in_range(n, number(n), 1e-6, 1e4, "Hz");
              }},
             {"datum", [&](const YAML::Node& n) { datum(n, settings); }},
             text_into("weather", settings.weather),
             text_into("calibration", settings.calibration)});
    findings.T_base_camera = geometry::SE3(geometry::SO3::from_roll_pitch_yaw(angles), position);
    checked(root, [&findings] { findings.validate(); });
  }

 private:
  double in_range(const YAML::Node& node, double value, double least, double most,
                  const char* unit) const {
    if (!(value >= least && value <= most)) {
      refuse(node, std::to_string(value) + " is outside [" + std::to_string(least) + ", " +
                       std::to_string(most) + "] " + unit);
    }
    return value;
  }

  void range(const YAML::Node& node, leak_findings::LeakFindingsParameters& findings) const {
    entries(node, "range",
            {{"source",
              [&](const YAML::Node& n) {
                findings.range_source = chosen(n, leak_findings::kRangeSources);
              }},
             number_into("distance", findings.distance),
             number_into("distance_deviation", findings.distance_deviation),
             number_into("pipe_diameter", findings.pipe_diameter),
             number_into("line_deviation", findings.line_deviation)});
  }

  void lines(const YAML::Node& node, leak_findings::LeakFindingsParameters& findings) const {
    if (!node.IsSequence()) {
      refuse(node, "lines is no list");
    }
    for (const YAML::Node& line : node) {
      if (!line.IsSequence() || line.size() != 2) {
        refuse(line, "a line needs two points");
      }
      findings.lines.push_back({three(line[0]), three(line[1])});
    }
  }

  void datum(const YAML::Node& node, SurveySettings& settings) const {
    geometry::GeodeticPosition& datum = settings.datum.emplace();
    entries(node, "datum",
            {number_into("latitude", datum.latitude), number_into("longitude", datum.longitude),
             number_into("altitude", datum.altitude)});
    checked(node, [&datum] { datum.validate(); });
  }
};

}  // namespace

SurveySettings parse_survey_settings(const std::string& text, const std::string& name) {
  const Reader reader(name);
  SurveySettings settings;
  const YAML::Node root = reader.root(text);
  reader.read(root.IsNull() ? YAML::Node(YAML::NodeType::Map) : root, settings);
  return settings;
}

}  // namespace pipescout
