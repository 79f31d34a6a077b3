// SPDX-License-Identifier: Apache-2.0
#include "core/composition.hpp"

#include <yaml-cpp/yaml.h>

#include <algorithm>
#include <filesystem>
#include <initializer_list>
#include <map>
#include <thread>

#include "pipescout/command_line/suggestion.hpp"
#include "pipescout/files/yaml_location.hpp"

namespace pipescout::host {
namespace {

using command_line::suggestion;

constexpr std::size_t kMostThreads = 256;
constexpr int kMostRestarts = 1000000;
constexpr double kLongestBackoff = 3600.0;  // s

class Reader {
 public:
  Reader(const std::string& path, const CompositionInputs& inputs)
      : path_(path), inputs_(inputs), sources_(inputs.sources) {
    composition_.path = path;
  }

  Composition read(const YAML::Node& root) {
    if (!root.IsMap()) {
      fail(root,
           "a composition is a map with the keys name, arguments, executor, components, "
           "complete_when");
    }
    check_keys(root, "the composition",
               {"name", "arguments", "executor", "components", "complete_when"});
    read_arguments(root["arguments"]);
    read_name(root["name"]);
    if (inputs_.mission_folder) {
      composition_.mission_folder = inputs_.mission_folder(composition_.name);
      sources_.mission_folder = composition_.mission_folder;
    }
    read_executor(root["executor"]);
    const auto components = root["components"];
    if (!components) {
      fail(root, "key 'components' is missing");
    }
    read_components(components);
    read_complete_when(root["complete_when"]);
    apply_parameter_files();
    apply_parameter_arguments();
    return std::move(composition_);
  }

 private:
  [[noreturn]] void fail(const YAML::Node& node, const std::string& message) const {
    throw YamlError(path_, node.Mark(), message);
  }

  void check_keys(const YAML::Node& map, const std::string& what,
                  std::initializer_list<const char*> known) const {
    const std::vector<std::string> names(known.begin(), known.end());
    for (const auto& entry : map) {
      const auto& key = entry.first.Scalar();
      if (std::find(names.begin(), names.end(), key) == names.end()) {
        std::string list;
        for (const auto& name : names) {
          list += (list.empty() ? "" : ", ") + name;
        }
        fail(entry.first, "unknown key '" + key + "' in " + what + suggestion(key, names) +
                              " (known: " + list + ")");
      }
    }
  }

  std::string substituted(const YAML::Node& node, const std::string& text) const {
    try {
      return substitute(text, sources_);
    } catch (const SubstitutionError& error) {
      fail(node, error.what());
    }
  }

  /// A text with its substitutions replaced.
  std::string text(const YAML::Node& node, const std::string& what) const {
    if (!node.IsScalar()) {
      fail(node, what + " must be a text");
    }
    return substituted(node, node.Scalar());
  }

  ParameterValue typed(const YAML::Node& node, const std::string& what) const {
    const auto value = text(node, what);
    try {
      return type_yaml_scalar(value);
    } catch (const std::out_of_range& error) {
      fail(node, what + ": " + error.what());
    }
  }

  bool boolean(const YAML::Node& node, const std::string& what) const {
    const auto value = typed(node, what);
    if (const auto* result = value.get_if<bool>()) {
      return *result;
    }
    fail(node, what + " must be true or false, not '" + node.Scalar() + "'");
  }

  std::int64_t integer(const YAML::Node& node, const std::string& what, std::int64_t from,
                       std::int64_t to) const {
    const auto value = typed(node, what);
    const auto* result = value.get_if<std::int64_t>();
    if (result == nullptr || *result < from || *result > to) {
      fail(node, what + " must be a whole number in [" + std::to_string(from) + ", " +
                     std::to_string(to) + "], not '" + node.Scalar() + "'");
    }
    return *result;
  }

  [[nodiscard]] std::map<std::string, std::string> given_arguments() const {
    std::map<std::string, std::string> given;
    for (const auto& [name, value] : inputs_.arguments) {
      const auto [first, is_new] = given.emplace(name, value);
      if (!is_new) {
        throw CompositionError("argument " + name + ":=" + value + ": '" + name +
                               "' is given twice, first as '" + first->second + "'");
      }
    }
    return given;
  }

