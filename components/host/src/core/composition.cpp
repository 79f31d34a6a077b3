// SPDX-License-Identifier: Apache-2.0
#include "core/composition.hpp"

#include <yaml-cpp/yaml.h>

#include <algorithm>
#include <filesystem>
#include <map>
#include <thread>

#include "pipescout/command_line/known_keys.hpp"
#include "pipescout/command_line/suggestion.hpp"
#include "pipescout/files/yaml_location.hpp"

namespace pipescout::host {
namespace {

using command_line::suggestion;

constexpr std::size_t kMostThreads = 256;
constexpr int kMostRestarts = 1000000;
constexpr double kLongestBackoff = 3600.0;     // s
constexpr double kLowestExportRate = 0.001;    // Hz
constexpr double kHighestExportRate = 1000.0;  // Hz
constexpr int kMostShrink = 64;

/// What the readers of a composition and of the files that it includes have in common.
struct Reading {
  Composition composition;
  std::map<NodeName, std::string> seen;      ///< components, and where they are
  std::vector<NodeName> left_out;            ///< by their conditions
  std::vector<std::filesystem::path> files;  ///< that are being read, the outermost first

  [[nodiscard]] std::vector<NodeName> all_names() const {
    std::vector<NodeName> names;
    for (const auto& entry : composition.components) {
      names.push_back(entry.name);
    }
    names.insert(names.end(), left_out.begin(), left_out.end());
    return names;
  }
};

class Reader {
 public:
  Reader(const std::string& path, const CompositionInputs& inputs, Reading& reading)
      : path_(path),
        inputs_(inputs),
        sources_(inputs.sources),
        reading_(reading),
        composition_(reading.composition),
        first_component_(composition_.components.size()) {
    reading_.files.push_back(canonical(path));
  }
  Reader(const Reader&) = delete;
  Reader& operator=(const Reader&) = delete;
  ~Reader() { reading_.files.pop_back(); }

  void read_outermost(const YAML::Node& root) {
    check_root(root);
    composition_.path = path_;
    composition_.arguments = read_arguments(root["arguments"]);
    composition_.name = read_name(root["name"]);
    if (inputs_.mission_folder) {
      composition_.mission_folder = inputs_.mission_folder(composition_.name);
      sources_.mission_folder = composition_.mission_folder;
    }
    if (root["executor"]) {
      composition_.executor = read_executor(root["executor"]);
    }
    read_contents(root);
    apply_parameter_files();
    apply_parameter_arguments(composition_, component_names(), inputs_.parameters);
  }

  /// Its components; name and executor are for the file by itself.
  void read_included(const YAML::Node& root) {
    check_root(root);
    read_arguments(root["arguments"]);
    read_contents(root);
  }

 private:
  static std::filesystem::path canonical(const std::filesystem::path& path) {
    std::error_code error;
    auto result = std::filesystem::weakly_canonical(std::filesystem::absolute(path), error);
    return error ? path : result;
  }

  void check_root(const YAML::Node& root) const {
    check_keys(root, "a composition",
               {"name", "arguments", "executor", "robot_description", "include", "components",
                "remappings", "export", "complete_when", "summary"});
  }

  void read_contents(const YAML::Node& root) {
    read_robot_description(root["robot_description"]);
    read_includes(root["include"]);
    if (root["components"]) {
      read_components(root["components"]);
    } else if (!root["include"]) {
      fail(root, "key 'components' is missing");
    }
    read_common_remappings(root["remappings"]);
    read_exports(root["export"]);
    read_complete_when(root["complete_when"]);
    if (root["summary"] && !root["summary"].IsNull()) {
      read_summary(root["summary"]);
    }
  }

  /// What `if` and `unless` of an entry say.
  [[nodiscard]] bool applies(const YAML::Node& entry) const {
    return (!entry["if"] || boolean(entry["if"], "'if'")) &&
           (!entry["unless"] || !boolean(entry["unless"], "'unless'"));
  }

  void read_includes(const YAML::Node& node) {
    if (!node || node.IsNull()) {
      return;
    }
    if (!node.IsSequence()) {
      fail(node, "'include' must be a list of compositions");
    }
    for (const auto& item : node) {
      if (item.IsScalar()) {
        include(item, item, {});
        continue;
      }
      if (!item.IsMap() || !item["file"]) {
        fail(item, "an entry of 'include' is a file, or a map with the keys file, ...");
      }
      check_keys(item, "an entry of 'include'", {"file", "namespace", "arguments", "if", "unless"});
      if (applies(item)) {
        include(item, item["file"], item["arguments"]);
      }
    }
  }

