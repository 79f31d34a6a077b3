// SPDX-License-Identifier: Apache-2.0
#include "configuration.hpp"

#include <yaml-cpp/yaml.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <string_view>
#include <tuple>

#include "pipescout/command_line/known_keys.hpp"
#include "pipescout/csv/csv_cell.hpp"
#include "pipescout/files/yaml_location.hpp"

namespace pipescout::estimate {
namespace {

constexpr double kLargestLength = 100;  // m, of a wheel's radius or a track

bool contains_any(const std::string& name, std::initializer_list<std::string_view> words) {
  return std::ranges::any_of(
      words, [&](std::string_view word) { return name.find(word) != std::string::npos; });
}

/// Velocities that are no odometer's.
std::string why_no_odometer(const Stream& s) {
  if (contains_any(s.name, {"cmd", "command"})) {
    return "it seems to be a command, not a measurement";
  }
  if (contains_any(s.name, {"gps", "gnss", "ublox", "fix"})) {
    return "it seems to be a velocity of GPS, along the axes of the map (further_sources takes it, "
           "kind gps_velocity or gps_velocity_with_covariance)";
  }
  if (contains_any(s.name, {"filtered", "fused", "ekf", "ukf", "global", "ground_truth"})) {
    return "it seems to be the output of another estimator";
  }
  return {};
}

/// Larger is better; topics of which nothing can be used are not candidates.
const Stream* best(const Recording& recording, Kind kind, const std::vector<NamedSource>& further,
                   std::vector<std::string>& said) {
  const Stream* chosen = nullptr;
  const auto rank = [&](const Stream& s) {
    const bool named = kind == Kind::kOdometer && contains_any(s.name, {"odom", "wheel"});
    // Wheels that were configured are meant.
    const bool wheels = s.type == "sensor_msgs/msg/JointState";
    return std::tuple(wheels, named, s.rows());
  };
  const auto is_further = [&](const Stream& s) {
    return std::ranges::find(further, s.name, &NamedSource::topic) != further.end();
  };
  for (const Stream& s : recording.streams) {
    // An odometry may be both: its twist the odometer, its poses a further source.
    if (s.kind != kind || (kind == Kind::kGps && is_further(s))) {
      continue;
    }
    if (s.rows() == 0) {
      if (is_further(s)) {
        continue;
      }
      said.push_back(s.name + " (" + s.type + "): no usable message.");
      continue;
    }
    if (const std::string why = kind == Kind::kOdometer ? why_no_odometer(s) : ""; !why.empty()) {
      if (is_further(s)) {
        continue;
      }
      said.push_back(s.name + " (" + s.type + "): not used, " + why + ".");
      continue;
    }
    if (chosen == nullptr || rank(s) > rank(*chosen)) {
      chosen = &s;
    }
  }
  for (const Stream& s : recording.streams) {
    if (chosen != nullptr && s.kind == kind && &s != chosen && s.rows() > 0 && !is_further(s) &&
        (kind != Kind::kOdometer || why_no_odometer(s).empty())) {
      said.push_back(s.name + " (" + s.type + "): not used, because " + chosen->name +
                     " is taken for the same. Name it in the configuration to use it instead" +
                     (kind == Kind::kGps ? ", or as another antenna: 'further_sources: {a_name: "
                                           "{kind: gps_fix, topic: " +
                                               s.name + "}}'."
                                         : "."));
    }
  }
  return chosen;
}

void say(const Stream& s, const char* use, std::vector<std::string>& said) {
  said.push_back(s.name + " (" + s.type + ", frame '" + s.frame + "', " + std::to_string(s.rows()) +
                 " usable messages) is taken as " + use + ".");
}

/// One mapping of the file: unknown keys are errors, and each value is read as what it must be.
class Section {
 public:
  Section(const YAML::Node& node, std::string path, const std::string& what,
          const std::vector<std::string>& known)
      : node_(node), path_(std::move(path)) {
    command_line::require_known_keys(node_, path_, what, known);
  }
  [[nodiscard]] YAML::Node at(const char* key) const { return node_[key]; }
  void read(const char* key, std::string& value) const {
    if (const YAML::Node node = node_[key]; node.IsDefined()) {
      value = node.IsNull() ? std::string() : scalar(node);
    }
  }
  void read(const char* key, double& value, double low, double high) const {
    const YAML::Node node = node_[key];
    if (!node.IsDefined()) {
      return;
    }
    value = number(node);
    if (!(value >= low && value <= high)) {
      throw YamlError(path_, node.Mark(),
                      std::string(key) + ": " + node.Scalar() + " is not in [" +
                          format_csv_number(low) + ", " + format_csv_number(high) + "]");
    }
  }
  void read(const char* key, std::optional<Eigen::Vector3d>& value) const {
    const YAML::Node node = node_[key];
    if (!node.IsDefined()) {
      return;
    }
    if (!node.IsSequence() || node.size() != 3) {
      throw YamlError(path_, node.Mark(), std::string(key) + ": three numbers are expected");
    }
    value = Eigen::Vector3d(number(node[0]), number(node[1]), number(node[2]));
  }
  void read(const char* key, std::vector<std::string>& value) const {
    const YAML::Node node = node_[key];
    if (!node.IsDefined()) {
      return;
    }
    if (!node.IsSequence()) {
      throw YamlError(path_, node.Mark(), std::string(key) + ": a list of names is expected");
    }
    for (const YAML::Node& each : node) {
      value.push_back(scalar(each));
    }
  }

