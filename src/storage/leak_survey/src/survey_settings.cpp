// SPDX-License-Identifier: Apache-2.0
#include "pipescout/leak_survey/survey_settings.hpp"

#include <limits>
#include <numbers>

#include "pipescout/thermal_files/yaml_entries.hpp"

namespace pipescout {
namespace {

constexpr double kDegree = std::numbers::pi / 180;

// The names of the form, in one place for reader and writer.

template <class Visit>
void each_field(geometry::CameraParameters& camera, const Visit& visit) {
  visit("width", camera.width);
  visit("height", camera.height);
  visit("focal_length", camera.focal_length);
  visit("aspect_ratio", camera.aspect_ratio);
  visit("skew", camera.skew);
  visit("centre_u", camera.centre_u);
  visit("centre_v", camera.centre_v);
  visit("k1", camera.k1);
  visit("k2", camera.k2);
  visit("k3", camera.k3);
  visit("p1", camera.p1);
  visit("p2", camera.p2);
  visit("k4", camera.k4);
  visit("k5", camera.k5);
  visit("k6", camera.k6);
}

template <class Visit>
void each_range_field(leak_findings::LeakFindingsParameters& findings, const Visit& visit) {
  visit("distance", findings.distance);
  visit("distance_deviation", findings.distance_deviation);
  visit("pipe_diameter", findings.pipe_diameter);
  visit("width_deviation", findings.width_deviation);
  visit("line_deviation", findings.line_deviation);
}

class Reader : public YamlEntries {
 public:
  Reader(const std::string& name, const SurveyParametersReader& read_parameters)
      : YamlEntries(name), name_(name), read_parameters_(read_parameters) {}

  void read(const YAML::Node& root, std::optional<thermal::DetectorPreset> preset,
            SurveySettings& settings) const {
    Eigen::Vector3d position = Eigen::Vector3d::Zero();
    // As the robots' own cameras unless told: straight down, the upper border forward.
    Eigen::Vector3d angles(std::numbers::pi, 0, -std::numbers::pi / 2);
    std::optional<YAML::Node> changes;
    std::optional<YAML::Node> how_far;
    std::optional<YAML::Node> pipes;
    entries(root, "the file",
            {{"preset",
              [&](const YAML::Node& n) { settings.preset = chosen(n, thermal::kDetectorPresets); }},
             {"field_of_view",
              [&](const YAML::Node& n) {
                settings.field_of_view = kDegree * in_range(n, number(n), 0.1, 170, "degrees");
              }},
             {"camera", [&](const YAML::Node& n) { camera(n, settings); }},
             {"camera_position", [&](const YAML::Node& n) { position = three(n); }},
             {"camera_roll_pitch_yaw", [&](const YAML::Node& n) { angles = kDegree * three(n); }},
             {"range", [&](const YAML::Node& n) { how_far = n; }},
             {"lines", [&](const YAML::Node& n) { pipes = n; }},
             {"pose_deviation", [&](const YAML::Node& n) { pose_deviation(n, settings); }},
             {"frame_rate",
              [&](const YAML::Node& n) {
                settings.frame_rate = in_range(n, number(n), 1e-6, 1e4, "Hz");
              }},
             {"datum", [&](const YAML::Node& n) { datum(n, settings); }},
             text_into("weather", settings.weather),
             text_into("calibration", settings.calibration),
             {"parameters", [&](const YAML::Node& n) { changes = n; }}});
    if (settings.field_of_view && settings.camera) {
      refuse(root, "field_of_view and camera exclude each other");
    }
    settings.preset = preset.value_or(settings.preset);
    // Wherever they stand in the file: the others go on top of what the parameters come to.
    parameters(root, changes, settings);
    leak_findings::LeakFindingsParameters& findings = settings.findings;
    if (how_far) {
      range(*how_far, findings);
    }
    if (pipes) {
      lines(*pipes, findings);
    }
    if (findings.range_source == leak_findings::RangeSource::kDiameter) {
      settings.detector.pipe_diameter = findings.pipe_diameter;
    }
    findings.T_base_camera = geometry::SE3(geometry::SO3::from_roll_pitch_yaw(angles), position);
    checked(root, [&findings] { findings.validate(); });
  }

 private:
  double in_range(const YAML::Node& node, double value, double least, double most,
                  const char* unit) const {
    if (!(value >= least && value <= most)) {
      refuse(node, yaml_number(value) + " is outside [" + yaml_number(least) + ", " +
                       yaml_number(most) + "] " + unit);
    }
    return value;
  }

  [[nodiscard]] Entry into(const char* key, double& target) const {
    return number_into(key, target);
  }
  [[nodiscard]] Entry into(const char* key, int& target) const { return whole_into(key, target); }

  void camera(const YAML::Node& node, SurveySettings& settings) const {
    geometry::CameraParameters& camera = settings.camera.emplace();
    // Must be told: the defaults are another camera's.
    camera.width = camera.height = 0;
    camera.focal_length = 0;
    camera.centre_u = camera.centre_v = std::numeric_limits<double>::quiet_NaN();
    std::vector<Entry> known;
    each_field(camera, [&](const char* name, auto& value) { known.push_back(into(name, value)); });
    known.emplace_back(
        "lens", [&](const YAML::Node& n) { camera.lens = chosen(n, geometry::kLensModels); });
    entries(node, "camera", known);
    checked(node, [&camera] { camera.validate(); });
  }