  void read_arguments(const YAML::Node& node) {
    std::vector<std::string> names;
    const auto given = given_arguments();
    if (node && !node.IsNull()) {
      if (!node.IsMap()) {
        fail(node, "'arguments' must be a map of names to default values");
      }
      for (const auto& entry : node) {
        const auto& name = entry.first.Scalar();
        names.push_back(name);
        std::string value;
        if (const auto argument = given.find(name); argument != given.end()) {
          value = argument->second;
        } else if (entry.second.IsNull()) {
          fail(entry.first, "argument '" + name + "' has no default: give " + name + ":=VALUE");
        } else {
          value = text(entry.second, "the default of argument '" + name + "'");
        }
        sources_.arguments[name] = value;
        composition_.arguments.emplace_back(name, std::move(value));
      }
    }
    for (const auto& [name, value] : given) {
      if (std::find(names.begin(), names.end(), name) == names.end()) {
        throw CompositionError("argument " + name + ":=" + value + ": " + path_ +
                               " has no argument '" + name + "'" + suggestion(name, names));
      }
    }
  }

  void read_name(const YAML::Node& node) {
    const auto valid = [](const std::string& name) {
      return !name.empty() && std::all_of(name.begin(), name.end(), [](unsigned char c) {
        return std::isalnum(c) != 0 || c == '_' || c == '-';
      });
    };
    if (node) {
      composition_.name = text(node, "'name'");
      if (!valid(composition_.name)) {
        fail(node, "'name' must consist of letters, digits, '_' and '-', not '" +
                       composition_.name + "'");
      }
      return;
    }
    composition_.name = std::filesystem::path(path_).stem().string();
    if (!valid(composition_.name)) {
      composition_.name = "mission";
    }
  }

  void read_executor(const YAML::Node& node) {
    if (!node) {
      return;
    }
    if (!node.IsMap()) {
      fail(node, "'executor' must be a map with the keys type, threads");
    }
    check_keys(node, "the executor", {"type", "threads"});
    const auto type = node["type"] ? text(node["type"], "'type'") : "single_threaded";
    if (type != "single_threaded" && type != "multi_threaded") {
      fail(node["type"], "'type' must be single_threaded or multi_threaded, not '" + type + "'");
    }
    if (node["threads"]) {
      composition_.threads = static_cast<std::size_t>(
          integer(node["threads"], "'threads'", 1, static_cast<std::int64_t>(kMostThreads)));
      if (type == "single_threaded" && composition_.threads != 1) {
        fail(node["threads"], "a single_threaded executor has one thread");
      }
    } else if (type == "multi_threaded") {
      composition_.threads = default_threads(std::thread::hardware_concurrency());
    }
  }

  void read_components(const YAML::Node& node) {
    if (node.IsNull()) {
      return;
    }
    if (!node.IsSequence()) {
      fail(node, "'components' must be a list");
    }
    std::map<NodeName, std::string> seen;
    for (const auto& item : node) {
      auto entry = read_component(item);
      const auto [other, is_new] = seen.emplace(entry.name, entry.location);
      if (!is_new) {
        fail(item["name"], "two components have the name '" + entry.name.fully_qualified() +
                               "'; the other is at " + other->second);
      }
      composition_.components.push_back(std::move(entry));
    }
  }

  ComponentEntry read_component(const YAML::Node& node) {
    if (!node.IsMap()) {
      fail(node, "a component is a map with the keys type, name, ...");
    }
    check_keys(node, "a component",
               {"type", "name", "namespace", "parameters", "parameter_files", "remappings",
                "isolate", "restart"});
    ComponentEntry entry;
    entry.location = location(path_, node.Mark());
    for (const char* key : {"type", "name"}) {
      if (!node[key]) {
        fail(node, std::string("key '") + key + "' of a component is missing");
      }
    }
    entry.type = text(node["type"], "'type'");
    entry.type_location = location(path_, node["type"].Mark());
    read_node_name(node, entry);
    if (node["parameter_files"]) {
      read_parameter_files(node["parameter_files"], entry);
    }
    if (node["parameters"] && !node["parameters"].IsNull()) {
      read_parameters(node["parameters"], entry);
    }
    if (node["remappings"]) {
      read_remappings(node["remappings"], entry);
    }
    if (node["isolate"]) {
      entry.isolate = boolean(node["isolate"], "'isolate'");
    }
    if (node["restart"]) {
      if (!entry.isolate) {
        fail(node["restart"], "'restart' is for a component with 'isolate: true'");
      }
      read_restart(node["restart"], entry.restart);
    }
    return entry;
  }

