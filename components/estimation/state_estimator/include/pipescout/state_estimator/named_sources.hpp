// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <pipescout/estimation/state_estimator.hpp>
#include <string>
#include <vector>

#include "pipescout/estimator_sources/named_source.hpp"
#include "pipescout/runtime/parameters.hpp"

namespace pipescout {

/// The parameters of the sources that the parameter `sources` names: docs/components/
/// state_estimator.md.
class NamedSourceParameters {
 public:
  /// Declares them. Throws ParameterError for a kind that is unknown.
  explicit NamedSourceParameters(Parameters& parameters);

  /// Sets gates, own states and correlation times in `estimator`. Throws std::invalid_argument
  /// naming the parameter.
  [[nodiscard]] std::vector<NamedSource> read(
      estimation::StateEstimatorParameters& estimator) const;

 private:
  struct Declared {
    std::string name;
    NamedSourceKind kind;
    Parameter<std::string> topic;
    Parameter<std::vector<double>> position;
    Parameter<std::vector<double>> roll_pitch_yaw;
    Parameter<std::vector<double>> beacon;
    std::vector<Parameter<double>> numbers;  // as named_source_numbers()
    Parameter<std::vector<std::string>> left;
    Parameter<std::vector<std::string>> right;
    Parameter<double> wheel_radius;
    Parameter<double> track;
  };
  std::vector<Declared> declared_;
};

}  // namespace pipescout
