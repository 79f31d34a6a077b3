// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "pipescout/leak_findings/leak_findings.hpp"
#include "pipescout/runtime/bound_parameters.hpp"
#include "pipescout/runtime/parameters.hpp"
#include "pipescout/thermal/leak_detector.hpp"

namespace pipescout {

/// Parameters of the association of detections to findings: docs/components/leak_inspector.md.
class FindingsParameters {
 public:
  /// Declares them.
  explicit FindingsParameters(Parameters& parameters);

  /// Valid, without the pose of the camera. Severities and the pipe diameter are those of the
  /// detector; `lines` come before those of the parameters. Throws std::invalid_argument naming the
  /// parameter.
  [[nodiscard]] leak_findings::LeakFindingsParameters read(
      const thermal::LeakDetectorParameters& detector,
      std::vector<leak_findings::PipeLine> lines = {}) const;

 private:
  BoundParameters<leak_findings::LeakFindingsParameters> fields_;
  Parameter<std::string> range_source_;
  Parameter<std::vector<double>> lines_;
};

}  // namespace pipescout
