// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <pipescout_msgs/msg/eddy_current_samples.hpp>
#include <pipescout_msgs/msg/fused_odometer.hpp>
#include <pipescout_msgs/msg/mission_status.hpp>
#include <pipescout_msgs/msg/odometer_readings.hpp>
#include <pipescout_msgs/msg/pipe_position.hpp>
#include <pipescout_msgs/msg/weld_detection.hpp>
#include <string>
#include <vector>

#include "pipescout/catalogue/mission_recorder.hpp"
#include "pipescout/crawler_recorder/crawler_report.hpp"
#include "pipescout/files/whole_file.hpp"

namespace pipescout {

/// Writes a run of a crawler into the mission folder, line by line as it arrives: `odometer/fused`,
/// `eddy_current`, `weld`, `pipe/position` and, from a simulation, `ground_truth/pipe_position`;
/// and its welds and figures into the mission's summary. Complete when its source is and nothing
/// more arrives.
///
/// Parameters: docs/components/crawler_recorder.md. They take effect when it is configured.
class CrawlerRecorder final : public MissionRecorder {
 public:
  explicit CrawlerRecorder(ComponentOptions options);
  ~CrawlerRecorder() override;

 protected:
  CallbackReturn on_configure() override;
  [[nodiscard]] MissionSection section(const std::string& figure_prefix) const override;
  [[nodiscard]] std::string counts() const override;
  void on_source(const pipescout_msgs::msg::MissionStatus& status) override;
  void stop_timers() override;
  void sync_files() override;
  void close_files() override;

 private:
  using Fused = pipescout_msgs::msg::FusedOdometer;
  using Samples = pipescout_msgs::msg::EddyCurrentSamples;
  using Weld = pipescout_msgs::msg::WeldDetection;
  using Position = pipescout_msgs::msg::PipePosition;

  void on_fused(const Fused& message);
  void on_samples(const Samples& message);
  void on_weld(const Weld& message);
  void on_position(const Position& message);
  void on_truth(const Position& message);
  /// Subscribes: every message is written, and a part of the section.
  template <class T>
  [[nodiscard]] Subscription<T> record(const Topic<T>& topic,
                                       void (CrawlerRecorder::*write)(const T&));
  /// The file, with this header when it is new.
  [[nodiscard]] LineFile& file(std::unique_ptr<LineFile>& file, const char* name,
                               const std::string& header);
  void wait_for_the_last();

  Parameter<double> settle_time_;
  Parameter<bool> record_signal_;
  Parameter<std::int64_t> table_rows_;

  // As configured.
  Duration settle_{};
  bool with_signal_ = true;

  std::optional<CrawlerReport> report_;
  std::vector<std::string> odometers_;  // of the first fused distance
  std::size_t channels_ = 0;            // of the first samples
  std::unique_ptr<LineFile> fused_file_;
  std::unique_ptr<LineFile> samples_file_;
  std::unique_ptr<LineFile> welds_file_;
  std::unique_ptr<LineFile> positions_file_;
  std::unique_ptr<LineFile> truth_file_;
  std::uint64_t messages_ = 0;
  std::uint64_t messages_when_asked_ = 0;

  Subscription<Fused> fused_subscription_;
  Subscription<Samples> samples_subscription_;
  Subscription<Weld> weld_subscription_;
  Subscription<Position> position_subscription_;
  Subscription<Position> truth_subscription_;
  std::shared_ptr<Timer> settle_timer_;
};

}  // namespace pipescout
