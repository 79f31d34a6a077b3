// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>

#include "pipescout/runtime/component.hpp"

namespace pipescout {

/// Plays a bag: publishes its messages as bytes, in the order of their log times and those of equal
/// times in the order of the file, with the QoS that was recorded. Types need not be known here.
/// Complete when it has played the last message, unless it loops.
///
/// A thread of its own reads ahead, so that no callback waits for the disk. A topic that has
/// another type on the network than in the bag is not played; it is named in the log and counted on
/// `/diagnostics`.
///
/// Parameters, services and diagnostics: docs/components/bag_player.md. Parameters take effect when
/// it is configured.
class BagPlayer final : public Component {
 public:
  explicit BagPlayer(ComponentOptions options);
  ~BagPlayer() override;

 protected:
  CallbackReturn on_configure() override;
  CallbackReturn on_activate() override;
  CallbackReturn on_deactivate() override;
  CallbackReturn on_cleanup() override;
  CallbackReturn on_shutdown() override;

 private:
  class Playback;
  class Settings;
  std::unique_ptr<Settings> settings_;
  std::unique_ptr<Playback> playback_;
};

}  // namespace pipescout
