// SPDX-License-Identifier: Apache-2.0
#include "configuration.hpp"

#include <yaml-cpp/yaml.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <set>
#include <string_view>
#include <tuple>

#include "known_keys.hpp"
#include "pipescout/csv/csv_table.hpp"
#include "pipescout/files/yaml_location.hpp"

namespace pipescout::estimate {
namespace {

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
    return "it seems to be a velocity of GPS, along the axes of the map";
  }
  if (contains_any(s.name, {"filtered", "fused", "ekf", "ukf", "global", "ground_truth"})) {
    return "it seems to be the output of another estimator";
  }
  return {};
}

/// Larger is better; topics of which nothing can be used are not candidates.
const Stream* best(const Recording& recording, Kind kind, std::vector<std::string>& said) {
  const Stream* chosen = nullptr;
  const auto rank = [&](const Stream& s) {
    const bool named = kind == Kind::kOdometer && contains_any(s.name, {"odom", "wheel"});
    // Wheels that were configured are meant.
    const bool wheels = s.type == "sensor_msgs/msg/JointState";
    return std::tuple(wheels, named, s.rows());
  };
  for (const Stream& s : recording.streams) {
    if (s.kind != kind) {
      continue;
    }
    if (s.rows() == 0) {
      said.push_back(s.name + " (" + s.type + "): no usable message.");
      continue;
    }
    if (const std::string why = kind == Kind::kOdometer ? why_no_odometer(s) : ""; !why.empty()) {
      said.push_back(s.name + " (" + s.type + "): not used, " + why + ".");
      continue;
    }
    if (chosen == nullptr || rank(s) > rank(*chosen)) {
      chosen = &s;
    }
  }
  for (const Stream& s : recording.streams) {
    if (chosen != nullptr && s.kind == kind && &s != chosen && s.rows() > 0 &&
        (kind != Kind::kOdometer || why_no_odometer(s).empty())) {
      said.push_back(s.name + " (" + s.type + "): not used, because " + chosen->name +
                     " is taken for the same. Name it in the configuration to use it instead.");
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
  Section(const YAML::Node& node, std::string path, const std::set<std::string>& known)
      : node_(node), path_(std::move(path)) {
    require_known_keys(node_, known, path_);
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
  const Section s(node, path, {"left", "right", "radius", "track"});
  s.read("left", wheels.left);
  s.read("right", wheels.right);
  s.read("radius", wheels.wheel_radius, 0, 100);
  s.read("track", wheels.track, 0, 100);
  try {
    wheels.validate();
  } catch (const std::invalid_argument& error) {
    throw YamlError(path, node.Mark(), std::string("wheels: ") + error.what());
  }
  return wheels;
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

std::string to_yaml(const estimation::WheelDriveParameters& wheels) {
  const auto names = [](const std::vector<std::string>& side) {
    std::string all;
    for (const std::string& name : side) {
      all += (all.empty() ? "" : ", ") + quoted(name);
    }
    return "[" + all + "]";
  };
  return "  wheels:\n    left: " + names(wheels.left) + "\n    right: " + names(wheels.right) +
         "\n    radius: " + format_csv_number(wheels.wheel_radius) +
         "  # m\n    track: " + format_csv_number(wheels.track) + "  # m\n";
}

}  // namespace

Guess guess(const Recording& recording) {
  Guess result;
  Configuration& c = result.configuration;
  if (const Stream* s = best(recording, Kind::kImu, result.said)) {
    c.imu = s->name;
    say(*s, "the IMU", result.said);
  }
  if (const Stream* s = best(recording, Kind::kOdometer, result.said)) {
    c.odometer = s->name;
    c.base_frame = s->frame.empty() ? c.base_frame : s->frame;
    say(*s, "the odometer (speed along x, yaw rate)", result.said);
  }
  if (const Stream* s = best(recording, Kind::kGps, result.said)) {
    c.gps = s->name;
    say(*s, "GPS", result.said);
  }
  return result;
}

Configuration read_configuration(const std::string& path, const Configuration& defaults) {
  Configuration c = defaults;
  const YAML::Node root = load_yaml(path);
  if (root.IsNull()) {
    return c;
  }
  const Section top(root, path, {"base_frame", "imu", "odometer", "gps", "sources"});
  top.read("base_frame", c.base_frame);
  if (const YAML::Node node = top.at("imu"); node.IsDefined()) {
    const Section s(
        node, path,
        {"source", "rotation", "specific_force_scale", "gyro_noise", "accelerometer_noise"});
    s.read("source", c.imu);
    s.read("rotation", c.imu_rotation);
    s.read("specific_force_scale", c.specific_force_scale, 1e-3, 1e3);
    s.read("gyro_noise", c.gyro_noise, 1e-7, 1);
    s.read("accelerometer_noise", c.accelerometer_noise, 1e-6, 10);
  }
  if (const YAML::Node node = top.at("odometer"); node.IsDefined()) {
    const Section s(node, path, {"source", "scale", "wheels"});
    s.read("source", c.odometer);
    if (const YAML::Node wheels = s.at("wheels"); wheels.IsDefined()) {
      c.wheels = read_wheels(wheels, path);
    }
    s.read("scale", c.odometer_scale, -1000, 1000);
  }
  if (const YAML::Node node = top.at("gps"); node.IsDefined()) {
    const Section s(node, path,
                    {"source", "deviation", "deviation_factor", "correlation_time", "antenna"});
    s.read("source", c.gps);
    s.read("deviation", c.gps_deviation, 1e-3, 1e4);
    s.read("deviation_factor", c.gps_factor, 1e-3, 1e3);
    s.read("correlation_time", c.gps_correlation, 0, 1000);
    s.read("antenna", c.antenna);
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
         "  # -1 turns its direction round\n" + (c.wheels ? to_yaml(*c.wheels) : "") + "gps:\n" +
         source(c.gps) + "  deviation: " + format_csv_number(c.gps_deviation) +
         "  # m, where a fix states no usable covariance\n"
         "  deviation_factor: " +
         format_csv_number(c.gps_factor) +
         "  # on the deviations that fixes state\n"
         "  correlation_time: " +
         format_csv_number(c.gps_correlation) + "  # s, of the errors of GPS\n";
  out += c.antenna ? "  antenna: " + list(*c.antenna) + "  # m, in the body\n"
                   : "  # antenna: [0, 0, 0]  # m, in the body; from /tf_static if absent\n";
  if (!c.sources.empty()) {
    out += "sources:\n" + c.sources + "\n";
  }
  return out;
}

}  // namespace pipescout::estimate
