// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <pipescout_msgs/msg/leak_detections.hpp>
#include <pipescout_msgs/msg/leak_event.hpp>
#include <string>

#include "pipescout/catalogue/stream_recorder.hpp"

namespace pipescout {

class LeakTally;

/// Records leaks in the mission folder: `leak/detections` and `leak/events`, from a simulation
/// `ground_truth/leaks`; and the findings into the mission's summary. Ends as StreamRecorder.
///
/// Parameters: docs/components/leak_recorder.md. They take effect when it is configured.
class LeakRecorder final : public StreamRecorder {
 public:
  explicit LeakRecorder(ComponentOptions options);
  ~LeakRecorder() override;

 protected:
  CallbackReturn on_configure() override;
  [[nodiscard]] MissionSection section(const std::string& figure_prefix) const override;
  [[nodiscard]] std::string counts() const override;
  [[nodiscard]] bool has_data() const override;

 private:
  using Detections = pipescout_msgs::msg::LeakDetections;
  using Event = pipescout_msgs::msg::LeakEvent;

  void on_detections(const Detections& message);
  void on_event(const Event& message);
  void on_truth(const Event& message);

  std::unique_ptr<LeakTally> tally_;
};

}  // namespace pipescout
