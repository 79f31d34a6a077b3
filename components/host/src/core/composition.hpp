// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <functional>
#include <optional>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "core/substitution.hpp"
#include "pipescout/runtime/logger.hpp"
#include "pipescout/runtime/names.hpp"
#include "pipescout/runtime/parameter_value.hpp"
#include "pipescout/runtime/parameter_yaml.hpp"
#include "pipescout/runtime/time.hpp"

/// A composition: which components run together, with which parameters. Read from YAML, see
/// docs/compositions.md; everything is checked here that can be checked without loading a library.
namespace pipescout::host {

/// What happens when a component in a process of its own ends by itself.
struct RestartPolicy {
  int limit = 5;                                      ///< restarts in all
  Duration backoff = std::chrono::milliseconds{500};  ///< before the first; doubles each time
  bool operator==(const RestartPolicy&) const = default;
};

/// Threads that run callbacks, and how the system schedules them.
struct ExecutorSettings {
  std::size_t threads = 1;
  std::optional<int> nice;  ///< -20 (goes first) to 19
  std::optional<int> fifo;  ///< real-time priority, 1 to 99, of SCHED_FIFO; excludes `nice`

  bool operator==(const ExecutorSettings&) const = default;
};

struct ComponentEntry {
  std::string type;  ///< class: "pipescout::OdometryFusion"
  NodeName name;
  std::vector<ParameterOverride> parameters;  ///< from all sources; the later counts
  RemapRules remappings;
  std::optional<LogSeverity> log_level;      ///< nothing: info
  std::optional<ExecutorSettings> executor;  ///< of its own; nothing: that of the composition
  bool stops_last = false;  ///< after all that do not say so: a recorder hears their end
  bool isolate = false;
  RestartPolicy restart;
  std::string location;       ///< "file:line:column" of the entry
  std::string type_location;  ///< the same of its type
};

/// A topic that may leave the robot.
struct ExportEntry {
  std::string topic;           ///< fully qualified
  std::string as;              ///< that it leaves under, reduced; empty: as it is
  std::optional<double> rate;  ///< messages per second at most, Hz
  int shrink = 1;              ///< images: blocks of so many pixels each way become one
  std::string location;        ///< "file:line:column"

  /// The name under which it leaves.
  [[nodiscard]] const std::string& leaves_as() const { return as.empty() ? topic : as; }
  bool operator==(const ExportEntry&) const = default;
};

struct Composition {
  std::string path;
  std::string name;
  std::vector<std::pair<std::string, std::string>> arguments;  ///< with the values they have now
  std::string mission_folder;
  ExecutorSettings executor;
  std::vector<ComponentEntry> components;  ///< in the order in which they start, included ones too
  /// What of the topics may leave the robot; nothing: all.
  std::optional<std::vector<ExportEntry>> exports;
  std::vector<NodeName> complete_when;     ///< empty: runs until it is stopped
  std::vector<ParameterOverride> summary;  ///< options of the mission's tables; each name once
};

/// What the command line adds to the file.
struct CompositionInputs {
  std::vector<std::pair<std::string, std::string>> arguments;  ///< NAME:=VALUE
  std::string ns = "/";                                        ///< of all components
  std::vector<std::string> parameters;  ///< "k:=v", "node.k:=v" or "node:k:=v"
  std::vector<std::string> parameter_files;
  SubstitutionSources sources;
  /// Absolute path of the mission folder for a composition of that name.
  std::function<std::string(const std::string& mission)> mission_folder;
};

/// The command line does not go with the composition. Errors in the file are YamlError.
class CompositionError : public std::invalid_argument {
 public:
  using std::invalid_argument::invalid_argument;
};

/// Threads of a multi_threaded executor that does not say how many: as many as the machine has, at
/// least 2 and at most what a composition may ask for.
[[nodiscard]] std::size_t default_threads(unsigned hardware_threads);

/// Throws YamlError ("file:line:column: message"), CompositionError.
[[nodiscard]] Composition load_composition(const std::string& path,
                                           const CompositionInputs& inputs);
/// The same from text; `path` names it, and its folder is what relative files are relative to.
[[nodiscard]] Composition parse_composition(const std::string& text, const std::string& path,
                                            const CompositionInputs& inputs);

/// The composition as it is run, in the same format: arguments filled in, and for each component
/// (in their order) all its parameters.
[[nodiscard]] std::string to_yaml(const Composition& composition,
                                  const std::vector<std::vector<NamedParameter>>& parameters);

/// What went wrong with a component, with the place in the composition in front unless the message
/// names that of a parameter already.
[[nodiscard]] std::string located(const ComponentEntry& entry, const std::string& message);

/// Splits "name:=value". Throws CompositionError.
[[nodiscard]] std::pair<std::string, std::string> parse_argument(const std::string& text);

/// Appends parameters of the command line ("k:=v", "node.k:=v" or "node:k:=v") to the components
/// that they are for; `names` are those of all components, left out ones too. Throws
/// CompositionError.
void apply_parameter_arguments(Composition& composition, const std::vector<std::string>& names,
                               const std::vector<std::string>& arguments);

/// The names under which topics may leave the robot; nothing: all may.
[[nodiscard]] std::optional<std::set<std::string>> exported_topics(const Composition& composition);

/// The order in which components stop, as indices: the reverse of that in which they start, and
/// those with `stops_last` behind the others.
[[nodiscard]] std::vector<std::size_t> stop_order(const std::vector<ComponentEntry>& components);

}  // namespace pipescout::host