 private:
  [[nodiscard]] std::string scalar(const YAML::Node& node) const {
    if (!node.IsScalar()) {
      throw YamlError(path_, node.Mark(), "one value is expected");
    }
    return node.Scalar();
  }
  [[nodiscard]] double number(const YAML::Node& node) const {
    const auto value = parse_csv_number(scalar(node));
    if (!value || !std::isfinite(*value)) {
      throw YamlError(path_, node.Mark(), "'" + node.Scalar() + "' is not a finite number");
    }
    return *value;
  }

  YAML::Node node_;
  std::string path_;
};

estimation::WheelDriveParameters read_wheels(const YAML::Node& node, const std::string& path) {
  estimation::WheelDriveParameters wheels;
  const Section s(node, path, "'wheels'", {"left", "right", "radius", "track"});
  s.read("left", wheels.left);
  s.read("right", wheels.right);
  s.read("radius", wheels.wheel_radius, 0, kLargestLength);
  s.read("track", wheels.track, 0, kLargestLength);
  try {
    wheels.validate();
  } catch (const std::invalid_argument& error) {
    throw YamlError(path, node.Mark(), std::string("wheels: ") + error.what());
  }
  return wheels;
}

Start read_start(const YAML::Node& node, const std::string& path) {
  Start start;
  const Section s(node, path, "'start'",
                  {"position", "position_deviation", "heading", "heading_deviation"});
  std::optional<Eigen::Vector3d> position;
  s.read("position", position);
  start.position = position.value_or(start.position);
  s.read("position_deviation", start.position_deviation, 1e-3, 1e4);
  s.read("heading", start.heading, -360, 360);
  s.read("heading_deviation", start.heading_deviation, 0.006, 57);
  return start;
}

NamedSource read_further_source(const std::string& name, const YAML::Node& node,
                                const std::string& path) {
  std::vector<std::string> known = {"kind", "topic", "position",     "roll_pitch_yaw", "beacon",
                                    "left", "right", "wheel_radius", "track"};
  for (const NamedSourceNumber& each : named_source_numbers()) {
    known.push_back(each.key);
  }
  const Section s(node, path, "further source '" + name + "'", known);
  std::string kind_name;
  s.read("kind", kind_name);
  const auto kind = named_source_kind(kind_name);
  if (!kind) {
    throw YamlError(path, node.Mark(),
                    "further_sources." + name + ": kind '" + kind_name + "' is not one of " +
                        all_named_source_kinds());
  }
  NamedSource source = default_source(name, *kind);
  s.read("topic", source.topic);
  s.read("position", source.position);
  std::optional<Eigen::Vector3d> turned;
  s.read("roll_pitch_yaw", turned);
  source.R_base_sensor =
      geometry::SO3::from_roll_pitch_yaw(turned.value_or(Eigen::Vector3d::Zero()));
  s.read("beacon", source.beacon);
  for (const NamedSourceNumber& each : named_source_numbers()) {
    s.read(each.key, source.*each.field, each.low, each.high);
  }
  s.read("left", source.wheels.left);
  s.read("right", source.wheels.right);
  s.read("wheel_radius", source.wheels.wheel_radius, 0, kLargestLength);
  s.read("track", source.wheels.track, 0, kLargestLength);
  return source;
}

std::vector<NamedSource> read_further_sources(const YAML::Node& node, const std::string& path) {
  if (!node.IsMap() && !node.IsNull()) {
    throw YamlError(path, node.Mark(), "further_sources: names with their parameters are expected");
  }
  std::vector<NamedSource> sources;
  for (const auto& each : node) {
    sources.push_back(read_further_source(each.first.Scalar(), each.second, path));
  }
  try {
    std::vector<NamedSource> placed = sources;
    estimation::StateEstimatorParameters any;
    place_sources(placed, any);
  } catch (const std::invalid_argument& error) {
    throw YamlError(path, node.Mark(), std::string("further_sources: ") + error.what());
  }
  return sources;
}

std::string list(const Eigen::Vector3d& v) {
  return "[" + format_csv_number(v.x()) + ", " + format_csv_number(v.y()) + ", " +
         format_csv_number(v.z()) + "]";
}

std::string quoted(const std::string& name) {
  YAML::Emitter out;
  out << YAML::DoubleQuoted << name;
  return out.c_str();
}

std::string names(const std::vector<std::string>& side) {
  std::string all;
  for (const std::string& name : side) {
    all += (all.empty() ? "" : ", ") + quoted(name);
  }
  return "[" + all + "]";
}

/// What differs from the defaults of its kind.
std::string to_yaml(const NamedSource& source) {
  const NamedSource defaults = default_source(source.name, source.kind);
  std::string out = "  " + quoted(source.name) +
                    ":\n    kind: " + std::string(to_string(source.kind)) +
                    "\n    topic: " + quoted(source.topic) + "\n";
  if (source.position) {
    out += "    position: " + list(*source.position) + "  # m, in the body\n    roll_pitch_yaw: " +
           list(source.R_base_sensor.roll_pitch_yaw()) + "  # rad\n";
  }
  if (source.beacon) {
    out += "    beacon: " + list(*source.beacon) + "  # m, in the map\n";
  }
  for (const NamedSourceNumber& each : named_source_numbers()) {
    if (source.*each.field != defaults.*each.field) {
      out += std::string("    ") + each.key + ": " + format_csv_number(source.*each.field) + "\n";
    }
  }
  if (source.kind == NamedSourceKind::kWheelEncoders) {
    out += "    left: " + names(source.wheels.left) + "\n    right: " + names(source.wheels.right) +
           "\n    wheel_radius: " + format_csv_number(source.wheels.wheel_radius) +
           "  # m\n    track: " + format_csv_number(source.wheels.track) + "  # m\n";
  }
  return out;
}

std::string to_yaml(const Start& start) {
  return "start:\n  position: " + list(start.position) +
         "  # m, in the map\n  position_deviation: " + format_csv_number(start.position_deviation) +
         "  # m\n  heading: " + format_csv_number(start.heading) +
         "  # degrees, from the map's x axis\n  heading_deviation: " +
         format_csv_number(start.heading_deviation) + "  # degrees\n";
}

std::string to_yaml(const estimation::WheelDriveParameters& wheels) {
  return "  wheels:\n    left: " + names(wheels.left) + "\n    right: " + names(wheels.right) +
         "\n    radius: " + format_csv_number(wheels.wheel_radius) +
         "  # m\n    track: " + format_csv_number(wheels.track) + "  # m\n";
}

}  // namespace

Guess guess(const Recording& recording, const std::vector<NamedSource>& further) {
  Guess result;
  Configuration& c = result.configuration;
  if (const Stream* s = best(recording, Kind::kImu, further, result.said)) {
    c.imu = s->name;
    say(*s, "the IMU", result.said);
  }
  if (const Stream* s = best(recording, Kind::kOdometer, further, result.said)) {
    c.odometer = s->name;
    c.base_frame = s->frame.empty() ? c.base_frame : s->frame;
    say(*s, "the odometer (speed along x, yaw rate)", result.said);
  }
  if (const Stream* s = best(recording, Kind::kGps, further, result.said)) {
    c.gps = s->name;
    say(*s, "GPS", result.said);
  }
  for (const Stream& s : recording.streams) {
    if (s.kind == Kind::kFurther &&
        std::ranges::find(further, s.name, &NamedSource::topic) == further.end()) {
      result.said.push_back(about_further(s.name, s.message_type));
    }
  }
  return result;
}

Configuration read_configuration(const std::string& path, const Configuration& defaults) {
  Configuration c = defaults;
  const YAML::Node root = load_yaml(path);
  if (root.IsNull()) {
    return c;
  }
  const Section top(
      root, path, "the configuration",
      {"base_frame", "imu", "odometer", "gps", "start", "further_sources", "sources"});
  top.read("base_frame", c.base_frame);
  if (const YAML::Node node = top.at("imu"); node.IsDefined()) {
    const Section s(
        node, path, "'imu'",
        {"source", "rotation", "specific_force_scale", "gyro_noise", "accelerometer_noise"});
    s.read("source", c.imu);
    s.read("rotation", c.imu_rotation);
    s.read("specific_force_scale", c.specific_force_scale, 1e-3, 1e3);
    s.read("gyro_noise", c.gyro_noise, 1e-7, 1);
    s.read("accelerometer_noise", c.accelerometer_noise, 1e-6, 10);
  }
  if (const YAML::Node node = top.at("odometer"); node.IsDefined()) {
    const Section s(node, path, "'odometer'", {"source", "scale", "delay", "wheels"});
    s.read("source", c.odometer);
    if (const YAML::Node wheels = s.at("wheels"); wheels.IsDefined()) {
      c.wheels = read_wheels(wheels, path);
    }
    s.read("scale", c.odometer_scale, -1000, 1000);
    s.read("delay", c.odometer_delay, -10, 10);
  }
  if (const YAML::Node node = top.at("gps"); node.IsDefined()) {
    const Section s(node, path, "'gps'",
                    {"source", "deviation", "deviation_factor", "correlation_time",
                     "shortest_correlation_time", "time_offset_deviation", "antenna"});
    s.read("source", c.gps);
    s.read("deviation", c.gps_deviation, 1e-3, 1e4);
    s.read("deviation_factor", c.gps_factor, 1e-3, 1e3);
    s.read("correlation_time", c.gps_correlation, 0, 1000);
    if (s.at("shortest_correlation_time").IsDefined()) {
      s.read("shortest_correlation_time", c.gps_shortest_correlation.emplace(), 0, 1000);
    }
    s.read("time_offset_deviation", c.gps_time_offset_deviation, 0, 10);
    s.read("antenna", c.antenna);
  }
  if (const YAML::Node node = top.at("start"); node.IsDefined()) {
    c.start = read_start(node, path);
  }
  if (const YAML::Node node = top.at("further_sources"); node.IsDefined()) {
    c.further = read_further_sources(node, path);
  }
  if (const YAML::Node node = top.at("sources"); node.IsDefined()) {
    YAML::Emitter out;
    out << node;
    c.sources = out.c_str();
  }
  return c;
}

std::string to_yaml(const Configuration& c) {
  const auto source = [](const std::string& name) {
    return "  source: " + (name.empty() ? std::string("\"\"  # none") : quoted(name)) + "\n";
  };
  std::string out =
      "# Configuration of `pipescout estimate`; edit it and pass it back with --config.\n"
      "base_frame: " +
      quoted(c.base_frame) + "\nimu:\n" + source(c.imu);
  out += c.imu_rotation ? "  rotation: " + list(*c.imu_rotation) +
                              "  # degrees: roll, pitch, yaw of the IMU in the body\n"
                        : "  # rotation: [0, 0, 0]  # degrees: roll, pitch, yaw of the IMU in the "
                          "body; from /tf_static if absent\n";
  out += "  specific_force_scale: " + format_csv_number(c.specific_force_scale) +
         "  # 9.80665 for an accelerometer in g\n"
         "  gyro_noise: " +
         format_csv_number(c.gyro_noise) +
         "  # rad/s/sqrt(Hz)\n"
         "  accelerometer_noise: " +
         format_csv_number(c.accelerometer_noise) +
         "  # m/s^2/sqrt(Hz)\n"
         "odometer:\n" +
         source(c.odometer) + "  scale: " + format_csv_number(c.odometer_scale) +
         "  # -1 turns its direction round\n  delay: " + format_csv_number(c.odometer_delay) +
         "  # s, of its stamps behind what was measured\n" + (c.wheels ? to_yaml(*c.wheels) : "") +
         "gps:\n" + source(c.gps) + "  deviation: " + format_csv_number(c.gps_deviation) +
         "  # m, where a fix states no usable covariance\n"
         "  deviation_factor: " +
         format_csv_number(c.gps_factor) +
         "  # on the deviations that fixes state\n"
         "  correlation_time: " +
         format_csv_number(c.gps_correlation) + "  # s, of the errors of GPS\n";
  out += c.gps_shortest_correlation
             ? "  shortest_correlation_time: " + format_csv_number(*c.gps_shortest_correlation) +
                   "  # s; found on line between both\n"
             : "  # shortest_correlation_time: 0  # s; below correlation_time: found on line "
               "between both\n";
  out += "  time_offset_deviation: " + format_csv_number(c.gps_time_offset_deviation) +
         "  # s, of the delay of fixes, which is estimated; 0: none\n";
  out += c.antenna ? "  antenna: " + list(*c.antenna) + "  # m, in the body\n"
                   : "  # antenna: [0, 0, 0]  # m, in the body; from /tf_static if absent\n";
  if (c.start) {
    out += to_yaml(*c.start);
  }
  if (!c.further.empty()) {
    out += "further_sources:\n";
    for (const NamedSource& further : c.further) {
      out += to_yaml(further);
    }
  }
  if (!c.sources.empty()) {
    out += "sources:\n" + c.sources + "\n";
  }
  return out;
}

}  // namespace pipescout::estimate