  void read_node_name(const YAML::Node& node, ComponentEntry& entry) const {
    entry.name.name = text(node["name"], "'name'");
    try {
      validate_node_name(entry.name.name);
    } catch (const InvalidName& error) {
      fail(node["name"], error.what());
    }
    entry.name.ns = inputs_.ns;
    if (!node["namespace"]) {
      return;
    }
    try {
      entry.name.ns = join_namespaces(inputs_.ns, text(node["namespace"], "'namespace'"));
    } catch (const InvalidName& error) {
      fail(node["namespace"], error.what());
    }
  }

  void read_parameter_files(const YAML::Node& node, ComponentEntry& entry) const {
    if (!node.IsSequence()) {
      fail(node, "'parameter_files' must be a list of files");
    }
    for (const auto& item : node) {
      auto file = std::filesystem::path(text(item, "a parameter file"));
      if (file.is_relative()) {
        file = std::filesystem::path(path_).parent_path() / file;
      }
      if (!std::filesystem::exists(file)) {
        fail(item, "missing parameter file " + file.string());
      }
      auto overrides =
          load_parameter_yaml(file.string()).overrides_for(entry.name.fully_qualified());
      if (overrides.empty()) {
        fail(item, file.string() + " has no parameter for " + entry.name.fully_qualified());
      }
      append(entry, std::move(overrides));
    }
  }

  void read_parameters(const YAML::Node& node, ComponentEntry& entry) const {
    auto overrides = read_parameter_map(node, path_);
    for (auto& parameter : overrides) {
      const auto value = find_parameter(node, parameter.name);
      parameter.source = location(path_, value.Mark());
      parameter.value = substituted_value(value, parameter);
    }
    append(entry, std::move(overrides));
  }

  /// A value that is one argument or environment variable gets the type that it would have if it
  /// were typed there; a path stays text, and so does what stands in a longer text or a list.
  ParameterValue substituted_value(const YAML::Node& node,
                                   const ParameterOverride& parameter) const {
    try {
      if (const auto* value = parameter.value.get_if<std::string>()) {
        auto result = substitute(*value, sources_);
        return has_type_of_its_value(*value) ? typed_text(result) : ParameterValue(result);
      }
      if (const auto* values = parameter.value.get_if<std::vector<std::string>>()) {
        std::vector<std::string> result;
        for (const auto& value : *values) {
          result.push_back(substitute(value, sources_));
        }
        return result;
      }
      return parameter.value;
    } catch (const std::invalid_argument& error) {
      fail(node, "parameter '" + parameter.name + "': " + error.what());
    }
  }

  /// The node of a parameter whose map was read: "a.b" is written as {a: {b: ...}} or {a.b: ...}.
  static YAML::Node find_parameter(const YAML::Node& map, const std::string& name) {
    for (const auto& entry : map) {
      const auto& key = entry.first.Scalar();
      if (key == name) {
        return entry.second;
      }
      if (entry.second.IsMap() && name.starts_with(key + ".")) {
        const auto below = find_parameter(entry.second, name.substr(key.size() + 1));
        if (below.IsDefined() && !below.IsNull()) {
          return below;
        }
      }
    }
    return YAML::Node();
  }

  static void append(ComponentEntry& entry, std::vector<ParameterOverride> overrides) {
    std::move(overrides.begin(), overrides.end(), std::back_inserter(entry.parameters));
  }

  void read_remappings(const YAML::Node& node, ComponentEntry& entry) const {
    if (!node.IsMap()) {
      fail(node, "'remappings' must be a map of names to new names");
    }
    for (const auto& item : node) {
      const auto rule =
          item.first.Scalar() + ":=" + text(item.second, "the new name of a remapping");
      try {
        entry.remappings.push_back(RemapRule::parse(rule));
      } catch (const InvalidName& error) {
        fail(item.first, error.what());
      }
      const auto kind = entry.remappings.back().kind;
      if (kind == RemapRule::Kind::kNodeName || kind == RemapRule::Kind::kNamespace) {
        fail(item.first, "a component is renamed by its 'name' and 'namespace'");
      }
    }
  }

