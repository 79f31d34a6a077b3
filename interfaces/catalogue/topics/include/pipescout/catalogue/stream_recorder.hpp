// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <any>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <stdexcept>
#include <string>
#include <string_view>
#include <vector>

#include "pipescout/catalogue/mission_recorder.hpp"
#include "pipescout/files/whole_file.hpp"
#include "pipescout/runtime/conversions.hpp"
#include "pipescout/runtime/topic.hpp"

namespace pipescout {

/// Base of recorders of topics: writes one line per message on arrival. The recording is complete
/// some time after its source, without what is stamped later than its end, and fails when no
/// message arrives before the source is complete.
///
/// Parameters in addition to those of MissionRecorder, read by `begin_recording`: `settle_time`, s
/// after the end of the source in which delayed messages are recorded, and `silent_after`, s
/// without any message after which a recording with an incomplete source fails (0: no limit). Both
/// are wall-clock time.
class StreamRecorder : public MissionRecorder {
 protected:
  /// `data_name`: as of MissionRecorder.
  StreamRecorder(ComponentOptions options, std::string data_name);

  /// For on_configure, before `record`. Throws as MissionRecorder::open_recording.
  void begin_recording();

  /// Calls `write` for each message. A file that cannot be written (std::system_error) fails the
  /// mission; an invalid message (std::invalid_argument) is counted as `<counter>.malformed`.
  template <class T, class Write>
  void record(const Topic<T>& topic, const std::string& counter, Write write) {
    // Commands received before the recording begins are kept too, since they were sent.
    subscriptions_.emplace_back(create_subscription(topic,
                                                    [this, counter, write](const T& message) {
                                                      if (!is_after_the_end(message)) {
                                                        hear([&] { write(message); }, counter);
                                                      }
                                                    },
                                                    {.while_inactive = WhileInactive::kKeep}));
  }

  /// The data file of this name. A new one begins with the header. Throws std::system_error naming
  /// it.
  [[nodiscard]] LineFile& file(std::string_view name, std::string (*header)());

  // A derived class overrides `on_configure`, `section`, `counts`, and these:

  /// Whether enough was recorded; otherwise the recording fails at the end of its source.
  [[nodiscard]] virtual bool has_data() const = 0;
  /// Status of the source while it runs and when it is complete. May throw std::system_error.
  virtual void on_progress(const pipescout_msgs::msg::MissionStatus& status);

  CallbackReturn on_deactivate() override;

 private:
  void on_source(const pipescout_msgs::msg::MissionStatus& status) final;
  void stop_timers() final;
  void sync_files() final;
  void close_files() final;

  /// How much comes within the settle time depends on the machine; what is recorded must not.
  template <class T>
  [[nodiscard]] bool is_after_the_end(const T& message) const {
    if constexpr (requires { message.header.stamp; }) {
      return source_end_ && from_message(message.header.stamp) > *source_end_;
    } else {
      return false;
    }
  }
  void hear(const std::function<void()>& write, const std::string& counter);
  /// Ends a recording whose source is silent. Starts with the first message.
  void look_for_silence();

  Parameter<double> settle_time_;
  Parameter<double> silent_after_;

  // As configured.
  Duration settle_{};
  Duration silence_{};  // zero: no limit

  std::optional<Time> source_end_;  // stamp of its last report
  std::optional<SteadyTime> heard_at_;
  std::map<std::string, LineFile, std::less<>> files_;
  std::vector<std::any> subscriptions_;
  std::shared_ptr<Timer> settle_timer_;
  std::shared_ptr<Timer> silence_timer_;
};

}  // namespace pipescout
