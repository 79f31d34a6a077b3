// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <map>
#include <pipescout_msgs/msg/fused_odometer.hpp>
#include <std_msgs/msg/string.hpp>
#include <string>

#include "pipescout/runtime/component.hpp"

namespace tutorial {

/// Says on `slip_alarm` which odometer the others have not supported several times in a row.
class SlipAlarm final : public pipescout::Component {
 public:
  explicit SlipAlarm(pipescout::ComponentOptions options);

 protected:
  pipescout::CallbackReturn on_configure() override;
  pipescout::CallbackReturn on_cleanup() override;

 private:
  void on_fused(const pipescout_msgs::msg::FusedOdometer& fused);

  pipescout::Parameter<int> tolerated_;
  pipescout::Publisher<std_msgs::msg::String> alarm_;
  pipescout::Subscription<pipescout_msgs::msg::FusedOdometer> fused_;
  std::map<std::string, int> rejected_in_a_row_;
};

}  // namespace tutorial
