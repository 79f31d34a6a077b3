// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <memory>
#include <mutex>
#include <optional>
#include <pipescout/odometry/consensus_fusion.hpp>
#include <pipescout_msgs/msg/fused_odometer.hpp>
#include <pipescout_msgs/msg/odometer_readings.hpp>
#include <string>
#include <string_view>
#include <vector>

#include "pipescout/runtime/awaited_subscribers.hpp"
#include "pipescout/runtime/component.hpp"

namespace pipescout {

/// Fuses the readings of redundant odometers: `odometer/readings` in, `odometer/fused` out, one for
/// one, by `odometry::ConsensusFusion`. Invalid readings are excluded with a reason in the message;
/// an inconsistent message is refused. Both are counted on `/diagnostics` under the name of the
/// field.
///
/// Parameters: docs/components/odometry_fusion.md. They may be changed at any time, and all but
/// `wait_for_subscribers` take effect at once; a value that the algorithm refuses is refused with
/// the algorithm's reason.
class OdometryFusion final : public Component {
 public:
  explicit OdometryFusion(ComponentOptions options);
  ~OdometryFusion() override;

 protected:
  CallbackReturn on_configure() override;
  CallbackReturn on_cleanup() override;

 private:
  using Readings = pipescout_msgs::msg::OdometerReadings;
  using Fused = pipescout_msgs::msg::FusedOdometer;
  using Algorithm = odometry::ConsensusFusion;

  void declare_parameters();
  void subscribe();
  void on_readings(const Readings& message);
  [[nodiscard]] bool is_acceptable(const Readings& message, const Algorithm& algorithm,
                                   const std::vector<double>& standard_deviations);
  void check_stamp(const Readings& message);
  void count_rejections(const Fused& fused);
  [[nodiscard]] std::shared_ptr<const Algorithm> algorithm() const;
  void set_algorithm(std::shared_ptr<const Algorithm> algorithm);

  Parameter<std::vector<std::string>> odometers_;
  Parameter<std::vector<double>> standard_deviations_;
  Parameter<double> maximum_age_;
  Parameter<double> maximum_lead_;
  AwaitedSubscribers awaited_{*this, "the component subscribes to the readings"};

  mutable std::mutex mutex_;  // parameters are set on any thread
  std::shared_ptr<const Algorithm> algorithm_;

  std::size_t wanted_subscribers_ = 0;  // as configured
  Publisher<Fused> publisher_;
  Subscription<Readings> subscription_;
  std::optional<Time> last_stamp_;

  // Last: unregistered before anything that they use goes.
  ParameterCallbackHandle validate_handle_;
  ParameterCallbackHandle changed_handle_;
};

}  // namespace pipescout
