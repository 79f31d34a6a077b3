// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <rosbag2_interfaces/srv/snapshot.hpp>

#include "pipescout/runtime/component.hpp"

namespace pipescout {

class RecorderSettings;

/// Records topics of any type into a bag, as they are published, from the moment at which it is
/// activated until it is deactivated. Topics are found as they appear; they are asked for with a
/// QoS that goes with what is offered.
///
/// Messages are taken on the thread that publishes or receives them, as bytes, and written by a
/// thread of the recorder's own: no publisher waits for the disk. What does not fit into the cache
/// is dropped and counted for each topic.
///
/// Parameters, services and diagnostics: docs/components/bag_recorder.md. Parameters take effect
/// when it is configured.
class BagRecorder final : public Component {
 public:
  explicit BagRecorder(ComponentOptions options);
  ~BagRecorder() override;

 protected:
  CallbackReturn on_configure() override;
  CallbackReturn on_activate() override;
  CallbackReturn on_deactivate() override;
  CallbackReturn on_cleanup() override;
  CallbackReturn on_shutdown() override;

 private:
  using Snapshot = rosbag2_interfaces::srv::Snapshot;
  class Recording;

  std::unique_ptr<RecorderSettings> settings_;
  std::unique_ptr<Recording> recording_;
  Service<Snapshot> snapshot_service_;
};

}  // namespace pipescout
