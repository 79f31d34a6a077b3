// SPDX-License-Identifier: Apache-2.0
#include "pipescout/thermal_files/thermal_settings.hpp"

#include "pipescout/thermal_files/yaml_entries.hpp"

namespace pipescout {
namespace {

class Reader : public YamlEntries {
 public:
  using YamlEntries::YamlEntries;
  void read(const YAML::Node& root, ThermalSettings& settings) const;

 private:
  void object(const YAML::Node& node, ObjectChanges& changes) const;
  void regions(const YAML::Node& node, std::vector<RegionChanges>& regions) const;
  void deviations(const YAML::Node& node, thermal::ParameterDeviations& d) const;
  void planck(const YAML::Node& node, ThermalSettings& settings) const;
  void scale(const YAML::Node& node, ThermalSettings& settings) const;
  void grey(const YAML::Node& node, ThermalSettings& settings) const;
  void range(const YAML::Node& node, ThermalSettings& settings) const;
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
          {number_into("emissivity", changes.emissivity),
           number_into("reflected_temperature", changes.reflected_temperature),
           number_into("distance", changes.distance),
           number_into("atmospheric_temperature", changes.atmospheric_temperature),
           number_into("relative_humidity", changes.relative_humidity),
           number_into("window_temperature", changes.window_temperature),
           number_into("window_transmission", changes.window_transmission)});
  checked(node, [&changes] { changes.apply({}).validate(); });
}

void Reader::regions(const YAML::Node& node, std::vector<RegionChanges>& regions) const {
  if (!node.IsSequence()) {
    refuse(node, "regions is no list");
  }
  for (const YAML::Node& item : node) {
    RegionChanges region;
    entries(item, "a region",
            {whole_into("x", region.x),
             whole_into("y", region.y),
             whole_into("width", region.width),
             whole_into("height", region.height),
             {"object", [&](const YAML::Node& n) { object(n, region.object); }}});
    if (region.x < 0 || region.y < 0 || region.width < 1 || region.height < 1) {
      refuse(item, "a region needs x and y in [0, inf), width and height in [1, inf) pixels");
    }
    regions.push_back(region);
  }
}

void Reader::deviations(const YAML::Node& node, thermal::ParameterDeviations& d) const {
  entries(node, "deviations",
          {number_into("counts", d.counts), number_into("calibration", d.calibration),
           number_into("emissivity", d.emissivity),
           number_into("reflected_temperature", d.reflected_temperature),
           number_into("distance", d.distance),
           number_into("atmospheric_temperature", d.atmospheric_temperature),
           number_into("relative_humidity", d.relative_humidity),
           number_into("window_temperature", d.window_temperature),
           number_into("window_transmission", d.window_transmission)});
  checked(node, [&d] { d.validate(); });
}

void Reader::planck(const YAML::Node& node, ThermalSettings& settings) const {
  thermal::PlanckConstants& p = settings.planck.emplace();
  entries(node, "planck",
          {number_into("r1", p.r1), number_into("r2", p.r2), number_into("b", p.b),
           number_into("f", p.f), number_into("o", p.o)});
  checked(node, [&p] { p.validate(); });
}

void Reader::scale(const YAML::Node& node, ThermalSettings& settings) const {
  LinearScale& scale = settings.scale.emplace();
  entries(node, "scale", {number_into("gain", scale.gain), number_into("offset", scale.offset)});
  checked(node, [&scale] { thermal::TemperatureTable(scale.gain, scale.offset); });
}

void Reader::grey(const YAML::Node& node, ThermalSettings& settings) const {
  GreyScale& grey = settings.grey.emplace();
  entries(node, "grey", {number_into("black", grey.black), number_into("white", grey.white)});
  checked(node, [&grey] { (void)thermal::TemperatureTable::of_grey(grey.black, grey.white); });
}

void Reader::range(const YAML::Node& node, ThermalSettings& settings) const {
  int least = 0;
  int most = 65535;
  entries(node, "range", {whole_into("least", least), whole_into("most", most)});
  if (least < 0 || most > 65535 || least >= most) {
    refuse(node, "range needs 0 <= least < most <= 65535");
  }
  settings.range = {static_cast<std::uint16_t>(least), static_cast<std::uint16_t>(most)};
}

void Reader::read(const YAML::Node& root, ThermalSettings& settings) const {
  bool preset = false;
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
  const Reader reader(name);
  const YAML::Node root = reader.root(text);
  ThermalSettings settings;
  if (!root.IsNull()) {
    reader.read(root, settings);
  }
  return settings;
}

ThermalSettings read_thermal_settings(const std::filesystem::path& file) {
  return parse_thermal_settings(text_of(file), file.string());
}

}  // namespace pipescout
