// SPDX-License-Identifier: Apache-2.0
#include "pipescout/thermal_files/thermal_settings.hpp"

#include "pipescout/thermal_files/yaml_entries.hpp"

namespace pipescout {
namespace {

// The names of the form, in one place for reader and writer.

template <class Visit>
void each_field(ObjectChanges& changes, const Visit& visit) {
  visit("emissivity", changes.emissivity);
  visit("reflected_temperature", changes.reflected_temperature);
  visit("distance", changes.distance);
  visit("atmospheric_temperature", changes.atmospheric_temperature);
  visit("relative_humidity", changes.relative_humidity);
  visit("window_temperature", changes.window_temperature);
  visit("window_transmission", changes.window_transmission);
}

template <class Visit>
void each_field(thermal::ParameterDeviations& d, const Visit& visit) {
  visit("counts", d.counts);
  visit("calibration", d.calibration);
  visit("emissivity", d.emissivity);
  visit("reflected_temperature", d.reflected_temperature);
  visit("distance", d.distance);
  visit("atmospheric_temperature", d.atmospheric_temperature);
  visit("relative_humidity", d.relative_humidity);
  visit("window_temperature", d.window_temperature);
  visit("window_transmission", d.window_transmission);
}

template <class Visit>
void each_field(thermal::PlanckConstants& p, const Visit& visit) {
  visit("r1", p.r1);
  visit("r2", p.r2);
  visit("b", p.b);
  visit("f", p.f);
  visit("o", p.o);
}

template <class Visit>
void each_field(LinearScale& scale, const Visit& visit) {
  visit("gain", scale.gain);
  visit("offset", scale.offset);
}

constexpr const char* kAutomaticGain = "automatic_gain";

template <class Visit>
void each_field(thermal::PipeTemperatureRange& range, const Visit& visit) {
  visit("least", range.least);
  visit("most", range.most);
}

template <class Visit>
void each_field(GreyScale& grey, const Visit& visit) {
  visit("black", grey.black);
  visit("white", grey.white);
}

const std::vector<std::string> kTemperatureUnits{"celsius", "kelvin"};
const std::vector<std::string> kAirPaths{"before_window", "window_midway"};

class Reader : public YamlEntries {
 public:
  using YamlEntries::YamlEntries;
  void read(const YAML::Node& root, ThermalSettings& settings) const;

