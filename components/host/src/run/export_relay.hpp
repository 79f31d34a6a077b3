// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <diagnostic_msgs/msg/diagnostic_status.hpp>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "core/composition.hpp"
#include "pipescout/runtime/node.hpp"

namespace pipescout::host {

/// Publishes the reduced topics of `export`, and knows which exported topics nobody publishes. The
/// callbacks run on the executor of the node, in a group of their own.
class ExportRelay {
 public:
  /// `node` must outlive this object.
  ExportRelay(Node& node, std::vector<ExportEntry> exports);
  ~ExportRelay();
  ExportRelay(const ExportRelay&) = delete;
  ExportRelay& operator=(const ExportRelay&) = delete;

  /// After a change of the graph: takes up topics that are published now.
  void look();

  /// "robot_1/pipescout_container: export": a warning while a topic has no publisher.
  [[nodiscard]] diagnostic_msgs::msg::DiagnosticStatus status() const;

 private:
  class Reduced;

  Node& node_;
  const std::vector<ExportEntry> exports_;
  std::shared_ptr<CallbackGroup> group_;
  std::map<std::string, std::unique_ptr<Reduced>> reduced_;  ///< by the name that they leave under
  std::vector<std::string> silent_;                          ///< what is wrong, a sentence each
};

}  // namespace pipescout::host
