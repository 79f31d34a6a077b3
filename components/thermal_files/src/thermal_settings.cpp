// SPDX-License-Identifier: Apache-2.0
#include "pipescout/thermal_files/thermal_settings.hpp"

#include <yaml-cpp/yaml.h>

#include <fstream>
#include <functional>
#include <set>
#include <sstream>
#include <stdexcept>
#include <utility>

namespace pipescout {
namespace {

class Reader {
 public:
  using Entry = std::pair<const char*, std::function<void(const YAML::Node&)>>;

  explicit Reader(std::string name) : name_(std::move(name)) {}

  [[noreturn]] void refuse(const YAML::Node& node, const std::string& what) const {
    throw std::runtime_error(name_ + ":" + std::to_string(node.Mark().line + 1) + ": " + what);
  }

  /// Hands each value of a map to the entry of its name.
  void entries(const YAML::Node& map, const std::string& what,
               const std::vector<Entry>& known) const {
    if (!map.IsMap()) {
      refuse(map, what + " is no map");
    }
    std::set<std::string> seen;
    for (const auto& pair : map) {
      const auto key = pair.first.as<std::string>();
      if (!seen.insert(key).second) {
        refuse(pair.first, "'" + key + "' is given twice");
      }
      const Entry* found = nullptr;
      std::string names;
      for (const Entry& entry : known) {
        found = entry.first == key ? &entry : found;
        names += (names.empty() ? "" : ", ") + std::string(entry.first);
      }
      if (found == nullptr) {
        refuse(pair.first, "unknown name '" + key + "'; there is " + names);
      }
      found->second(pair.second);
    }
  }

  template <class T>
  [[nodiscard]] T value(const YAML::Node& node, const char* kind) const {
    try {
      return node.as<T>();
    } catch (const YAML::Exception&) {
      refuse(node,
             "'" + (node.IsScalar() ? node.Scalar() : std::string("...")) + "' is no " + kind);
    }
  }

  template <class Target>
  [[nodiscard]] Entry number(const char* key, Target& target) const {
    return {key,
            [this, &target](const YAML::Node& node) { target = value<double>(node, "number"); }};
  }
  [[nodiscard]] Entry whole(const char* key, int& target) const {
    return {key,
            [this, &target](const YAML::Node& node) { target = value<int>(node, "whole number"); }};
  }

  /// Refuses what `check` throws, at this node.
  void checked(const YAML::Node& node, const std::function<void()>& check) const {
    try {
      check();
    } catch (const std::invalid_argument& error) {
      refuse(node, error.what());
    }
  }

  void read(const YAML::Node& root, ThermalSettings& settings) const;

 private:
  void object(const YAML::Node& node, ObjectChanges& changes) const;
  void regions(const YAML::Node& node, std::vector<RegionChanges>& regions) const;
  void deviations(const YAML::Node& node, thermal::ParameterDeviations& d) const;
  void planck(const YAML::Node& node, ThermalSettings& settings) const;
  void scale(const YAML::Node& node, ThermalSettings& settings) const;
  void grey(const YAML::Node& node, ThermalSettings& settings) const;
  void range(const YAML::Node& node, ThermalSettings& settings) const;

