// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <pipescout_msgs/msg/odometer_readings.hpp>
#include <string>
#include <vector>

#include "pipescout/odometer_readings/readings_csv.hpp"
#include "pipescout/runtime/awaited_subscribers.hpp"
#include "pipescout/runtime/component.hpp"

namespace pipescout {

/// Publishes recorded odometer readings on `odometer/readings`, at their recorded times, once
/// enough subscriptions are matched that none is lost; then reports completion. Deactivating pauses
/// the replay; activating resumes it.
///
/// Parameters: docs/components/odometer_replay.md. All but `rate` take effect when it is
/// configured.
class OdometerReplay final : public Component {
 public:
  explicit OdometerReplay(ComponentOptions options);
  ~OdometerReplay() override;

 protected:
  CallbackReturn on_configure() override;
  CallbackReturn on_activate() override;
  CallbackReturn on_deactivate() override;
  CallbackReturn on_cleanup() override;

 private:
  enum class Phase { kPaused, kWaiting, kPlaying };

  /// Parameters at configuration.
  struct Settings {
    std::vector<double> standard_deviations;  // empty: the recording's
    Duration period{};
    bool use_recorded_stamps = false;
    std::string frame_id;
  };

  /// Throws std::invalid_argument when the parameters do not match the recording.
  void check_settings() const;
  void wait_or_play();
  void publish_next();
  void schedule(Duration delay);
  void follow_clock(Time time);
  /// Between a row and the one before it, in the replay; zero before the first.
  [[nodiscard]] Duration interval_before(std::size_t row) const;
  void report();

  Parameter<std::string> file_;
  Parameter<std::vector<std::string>> odometers_;
  Parameter<std::vector<std::string>> ignored_columns_;
  Parameter<std::string> delimiter_;
  Parameter<std::string> decimal_mark_;
  Parameter<std::string> time_unit_;
  Parameter<std::vector<double>> standard_deviations_;
  Parameter<double> period_;
  Parameter<double> rate_;
  Parameter<bool> use_recorded_stamps_;
  AwaitedSubscribers awaited_{*this, "the replay starts"};
  Parameter<std::string> frame_id_;

  Settings settings_;
  ReadingsRecording recording_;
  Publisher<pipescout_msgs::msg::OdometerReadings> publisher_;
  std::shared_ptr<Timer> timer_;
  Phase phase_ = Phase::kPaused;
  std::size_t next_ = 0;
  Time due_{};  ///< when the next row is to be published
};

}  // namespace pipescout
