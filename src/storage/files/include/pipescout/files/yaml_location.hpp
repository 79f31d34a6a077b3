// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <stdexcept>
#include <string>

namespace YAML {
class Node;
struct Mark;
}  // namespace YAML

/// Positions in YAML files, and the common reader of this project's loaders: errors are
/// "file:line:column: message". This header needs no yaml-cpp.
namespace pipescout {

/// A YAML file is malformed or lacks required content.
class YamlError : public std::runtime_error {
 public:
  /// `path`: the file, or a name for text without a file. Line and column count from 1; 0 means
  /// that the error concerns the file as a whole, and what() is then "path: message".
  YamlError(std::string path, int line, int column, const std::string& message);
  YamlError(std::string path, const YAML::Mark& mark, const std::string& message);

  [[nodiscard]] const std::string& path() const noexcept { return path_; }
  [[nodiscard]] int line() const noexcept { return line_; }
  [[nodiscard]] int column() const noexcept { return column_; }

 private:
  std::string path_;
  int line_;
  int column_;
};

/// "path:line:column", counted from 1; only "path" for a mark of no position.
[[nodiscard]] std::string location(const std::string& path, const YAML::Mark& mark);

/// "path:line".
[[nodiscard]] std::string line_location(const std::string& path, const YAML::Mark& mark);

/// Reads one YAML document from text. `path` names it in errors. An empty text gives a null node.
/// Throws YamlError for invalid YAML, and for YAML that is not allowed in a configuration: control
/// characters, several documents, aliases (one line could expand to gigabytes), duplicate keys,
/// keys that are not scalars, more than 64 levels of nesting.
[[nodiscard]] YAML::Node parse_yaml(const std::string& text, const std::string& path);

/// The same for a file. Throws YamlError also when it cannot be read.
[[nodiscard]] YAML::Node load_yaml(const std::string& path);

}  // namespace pipescout