  void include(const YAML::Node& item, const YAML::Node& file_node, const YAML::Node& arguments) {
    const auto file = existing_file(file_node, "composition");
    check_no_cycle(file_node, file);
    CompositionInputs inputs;
    inputs.ns = item.IsMap() ? namespace_of(item) : inputs_.ns;
    inputs.sources = inputs_.sources;
    inputs.sources.mission_folder = sources_.mission_folder;
    if (arguments.IsDefined() && !arguments.IsNull()) {
      if (!arguments.IsMap()) {
        fail(arguments, "'arguments' of an include must be a map of names to values");
      }
      for (const auto& entry : arguments) {
        const auto& name = entry.first.Scalar();
        inputs.arguments.emplace_back(name, text(entry.second, "argument '" + name + "'"));
      }
    }
    const auto path = file.string();
    try {
      Reader(path, inputs, reading_).read_included(load_yaml(path));
    } catch (const CompositionError& error) {
      fail(arguments.IsDefined() ? arguments : file_node, error.what());
    }
  }

  /// A file that an entry names, relative to this one. `what` it is: for messages.
  [[nodiscard]] std::filesystem::path existing_file(const YAML::Node& node,
                                                    const std::string& what) const {
    const auto name = text(node, "the name of a " + what);
    if (name.empty()) {
      fail(node, "the name of a " + what + " is empty");
    }
    const auto file = std::filesystem::path(path_).parent_path() / name;
    std::error_code error;
    const auto status = std::filesystem::status(file, error);
    if (!std::filesystem::exists(status)) {
      fail(node, "there is no " + what + " " + file.string());
    }
    if (std::filesystem::is_directory(status)) {
      fail(node, file.string() + " is a folder, and no " + what);
    }
    return file;
  }

  void check_no_cycle(const YAML::Node& node, const std::filesystem::path& file) const {
    const auto begin = std::find(reading_.files.begin(), reading_.files.end(), canonical(file));
    if (begin == reading_.files.end()) {
      return;
    }
    std::string chain;
    for (auto step = begin; step != reading_.files.end(); ++step) {
      chain += step->filename().string() + " -> ";
    }
    fail(node, file.string() + " includes itself: " + chain + begin->filename().string());
  }

  [[noreturn]] void fail(const YAML::Node& node, const std::string& message) const {
    throw YamlError(path_, node.Mark(), message);
  }

  void check_keys(const YAML::Node& map, const std::string& what,
                  const std::vector<std::string>& known) const {
    command_line::require_known_keys(map, path_, what, known);
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

  /// `expected`: the range in words.
  double number(const YAML::Node& node, const std::string& what, double from, double to,
                const std::string& expected) const {
    const auto value = typed(node, what);
    const auto* whole = value.get_if<std::int64_t>();
    const auto* real = value.get_if<double>();
    const double result = whole != nullptr  ? static_cast<double>(*whole)
                          : real != nullptr ? *real
                                            : from - 1.0;
    if (!(result >= from && result <= to)) {
      fail(node, what + " must be " + expected + ", not '" + node.Scalar() + "'");
    }
    return result;
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

  /// The arguments with the values that they have now.
  std::vector<std::pair<std::string, std::string>> read_arguments(const YAML::Node& node) {
    std::vector<std::pair<std::string, std::string>> arguments;
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
          fail(entry.first,
               "argument '" + name + "' has no default: give " +
                   (is_included() ? "it where " + path_ + " is included" : name + ":=VALUE"));
        } else {
          value = text(entry.second, "the default of argument '" + name + "'");
        }
        sources_.arguments[name] = value;
        arguments.emplace_back(name, std::move(value));
      }
    }
    for (const auto& [name, value] : given) {
      if (std::find(names.begin(), names.end(), name) == names.end()) {
        throw CompositionError("argument " + name + ":=" + value + ": " + path_ +
                               " has no argument '" + name + "'" + suggestion(name, names));
      }
    }
    return arguments;
  }

  [[nodiscard]] bool is_included() const { return reading_.files.size() > 1; }

  [[nodiscard]] std::string read_name(const YAML::Node& node) const {
    const auto valid = [](const std::string& name) {
      return !name.empty() && std::all_of(name.begin(), name.end(), [](unsigned char c) {
        return std::isalnum(c) != 0 || c == '_' || c == '-';
      });
    };
    if (node) {
      const auto name = text(node, "'name'");
      if (!valid(name)) {
        fail(node, "'name' must consist of letters, digits, '_' and '-', not '" + name + "'");
      }
      return name;
    }
    const auto name = std::filesystem::path(path_).stem().string();
    return valid(name) ? name : "mission";
  }

