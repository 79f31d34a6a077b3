// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>

#include "pipescout/runtime/component.hpp"

namespace pipescout {

/// Says on `/diagnostics` how a component is: once a second of its clock, and at once after its
/// level changed. One status per component, named as diagnostic_updater does,
/// "robot_1/odometry_fusion: status", with its lifecycle state, its counters and values, and what
/// its endpoints, services and clients lost or missed. The growth of such a loss makes the level at
/// least a warning that names topic and number. Inputs whose rate or age is not as declared are
/// named (InputWatch). A transport with `warnings` gets a second status, "robot_1/odometry_fusion:
/// transport".
class DiagnosticsPublisher {
 public:
  /// The component must outlive it.
  explicit DiagnosticsPublisher(Component& component);
  DiagnosticsPublisher(const DiagnosticsPublisher&) = delete;
  DiagnosticsPublisher& operator=(const DiagnosticsPublisher&) = delete;
  ~DiagnosticsPublisher();

  /// What InputWatch::configure does and throws.
  void configure();
  /// Publishes the present state now. Thread-safe.
  void publish_now();

 private:
  class Impl;
  std::shared_ptr<Impl> impl_;
};

}  // namespace pipescout
