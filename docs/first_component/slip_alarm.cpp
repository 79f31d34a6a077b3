// SPDX-License-Identifier: Apache-2.0
#include "slip_alarm.hpp"

#include <utility>

#include "pipescout/catalogue/topics.hpp"
#include "pipescout/runtime/register_component.hpp"

namespace tutorial {

using pipescout::CallbackReturn;

SlipAlarm::SlipAlarm(pipescout::ComponentOptions options) : Component(std::move(options)) {
  tolerated_ = parameters().declare<int>("tolerated", 2,
                                         {.description = "rejections in a row that raise no alarm",
                                          .integer_range = pipescout::IntegerRange{0, 1000}});
}

CallbackReturn SlipAlarm::on_configure() {
  alarm_ = create_publisher<std_msgs::msg::String>("slip_alarm", pipescout::QoS::latched());
  fused_ = create_subscription(
      pipescout::topics::kOdometerFused,
      [this](const pipescout_msgs::msg::FusedOdometer& fused) { on_fused(fused); });
  return CallbackReturn::kSuccess;
}

CallbackReturn SlipAlarm::on_cleanup() {
  fused_ = {};
  alarm_ = {};
  rejected_in_a_row_.clear();
  return CallbackReturn::kSuccess;
}

void SlipAlarm::on_fused(const pipescout_msgs::msg::FusedOdometer& fused) {
  if (fused.in_fusion_set.size() != fused.name.size()) {
    diagnostics().count("fused.in_fusion_set.wrong_size");
    return;
  }
  for (std::size_t i = 0; i < fused.name.size(); ++i) {
    const std::string& odometer = fused.name[i];
    int& rejected = rejected_in_a_row_[odometer];
    rejected = fused.in_fusion_set[i] ? 0 : rejected + 1;
    if (rejected == tolerated_.get() + 1) {
      std_msgs::msg::String alarm;
      alarm.data = odometer;
      alarm_.publish(std::move(alarm));
      logger().warn("odometer '" + odometer + "' slips");
    }
  }
}

}  // namespace tutorial

PIPESCOUT_REGISTER_COMPONENT(tutorial::SlipAlarm)