  [[nodiscard]] ExecutorSettings read_executor(const YAML::Node& node) const {
    check_keys(node, "'executor'", {"type", "threads", "nice", "fifo"});
    ExecutorSettings settings;
    const auto type = node["type"] ? text(node["type"], "'type'") : "single_threaded";
    if (type != "single_threaded" && type != "multi_threaded") {
      fail(node["type"], "'type' must be single_threaded or multi_threaded, not '" + type + "'");
    }
    if (node["threads"]) {
      settings.threads = static_cast<std::size_t>(
          integer(node["threads"], "'threads'", 1, static_cast<std::int64_t>(kMostThreads)));
      if (type == "single_threaded" && settings.threads != 1) {
        fail(node["threads"], "a single_threaded executor has one thread");
      }
    } else if (type == "multi_threaded") {
      settings.threads = default_threads(std::thread::hardware_concurrency());
    }
    if (node["nice"]) {
      settings.nice = static_cast<int>(integer(node["nice"], "'nice'", -20, 19));
    }
    if (node["fifo"]) {
      settings.fifo = static_cast<int>(integer(node["fifo"], "'fifo'", 1, 99));
      if (settings.nice) {
        fail(node["fifo"], "'nice' means nothing to threads with the real-time priority 'fifo'");
      }
    }
    return settings;
  }

  /// Short for a component that tells it, before all others.
  void read_robot_description(const YAML::Node& node) {
    if (!node) {
      return;
    }
    const auto file = existing_file(node, "robot description");
    ComponentEntry entry;
    entry.type = "pipescout::RobotDescription";
    entry.name = {inputs_.ns, "robot_description"};
    entry.location = entry.type_location = location(path_, node.Mark());
    entry.parameters.push_back(
        {.name = "urdf_file", .value = file.string(), .source = entry.location});
    add_component(node, std::move(entry));
  }

  void add_component(const YAML::Node& name_node, ComponentEntry entry) {
    const auto [other, is_new] = reading_.seen.emplace(entry.name, entry.location);
    if (!is_new) {
      const auto name = entry.name.fully_qualified();
      fail(name_node,
           other->second == entry.location
               ? "component '" + name +
                     "' is there twice, since this file is included more than once: give each "
                     "include a namespace of its own"
               : "two components have the name '" + name + "'; the other is at " + other->second);
    }
    composition_.components.push_back(std::move(entry));
  }

  void read_components(const YAML::Node& node) {
    if (node.IsNull()) {
      return;
    }
    if (!node.IsSequence()) {
      fail(node, "'components' must be a list");
    }
    for (const auto& item : node) {
      check_component_keys(item);
      if (!applies(item)) {
        reading_.left_out.push_back(read_node_name(item));
        continue;
      }
      add_component(item["name"], read_component(item));
    }
  }

  void check_component_keys(const YAML::Node& node) const {
    check_keys(node, "a component",
               {"type", "name", "namespace", "if", "unless", "parameters", "parameter_files",
                "remappings", "log_level", "executor", "stops_last", "isolate", "restart"});
    for (const char* key : {"type", "name"}) {
      if (!node[key]) {
        fail(node, std::string("key '") + key + "' of a component is missing");
      }
    }
  }