  void read_restart(const YAML::Node& node, RestartPolicy& policy) const {
    if (!node.IsMap()) {
      fail(node, "'restart' must be a map with the keys limit, backoff");
    }
    check_keys(node, "'restart'", {"limit", "backoff"});
    if (node["limit"]) {
      policy.limit = static_cast<int>(integer(node["limit"], "'limit'", 0, kMostRestarts));
    }
    if (node["backoff"]) {
      const auto value = typed(node["backoff"], "'backoff'");
      double seconds = -1.0;
      if (const auto* real = value.get_if<double>()) {
        seconds = *real;
      } else if (const auto* whole = value.get_if<std::int64_t>()) {
        seconds = static_cast<double>(*whole);
      }
      if (!(seconds >= 0.0 && seconds <= kLongestBackoff)) {
        fail(node["backoff"], "'backoff' must be a number of seconds in [0, 3600], not '" +
                                  node["backoff"].Scalar() + "'");
      }
      policy.backoff = from_seconds(seconds);
    }
  }

  void read_complete_when(const YAML::Node& node) {
    if (!node || node.IsNull()) {
      return;
    }
    if (!node.IsSequence()) {
      fail(node, "'complete_when' must be a list of component names");
    }
    for (const auto& item : node) {
      const auto name = text(item, "a name in 'complete_when'");
      composition_.complete_when.push_back(component_named(item, name));
    }
  }

  NodeName component_named(const YAML::Node& node, const std::string& name) const {
    std::vector<NodeName> matches;
    for (const auto& entry : composition_.components) {
      if (entry.name.name == name || entry.name.fully_qualified() == name) {
        matches.push_back(entry.name);
      }
    }
    if (matches.empty()) {
      fail(node,
           "no component '" + name + "' in this composition" + suggestion(name, component_names()));
    }
    if (matches.size() > 1) {
      fail(node, "several components have the name '" + name + "': write it with its namespace, '" +
                     matches.front().fully_qualified() + "'");
    }
    return matches.front();
  }

  [[nodiscard]] std::vector<std::string> component_names() const {
    std::vector<std::string> names;
    for (const auto& entry : composition_.components) {
      names.push_back(entry.name.name);
    }
    return names;
  }

  /// What to call a component that a parameter file gets wrong: the one of the same name in another
  /// namespace, else the nearest.
  [[nodiscard]] std::string component_suggestion(const std::string& misspelt) const {
    const auto name = misspelt.substr(misspelt.rfind('/') + 1);
    std::vector<std::string> names;
    for (const auto& entry : composition_.components) {
      names.push_back(entry.name.fully_qualified());
      if (entry.name.name == name) {
        return "; did you mean '" + names.back() + "'?";
      }
    }
    return suggestion(misspelt, names);
  }

  /// Wildcards may match nothing: they are for whatever is there.
  void check_names_components(const ParameterFile& parameters) const {
    for (const auto& node : parameters.nodes()) {
      const bool known =
          std::any_of(composition_.components.begin(), composition_.components.end(),
                      [&](const ComponentEntry& entry) {
                        return matches_node_pattern(node.pattern, entry.name.fully_qualified());
                      });
      if (!known && node.pattern.find('*') == std::string::npos) {
        throw CompositionError(node.source + ": no component '" + node.pattern + "' in " + path_ +
                               component_suggestion(node.pattern));
      }
    }
  }

  void apply_parameter_files() {
    for (const auto& file : inputs_.parameter_files) {
      const auto parameters = load_parameter_yaml(file);
      check_names_components(parameters);
      for (auto& entry : composition_.components) {
        append(entry, parameters.overrides_for(entry.name.fully_qualified()));
      }
    }
  }

