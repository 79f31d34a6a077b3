// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <nav_msgs/msg/odometry.hpp>
#include <optional>
#include <pipescout_msgs/msg/estimator_state.hpp>
#include <sensor_msgs/msg/nav_sat_fix.hpp>
#include <string>
#include <vector>

#include "pipescout/catalogue/stream_recorder.hpp"
#include "pipescout/estimator_recorder/estimator_report.hpp"
#include "pipescout/geometry/geodesy.hpp"
#include "pipescout/mission_tables/thinning.hpp"

namespace pipescout {

/// Writes what a state estimator says into the mission folder: `odometry/filtered` now and then,
/// `estimator/state` in full, `gps/fix`, from a simulation `ground_truth/odometry` with the errors
/// against it; and its errors, consistency and sources into the mission's summary. Ends as
/// StreamRecorder.
///
/// Parameters: docs/components/estimator_recorder.md. They take effect when it is configured.
class EstimatorRecorder final : public StreamRecorder {
 public:
  explicit EstimatorRecorder(ComponentOptions options);
  ~EstimatorRecorder() override;

 protected:
  CallbackReturn on_configure() override;
  [[nodiscard]] MissionSection section(const std::string& figure_prefix) const override;
  [[nodiscard]] std::string counts() const override;
  [[nodiscard]] bool has_data() const override;

 private:
  using Odometry = nav_msgs::msg::Odometry;
  using State = pipescout_msgs::msg::EstimatorState;
  using Fix = sensor_msgs::msg::NavSatFix;

  void on_estimate(const Odometry& message);
  void on_truth(const Odometry& message);
  void on_state(const State& message);
  void on_fix(const Fix& message);
  void begin_map();

  Parameter<double> period_;
  Parameter<std::vector<double>> datum_;

  std::optional<EstimatorReport> report_;
  Thinning estimate_thinning_;
  Thinning truth_thinning_;
  std::optional<geometry::LocalFrame> map_;  // from the datum, or the first fix, on
};

}  // namespace pipescout