  std::string name_;
};

/// All of them.
ObjectChanges changes_to(const thermal::ObjectParameters& object) {
  return {.emissivity = object.emissivity,
          .reflected_temperature = object.reflected_temperature,
          .distance = object.distance,
          .atmospheric_temperature = object.atmospheric_temperature,
          .relative_humidity = object.relative_humidity,
          .window_temperature = object.window_temperature,
          .window_transmission = object.window_transmission};
}

void Reader::object(const YAML::Node& node, ObjectChanges& changes) const {
  entries(node, "object",
          {number("emissivity", changes.emissivity),
           number("reflected_temperature", changes.reflected_temperature),
           number("distance", changes.distance),
           number("atmospheric_temperature", changes.atmospheric_temperature),
           number("relative_humidity", changes.relative_humidity),
           number("window_temperature", changes.window_temperature),
           number("window_transmission", changes.window_transmission)});
  checked(node, [&changes] { changes.apply({}).validate(); });
}

void Reader::regions(const YAML::Node& node, std::vector<RegionChanges>& regions) const {
  if (!node.IsSequence()) {
    refuse(node, "regions is no list");
  }
  for (const YAML::Node& item : node) {
    RegionChanges region;
    entries(item, "a region",
            {whole("x", region.x),
             whole("y", region.y),
             whole("width", region.width),
             whole("height", region.height),
             {"object", [&](const YAML::Node& n) { object(n, region.object); }}});
    if (region.x < 0 || region.y < 0 || region.width < 1 || region.height < 1) {
      refuse(item, "a region needs x and y in [0, inf), width and height in [1, inf) pixels");
    }
    regions.push_back(region);
  }
}

void Reader::deviations(const YAML::Node& node, thermal::ParameterDeviations& d) const {
  entries(
      node, "deviations",
      {number("counts", d.counts), number("calibration", d.calibration),
       number("emissivity", d.emissivity), number("reflected_temperature", d.reflected_temperature),
       number("distance", d.distance), number("atmospheric_temperature", d.atmospheric_temperature),
       number("relative_humidity", d.relative_humidity),
       number("window_temperature", d.window_temperature),
       number("window_transmission", d.window_transmission)});
  checked(node, [&d] { d.validate(); });
}

void Reader::planck(const YAML::Node& node, ThermalSettings& settings) const {
  thermal::PlanckConstants& p = settings.planck.emplace();
  entries(node, "planck",
          {number("r1", p.r1), number("r2", p.r2), number("b", p.b), number("f", p.f),
           number("o", p.o)});
  checked(node, [&p] { p.validate(); });
}

void Reader::scale(const YAML::Node& node, ThermalSettings& settings) const {
  LinearScale& scale = settings.scale.emplace();
  entries(node, "scale", {number("gain", scale.gain), number("offset", scale.offset)});
  checked(node, [&scale] { thermal::TemperatureTable(scale.gain, scale.offset); });
}

void Reader::grey(const YAML::Node& node, ThermalSettings& settings) const {
  GreyScale& grey = settings.grey.emplace();
  entries(node, "grey", {number("black", grey.black), number("white", grey.white)});
  checked(node, [&grey] { (void)thermal::TemperatureTable::of_grey(grey.black, grey.white); });
}

void Reader::range(const YAML::Node& node, ThermalSettings& settings) const {
  int least = 0;
  int most = 65535;
  entries(node, "range", {whole("least", least), whole("most", most)});
  if (least < 0 || most > 65535 || least >= most) {
    refuse(node, "range needs 0 <= least < most <= 65535");
  }
  settings.range = {static_cast<std::uint16_t>(least), static_cast<std::uint16_t>(most)};
}

void Reader::read(const YAML::Node& root, ThermalSettings& settings) const {
  bool preset = false;
  const auto chosen = [this](const YAML::Node& node,
                             const std::vector<std::string>& names) -> std::size_t {
    const auto text = value<std::string>(node, "text");
    std::string list;
    for (std::size_t i = 0; i < names.size(); ++i) {
      if (names[i] == text) {
        return i;
      }
      list += (i == 0 ? "" : ", ") + names[i];
    }
    refuse(node, "'" + text + "' is none of " + list);
  };
  entries(root, "the file",
          {{"preset",
            [&](const YAML::Node& n) {
              (void)chosen(n, {"ibarguren2013"});
              preset = true;
            }},
           {"object", [&](const YAML::Node& n) { object(n, settings.object); }},
           {"regions", [&](const YAML::Node& n) { regions(n, settings.regions); }},
           {"deviations", [&](const YAML::Node& n) { deviations(n, settings.deviations); }},
           {"scale", [&](const YAML::Node& n) { scale(n, settings); }},
           {"planck", [&](const YAML::Node& n) { planck(n, settings); }},
           {"grey", [&](const YAML::Node& n) { grey(n, settings); }},
           {"float_unit",
            [&](const YAML::Node& n) {
              settings.float_unit = static_cast<TemperatureUnit>(chosen(n, {"celsius", "kelvin"}));
            }},
           {"air_path",
            [&](const YAML::Node& n) {
              settings.air_path =
                  static_cast<thermal::AirPath>(chosen(n, {"before_window", "window_midway"}));
            }},
           {"range", [&](const YAML::Node& n) { range(n, settings); }}});
  if (preset) {
    settings.object = changes_to(settings.object.apply(thermal::ibarguren2013_object()));
  }
  if (settings.scale && settings.planck) {
    refuse(root, "scale and planck both say what 16-bit counts mean");
  }
}

}  // namespace

thermal::ObjectParameters ObjectChanges::apply(thermal::ObjectParameters object) const {
  object.emissivity = emissivity.value_or(object.emissivity);
  object.reflected_temperature = reflected_temperature.value_or(object.reflected_temperature);
  object.distance = distance.value_or(object.distance);
  object.atmospheric_temperature = atmospheric_temperature.value_or(object.atmospheric_temperature);
  object.relative_humidity = relative_humidity.value_or(object.relative_humidity);
  object.window_temperature = window_temperature.value_or(object.window_temperature);
  object.window_transmission = window_transmission.value_or(object.window_transmission);
  return object;
}

ThermalSettings parse_thermal_settings(const std::string& text, const std::string& name) {
  YAML::Node root;
  try {
    root = YAML::Load(text);
  } catch (const YAML::Exception& error) {
    throw std::runtime_error(name + ":" + std::to_string(error.mark.line + 1) + ": " + error.msg);
  }
  ThermalSettings settings;
  if (!root.IsNull()) {
    Reader(name).read(root, settings);
  }
  return settings;
}

ThermalSettings read_thermal_settings(const std::filesystem::path& file) {
  std::ifstream stream(file);
  std::ostringstream text;
  text << stream.rdbuf();
  if (!stream) {
    throw std::runtime_error(file.string() + ": cannot be read");
  }
  return parse_thermal_settings(text.str(), file.string());
}

}  // namespace pipescout