  void apply_parameter_arguments() {
    const auto names = component_names();
    const auto is_component = [&](const std::string& name) {
      return std::find(names.begin(), names.end(), name) != names.end();
    };
    for (const auto& argument : inputs_.parameters) {
      ParameterRule rule;
      try {
        rule = ParameterRule::parse(argument, "--param " + argument);
      } catch (const std::invalid_argument& error) {
        throw CompositionError(std::string("--param: ") + error.what());
      }
      const auto dot = rule.parameter.name.find('.');
      if (rule.node.empty() && dot != std::string::npos &&
          is_component(rule.parameter.name.substr(0, dot))) {
        rule.node = rule.parameter.name.substr(0, dot);
        rule.parameter.name.erase(0, dot + 1);
        rule.parameter.from_wildcard = false;
      }
      if (!rule.node.empty() && !is_component(rule.node)) {
        throw CompositionError("--param " + argument + ": no component '" + rule.node + "' in " +
                               path_ + suggestion(rule.node, names));
      }
      for (auto& entry : composition_.components) {
        if (rule.node.empty() || rule.node == entry.name.name) {
          entry.parameters.push_back(rule.parameter);
        }
      }
    }
  }

  const std::string& path_;
  const CompositionInputs& inputs_;
  SubstitutionSources sources_;
  Composition composition_;
};

std::string quoted(const std::string& text) {
  return to_yaml(ParameterValue(text));
}

}  // namespace

std::size_t default_threads(unsigned hardware_threads) {
  return std::clamp<std::size_t>(hardware_threads, 2, kMostThreads);
}

std::string located(const ComponentEntry& entry, const std::string& message) {
  const bool names_place =
      std::any_of(entry.parameters.begin(), entry.parameters.end(),
                  [&](const ParameterOverride& p) { return message.starts_with(p.source + ":"); });
  return names_place ? message : entry.location + ": " + message;
}

std::pair<std::string, std::string> parse_argument(const std::string& text) {
  const auto separator = text.find(":=");
  if (separator == std::string::npos || separator == 0) {
    throw CompositionError("'" + text + "' must have the form NAME:=VALUE");
  }
  return {text.substr(0, separator), text.substr(separator + 2)};
}

Composition load_composition(const std::string& path, const CompositionInputs& inputs) {
  return Reader(path, inputs).read(load_yaml(path));
}

Composition parse_composition(const std::string& text, const std::string& path,
                              const CompositionInputs& inputs) {
  return Reader(path, inputs).read(parse_yaml(text, path));
}

std::string to_yaml(const Composition& composition,
                    const std::vector<std::vector<NamedParameter>>& parameters) {
  std::string out = "# As it was run, from " + composition.path + "\n";
  out += "name: " + quoted(composition.name) + "\n";
  if (!composition.arguments.empty()) {
    out += "arguments:\n";
    for (const auto& [name, value] : composition.arguments) {
      out += "  " + quoted(name) + ": " + quoted(value) + "\n";
    }
  }
  out += composition.threads == 1
             ? std::string("executor: {type: single_threaded}\n")
             : "executor: {type: multi_threaded, threads: " + std::to_string(composition.threads) +
                   "}\n";
  out += composition.components.empty() ? "components: []\n" : "components:\n";
  for (std::size_t i = 0; i < composition.components.size(); ++i) {
    const auto& entry = composition.components[i];
    out += "  - type: " + quoted(entry.type) + "\n";
    out += "    name: " + quoted(entry.name.name) + "\n";
    if (entry.name.ns != "/") {
      out += "    namespace: " + quoted(entry.name.ns) + "\n";
    }
    if (i < parameters.size() && !parameters[i].empty()) {
      out += "    parameters:\n";
      for (const auto& parameter : parameters[i]) {
        if (parameter.value.is_set()) {
          out += "      " + quoted(parameter.name) + ": " + to_yaml(parameter.value) + "\n";
        }
      }
    }
    if (!entry.remappings.empty()) {
      out += "    remappings:\n";
      for (const auto& rule : entry.remappings) {
        const auto scheme = rule.kind == RemapRule::Kind::kTopic     ? "rostopic://"
                            : rule.kind == RemapRule::Kind::kService ? "rosservice://"
                                                                     : "";
        out += "      " + quoted(scheme + rule.from) + ": " + quoted(rule.to) + "\n";
      }
    }
    if (entry.isolate) {
      out += "    isolate: true\n";
      out += "    restart: {limit: " + std::to_string(entry.restart.limit) +
             ", backoff: " + to_yaml(ParameterValue(to_seconds(entry.restart.backoff))) + "}\n";
    }
  }
  if (!composition.complete_when.empty()) {
    out += "complete_when:\n";
    for (const auto& name : composition.complete_when) {
      out += "  - " + quoted(name.fully_qualified()) + "\n";
    }
  }
  return out;
}

}  // namespace pipescout::host