 private:
  template <class Fields>
  void fields(const YAML::Node& node, const char* what, Fields& target) const;
  void object(const YAML::Node& node, ObjectChanges& changes) const;
  void regions(const YAML::Node& node, std::vector<RegionChanges>& regions) const;
  void deviations(const YAML::Node& node, thermal::ParameterDeviations& d) const;
  void planck(const YAML::Node& node, ThermalSettings& settings) const;
  void scale(const YAML::Node& node, ThermalSettings& settings) const;
  void grey(const YAML::Node& node, ThermalSettings& settings) const;
  void range(const YAML::Node& node, ThermalSettings& settings) const;
};

template <class Fields>
void Reader::fields(const YAML::Node& node, const char* what, Fields& target) const {
  std::vector<Entry> known;
  each_field(target,
             [&](const char* name, auto& value) { known.push_back(number_into(name, value)); });
  entries(node, what, known);
}

void Reader::object(const YAML::Node& node, ObjectChanges& changes) const {
  fields(node, "object", changes);
  checked(node, [&changes] { changes.apply({}).validate(); });
}

void Reader::regions(const YAML::Node& node, std::vector<RegionChanges>& regions) const {
  if (!node.IsSequence()) {
    refuse(node, "regions is not a list");
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
  fields(node, "deviations", d);
  checked(node, [&d] { d.validate(); });
}

void Reader::planck(const YAML::Node& node, ThermalSettings& settings) const {
  thermal::PlanckConstants& p = settings.planck.emplace();
  fields(node, "planck", p);
  checked(node, [&p] { p.validate(); });
}

void Reader::scale(const YAML::Node& node, ThermalSettings& settings) const {
  LinearScale& scale = settings.scale.emplace();
  fields(node, "scale", scale);
  checked(node, [&scale] { thermal::TemperatureTable(scale.gain, scale.offset); });
}

void Reader::grey(const YAML::Node& node, ThermalSettings& settings) const {
  if (node.IsScalar() && node.Scalar() == kAutomaticGain) {
    settings.automatic_gain = true;
    return;
  }
  GreyScale& grey = settings.grey.emplace();
  fields(node, "grey", grey);
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
           {"pipe_temperature",
            [&](const YAML::Node& n) {
              fields(n, "pipe_temperature", settings.pipe_temperature);
              checked(n, [&] { settings.pipe_temperature.validate(); });
            }},
           {"float_unit",
            [&](const YAML::Node& n) {
              settings.float_unit = static_cast<TemperatureUnit>(chosen(n, kTemperatureUnits));
            }},
           {"air_path",
            [&](const YAML::Node& n) {
              settings.air_path = static_cast<thermal::AirPath>(chosen(n, kAirPaths));
            }},
           {"range", [&](const YAML::Node& n) { range(n, settings); }}});
  if (preset) {
    settings.object = ObjectChanges::to(settings.object.apply(thermal::ibarguren2013_object()));
  }
  if (settings.scale && settings.planck) {
    refuse(root, "scale and planck exclude each other");
  }
}

/// As text: yaml-cpp would group its digits by the global locale.
void emit_integer(YAML::Emitter& out, const char* name, int value) {
  out << YAML::Key << name << YAML::Value << std::to_string(value);
}

template <class Fields>
void emit(YAML::Emitter& out, const char* name, Fields fields) {
  out << YAML::Key << name << YAML::Value << YAML::Flow << YAML::BeginMap;
  each_field(fields, [&out](const char* key, const std::optional<double>& value) {
    if (value) {
      out << YAML::Key << key << YAML::Value << yaml_number(*value);
    }
  });
  out << YAML::EndMap;
}

template <class Fields>
void emit(YAML::Emitter& out, const char* name, const std::optional<Fields>& fields) {
  if (fields) {
    emit(out, name, *fields);
  }
}

}  // namespace

ObjectChanges ObjectChanges::to(const thermal::ObjectParameters& object) {
  return {.emissivity = object.emissivity,
          .reflected_temperature = object.reflected_temperature,
          .distance = object.distance,
          .atmospheric_temperature = object.atmospheric_temperature,
          .relative_humidity = object.relative_humidity,
          .window_temperature = object.window_temperature,
          .window_transmission = object.window_transmission};
}

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

std::string to_yaml(const ThermalSettings& settings) {
  YAML::Emitter out;
  out << YAML::BeginMap;
  emit(out, "object", settings.object);
  if (!settings.regions.empty()) {
    out << YAML::Key << "regions" << YAML::Value << YAML::BeginSeq;
    for (const RegionChanges& region : settings.regions) {
      out << YAML::Flow << YAML::BeginMap;
      for (const auto& [name, value] :
           {std::pair("x", region.x), std::pair("y", region.y), std::pair("width", region.width),
            std::pair("height", region.height)}) {
        emit_integer(out, name, value);
      }
      emit(out, "object", region.object);
      out << YAML::EndMap;
    }
    out << YAML::EndSeq;
  }
  emit(out, "deviations", settings.deviations);
  emit(out, "scale", settings.scale);
  emit(out, "planck", settings.planck);
  emit(out, "grey", settings.grey);
  if (settings.automatic_gain) {
    out << YAML::Key << "grey" << YAML::Value << kAutomaticGain;
  }
  emit(out, "pipe_temperature", settings.pipe_temperature);
  out << YAML::Key << "float_unit" << YAML::Value
      << kTemperatureUnits.at(static_cast<std::size_t>(settings.float_unit));
  out << YAML::Key << "air_path" << YAML::Value
      << kAirPaths.at(static_cast<std::size_t>(settings.air_path));
  if (settings.range) {
    out << YAML::Key << "range" << YAML::Value << YAML::Flow << YAML::BeginMap;
    emit_integer(out, "least", settings.range->least);
    emit_integer(out, "most", settings.range->most);
    out << YAML::EndMap;
  }
  out << YAML::EndMap;
  return std::string(out.c_str()) + "\n";
}

ThermalSettings read_thermal_settings(const std::filesystem::path& file) {
  return parse_thermal_settings(text_of(file), file.string());
}

}  // namespace pipescout
