// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "pipescout/manipulation/arm_controller.hpp"
#include "pipescout/manipulation/arm_model.hpp"
#include "pipescout/runtime/bound_parameters.hpp"
#include "pipescout/runtime/parameters.hpp"

namespace pipescout {

/// Configuration of the component.
struct ArmSettings {
  std::string urdf;  ///< text of the robot description
  std::string base_frame;
  std::string camera_frame;
  std::string map_frame;
  manipulation::ArmModelOptions model;
  manipulation::ArmControllerParameters controller;
  bool publish_tf = true;
};

/// The parameters of the component: docs/components/camera_arm.md.
class ArmParameters {
 public:
  /// Declares them.
  explicit ArmParameters(Parameters& parameters);

  /// Reads the file of the robot description. Throws std::invalid_argument naming the parameter, or
  /// the file that cannot be read.
  [[nodiscard]] ArmSettings read() const;

 private:
  void declare_arm(Parameters& parameters);
  void declare_law();
  void declare_watch();
  void declare_search();

  BoundParameters<manipulation::ArmControllerParameters> controller_;
  Parameter<std::string> urdf_file_;
  Parameter<double> mesh_radius_;
  Parameter<double> continuous_velocity_;
  Parameter<std::string> base_frame_;
  Parameter<std::string> camera_frame_;
  Parameter<std::string> map_frame_;
  Parameter<std::string> centring_;
  Parameter<std::vector<double>> ready_;
  Parameter<std::vector<double>> stow_;
  Parameter<bool> publish_tf_;
};

}  // namespace pipescout