  ComponentEntry read_component(const YAML::Node& node) {
    ComponentEntry entry;
    entry.location = location(path_, node.Mark());
    entry.type = text(node["type"], "'type'");
    entry.type_location = location(path_, node["type"].Mark());
    entry.name = read_node_name(node);
    if (node["parameter_files"]) {
      read_parameter_files(node["parameter_files"], entry);
    }
    if (node["parameters"] && !node["parameters"].IsNull()) {
      read_parameters(node["parameters"], entry);
    }
    if (node["remappings"]) {
      read_remappings(node["remappings"], entry.remappings);
    }
    if (node["log_level"]) {
      const auto level = text(node["log_level"], "'log_level'");
      entry.log_level = log_severity(level);
      if (!entry.log_level) {
        fail(node["log_level"],
             "'log_level' must be debug, info, warn, error or fatal, not '" + level + "'");
      }
    }
    if (node["executor"]) {
      entry.executor = read_executor(node["executor"]);
    }
    if (node["stops_last"]) {
      entry.stops_last = boolean(node["stops_last"], "'stops_last'");
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

  [[nodiscard]] NodeName read_node_name(const YAML::Node& node) const {
    NodeName name{.ns = namespace_of(node), .name = text(node["name"], "'name'")};
    try {
      validate_node_name(name.name);
    } catch (const InvalidName& error) {
      fail(node["name"], error.what());
    }
    return name;
  }

  /// Of a component or an include, below that of this file.
  [[nodiscard]] std::string namespace_of(const YAML::Node& node) const {
    if (!node["namespace"]) {
      return inputs_.ns;
    }
    try {
      return join_namespaces(inputs_.ns, text(node["namespace"], "'namespace'"));
    } catch (const InvalidName& error) {
      fail(node["namespace"], error.what());
    }
  }

  void read_parameter_files(const YAML::Node& node, ComponentEntry& entry) const {
    if (!node.IsSequence()) {
      fail(node, "'parameter_files' must be a list of files");
    }
    for (const auto& item : node) {
      const auto file = existing_file(item, "parameter file");
      auto overrides =
          load_parameter_yaml(file.string()).overrides_for(entry.name.fully_qualified());
      if (overrides.empty()) {
        fail(item, file.string() + " has no parameter for " + entry.name.fully_qualified());
      }
      append(entry, std::move(overrides));
    }
  }

  void read_parameters(const YAML::Node& node, ComponentEntry& entry) const {
    append(entry, substituted_map(node));
  }

  [[nodiscard]] std::vector<ParameterOverride> substituted_map(const YAML::Node& node) const {
    auto overrides = read_parameter_map(node, path_);
    for (auto& parameter : overrides) {
      const auto value = find_parameter(node, parameter.name);
      parameter.source = location(path_, value.Mark());
      parameter.value = substituted_value(value, parameter);
    }
    return overrides;
  }

  /// What stands in this file counts more than what an included one says. The names are known to
  /// `pipescout summary` only.
  void read_summary(const YAML::Node& node) {
    for (auto& option : substituted_map(node)) {
      std::erase_if(composition_.summary,
                    [&](const ParameterOverride& other) { return other.name == option.name; });
      composition_.summary.push_back(std::move(option));
    }
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

  /// Of all components of this file, included ones too; of several rules for one name the first
  /// counts, which is that of the component itself.
  void read_common_remappings(const YAML::Node& node) {
    if (!node || node.IsNull()) {
      return;
    }
    for (std::size_t k = first_component_; k < composition_.components.size(); ++k) {
      read_remappings(node, composition_.components[k].remappings);
    }
  }

  void read_remappings(const YAML::Node& node, RemapRules& rules) const {
    if (!node.IsMap()) {
      fail(node, "'remappings' must be a map of names to new names");
    }
    for (const auto& item : node) {
      const auto rule =
          item.first.Scalar() + ":=" + text(item.second, "the new name of a remapping");
      try {
        rules.push_back(RemapRule::parse(rule));
      } catch (const InvalidName& error) {
        fail(item.first, error.what());
      }
      const auto kind = rules.back().kind;
      if (kind == RemapRule::Kind::kNodeName || kind == RemapRule::Kind::kNamespace) {
        fail(item.first, "a component is renamed by its 'name' and 'namespace'");
      }
    }
  }

  void read_restart(const YAML::Node& node, RestartPolicy& policy) const {
    check_keys(node, "'restart'", {"limit", "backoff"});
    if (node["limit"]) {
      policy.limit = static_cast<int>(integer(node["limit"], "'limit'", 0, kMostRestarts));
    }
    if (node["backoff"]) {
      const double seconds = number(node["backoff"], "'backoff'", 0.0, kLongestBackoff,
                                    "a number of seconds in [0, 3600]");
      policy.backoff = from_seconds(seconds);
    }
  }

  void read_exports(const YAML::Node& node) {
    if (!node) {
      return;
    }
    auto& exports = composition_.exports ? *composition_.exports : composition_.exports.emplace();
    if (!node.IsNull() && !node.IsSequence()) {
      fail(node, "'export' must be a list of topics");
    }
    for (const auto& item : node) {
      exports.push_back(read_export(item));
    }
  }

  [[nodiscard]] ExportEntry read_export(const YAML::Node& item) const {
    ExportEntry entry;
    entry.location = location(path_, item.Mark());
    if (item.IsScalar()) {
      entry.topic = topic_of(item);
      return entry;
    }
    if (!item.IsMap() || !item["topic"]) {
      fail(item, "an entry of 'export' is a topic, or a map with the keys topic, as, ...");
    }
    check_keys(item, "an entry of 'export'", {"topic", "as", "rate", "shrink"});
    entry.topic = topic_of(item["topic"]);
    if (item["rate"]) {
      entry.rate = number(item["rate"], "'rate'", kLowestExportRate, kHighestExportRate,
                          "a number of messages per second in [0.001, 1000]");
    }
    if (item["shrink"]) {
      entry.shrink = static_cast<int>(integer(item["shrink"], "'shrink'", 1, kMostShrink));
    }
    const bool is_reduced = entry.rate || entry.shrink > 1;
    if (is_reduced != item["as"].IsDefined()) {
      fail(item, is_reduced ? "a reduced topic needs a name of its own: 'as'"
                            : "'as' is for a topic with 'rate' or 'shrink'");
    }
    if (is_reduced) {
      entry.as = topic_of(item["as"]);
      if (entry.as == entry.topic) {
        fail(item["as"], "'as' is the topic itself");
      }
    }
    return entry;
  }

  /// Below the namespace of this file.
  [[nodiscard]] std::string topic_of(const YAML::Node& node) const {
    try {
      return expand_topic_name(text(node, "the name of a topic"), {inputs_.ns, "export"});
    } catch (const InvalidName& error) {
      fail(node, error.what());
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
      if (const auto component = component_named(item, name)) {
        composition_.complete_when.push_back(*component);
      }
    }
  }

  /// Of this file or of one that it includes; nothing when its condition has left it out.
  std::optional<NodeName> component_named(const YAML::Node& node, const std::string& name) const {
    const auto bears = [&name](const NodeName& component) {
      return component.name == name || component.fully_qualified() == name;
    };
    std::vector<NodeName> matches;
    for (auto k = first_component_; k < composition_.components.size(); ++k) {
      if (bears(composition_.components[k].name)) {
        matches.push_back(composition_.components[k].name);
      }
    }
    if (matches.empty() && std::any_of(reading_.left_out.begin(), reading_.left_out.end(), bears)) {
      return std::nullopt;
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
    for (const auto& component : reading_.all_names()) {
      names.push_back(component.name);
    }
    return names;
  }

  /// What to call a component that a parameter file gets wrong: the one of the same name in another
  /// namespace, else the nearest.
  [[nodiscard]] std::string component_suggestion(const std::string& misspelt) const {
    const auto name = misspelt.substr(misspelt.rfind('/') + 1);
    std::vector<std::string> names;
    for (const auto& component : reading_.all_names()) {
      names.push_back(component.fully_qualified());
      if (component.name == name) {
        return "; did you mean '" + names.back() + "'?";
      }
    }
    return suggestion(misspelt, names);
  }

  /// Wildcards may match nothing: they are for whatever is there.
  void check_names_components(const ParameterFile& parameters) const {
    const auto names = reading_.all_names();
    for (const auto& node : parameters.nodes()) {
      const bool known = std::any_of(names.begin(), names.end(), [&](const NodeName& component) {
        return matches_node_pattern(node.pattern, component.fully_qualified());
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

  const std::string& path_;
  const CompositionInputs& inputs_;
  SubstitutionSources sources_;
  Reading& reading_;
  Composition& composition_;
  const std::size_t first_component_;  ///< of this file, included ones too
};

Composition read_composition(const YAML::Node& root, const std::string& path,
                             const CompositionInputs& inputs) {
  Reading reading;
  Reader(path, inputs, reading).read_outermost(root);
  return std::move(reading.composition);
}

}  // namespace

std::size_t default_threads(unsigned hardware_threads) {
  return std::clamp<std::size_t>(hardware_threads, 2, kMostThreads);
}

std::pair<std::string, std::string> parse_argument(const std::string& text) {
  const auto separator = text.find(":=");
  if (separator == std::string::npos || separator == 0) {
    throw CompositionError("'" + text + "' must have the form NAME:=VALUE");
  }
  return {text.substr(0, separator), text.substr(separator + 2)};
}

Composition load_composition(const std::string& path, const CompositionInputs& inputs) {
  return read_composition(load_yaml(path), path, inputs);
}

Composition parse_composition(const std::string& text, const std::string& path,
                              const CompositionInputs& inputs) {
  return read_composition(parse_yaml(text, path), path, inputs);
}

}  // namespace pipescout::host