  void parameters(const YAML::Node& root, const std::optional<YAML::Node>& changes,
                  SurveySettings& settings) const {
    const YAML::Node map = changes.value_or(YAML::Node(YAML::NodeType::Map));
    checked(changes.value_or(root), [&] {
      read_parameters_(map, name_, settings.preset, settings.detector, settings.findings);
    });
    if (changes) {
      YAML::Emitter text;
      text << YAML::Flow << *changes;
      settings.parameters = text.c_str();
    }
  }

  void pose_deviation(const YAML::Node& node, SurveySettings& settings) const {
    entries(node, "pose_deviation",
            {{"position",
              [&](const YAML::Node& v) {
                settings.position_deviation = in_range(v, number(v), 1e-6, 1e4, "m");
              }},
             {"orientation", [&](const YAML::Node& v) {
                settings.orientation_deviation =
                    kDegree * in_range(v, number(v), 1e-6, 180, "degrees");
              }}});
  }

  void range(const YAML::Node& node, leak_findings::LeakFindingsParameters& findings) const {
    std::vector<Entry> known{{"source", [&](const YAML::Node& n) {
                                findings.range_source = chosen(n, leak_findings::kRangeSources);
                              }}};
    each_range_field(findings, [&](const char* name, double& value) {
      known.push_back(number_into(name, value));
    });
    entries(node, "range", known);
  }

  void lines(const YAML::Node& node, leak_findings::LeakFindingsParameters& findings) const {
    if (!node.IsSequence()) {
      refuse(node, "lines is not a list");
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

  std::string name_;
  const SurveyParametersReader& read_parameters_;
};

class Writer {
 public:
  std::string text(const SurveySettings& settings) {
    out_ << YAML::BeginMap;
    entry("preset", std::string(to_string(settings.preset)));
    if (settings.field_of_view) {
      entry("field_of_view", *settings.field_of_view / kDegree);
    }
    if (settings.camera) {
      geometry::CameraParameters camera = *settings.camera;
      map("camera", [&] {
        each_field(camera, [this](const char* name, auto value) { entry(name, value); });
        entry("lens", std::string(to_string(camera.lens)));
      });
    }
    mounting(settings.findings.T_base_camera);
    range(settings.findings);
    map("pose_deviation", [&] {
      entry("position", settings.position_deviation);
      entry("orientation", settings.orientation_deviation / kDegree);
    });
    entry("frame_rate", settings.frame_rate);
    if (settings.datum) {
      map("datum", [&] {
        entry("latitude", settings.datum->latitude);
        entry("longitude", settings.datum->longitude);
        entry("altitude", settings.datum->altitude);
      });
    }
    entry("weather", settings.weather);
    entry("calibration", settings.calibration);
    out_ << YAML::Key << "parameters" << YAML::Value << YAML::Flow
         << YAML::Load(settings.parameters.empty() ? "{}" : settings.parameters);
    out_ << YAML::EndMap;
    return std::string(out_.c_str()) + "\n";
  }

 private:
  void entry(const char* name, const std::string& value) {
    out_ << YAML::Key << name << YAML::Value << value;
  }
  void entry(const char* name, double value) { entry(name, yaml_number(value)); }
  void entry(const char* name, int value) { entry(name, std::to_string(value)); }

  template <class Content>
  void map(const char* name, const Content& content) {
    out_ << YAML::Key << name << YAML::Value << YAML::Flow << YAML::BeginMap;
    content();
    out_ << YAML::EndMap;
  }

  void point(const Eigen::Vector3d& values) {
    out_ << YAML::Flow << YAML::BeginSeq;
    for (const double value : values) {
      out_ << yaml_number(value);
    }
    out_ << YAML::EndSeq;
  }

  void mounting(const geometry::SE3& T_base_camera) {
    out_ << YAML::Key << "camera_position" << YAML::Value;
    point(T_base_camera.translation());
    out_ << YAML::Key << "camera_roll_pitch_yaw" << YAML::Value;
    point(T_base_camera.rotation().roll_pitch_yaw() / kDegree);
  }

  void range(leak_findings::LeakFindingsParameters findings) {
    map("range", [&] {
      entry("source", std::string(to_string(findings.range_source)));
      each_range_field(findings, [this](const char* name, double value) { entry(name, value); });
    });
    out_ << YAML::Key << "lines" << YAML::Value << YAML::Flow << YAML::BeginSeq;
    for (const leak_findings::PipeLine& line : findings.lines) {
      out_ << YAML::Flow << YAML::BeginSeq;
      point(line.from);
      point(line.to);
      out_ << YAML::EndSeq;
    }
    out_ << YAML::EndSeq;
  }

  YAML::Emitter out_;
};

}  // namespace

SurveySettings parse_survey_settings(const std::string& text, const std::string& name,
                                     const SurveyParametersReader& read_parameters,
                                     std::optional<thermal::DetectorPreset> preset) {
  const Reader reader(name, read_parameters);
  SurveySettings settings;
  const YAML::Node root = reader.root(text);
  reader.read(root.IsNull() ? YAML::Node(YAML::NodeType::Map) : root, preset, settings);
  return settings;
}

std::string to_yaml(const SurveySettings& settings) {
  return Writer().text(settings);
}

}  // namespace pipescout
