// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "configuration.hpp"
#include "pipescout/estimation/state_estimator.hpp"
#include "pipescout/estimator_sources/source_input.hpp"
#include "pipescout/geometry/geodesy.hpp"
#include "recording.hpp"

namespace pipescout::estimate {

/// A message of a further source, by its place in `FurtherInputs`.
struct FurtherReading {
  std::size_t source = 0;
  const FurtherRow* row = nullptr;
};

/// How a further source fared.
struct FurtherOutcome {
  std::string name;
  std::size_t messages = 0;
  estimation::SourceStatus status{};
  std::map<std::string, std::size_t> faults;  ///< sentences, with the number of messages
  std::string calibration;                    ///< what is known of its mounting and its delay
};

/// The further sources of a configuration, from a recording to the estimator.
class FurtherInputs {
 public:
  /// Gives the sources their places in `parameters`; tells in `said` how each is used. Throws
  /// std::invalid_argument for a source whose topic the recording does not have, or has with
  /// messages of another type. `recording` and `map` (null: no GPS) outlive this.
  FurtherInputs(const Recording& recording, const Configuration& configuration,
                const geometry::LocalFrame* map, estimation::StateEstimatorParameters& parameters,
                std::vector<std::string>& said);

  [[nodiscard]] std::size_t size() const noexcept { return sources_.size(); }
  /// By rising time.
  [[nodiscard]] const std::vector<FurtherRow>& rows(std::size_t source) const {
    return streams_[source]->further;
  }
  /// `angular_rate`: rad/s, of the body, as measured by the gyro.
  void take(const FurtherReading& reading, const Eigen::Vector3d& angular_rate,
            estimation::StateEstimator& estimator);
  /// The first pose in the map that a source of kind `pose` has, as the pose of the base with
  /// deviations that cover what is not known of the sensor's mounting. Nothing without one.
  [[nodiscard]] std::optional<estimation::GivenPose> first_pose();
  /// `parameters`: of `estimator`.
  [[nodiscard]] std::vector<FurtherOutcome> outcomes(
      const estimation::StateEstimator& estimator,
      const estimation::StateEstimatorParameters& parameters) const;

 private:
  /// Nothing, and the fault is counted, for a frame that fixed transforms do not connect.
  [[nodiscard]] std::optional<geometry::SE3> place_of(std::size_t source, const std::string& frame);

  const Recording* recording_;
  const geometry::LocalFrame* map_;
  std::string base_frame_;
  std::vector<NamedSource> sources_;
  std::vector<const Stream*> streams_;
  std::vector<SourceInput> inputs_;
  std::vector<std::map<std::string, geometry::SE3>> places_;  // of the frames that were seen
  std::vector<std::map<std::string, std::size_t>> faults_;
  std::map<std::size_t, std::string> refused_;  // why the first message of a source was
};

}  // namespace pipescout::estimate
