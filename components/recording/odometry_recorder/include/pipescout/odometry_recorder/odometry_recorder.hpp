// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <memory>
#include <optional>
#include <pipescout_msgs/msg/fused_odometer.hpp>
#include <pipescout_msgs/msg/mission_status.hpp>
#include <pipescout_msgs/msg/odometer_readings.hpp>
#include <string>
#include <vector>

#include "pipescout/catalogue/mission_recorder.hpp"
#include "pipescout/files/whole_file.hpp"
#include "pipescout/odometry_recorder/odometry_report.hpp"

namespace pipescout {

/// Writes `odometer/readings` and `odometer/fused` into the mission folder, line by line as they
/// arrive, and a table of both into the mission's summary. When the source of the readings says on
/// `mission/status` that it is complete and every reading has its fused distance, the recorder says
/// that it is complete; when some stay away it says that it failed, with the counts.
///
/// Parameters: docs/components/odometry_recorder.md. They take effect when it is configured.
class OdometryRecorder final : public MissionRecorder {
 public:
  explicit OdometryRecorder(ComponentOptions options);
  ~OdometryRecorder() override;

 protected:
  CallbackReturn on_configure() override;
  [[nodiscard]] MissionSection section(const std::string& figure_prefix) const override;
  [[nodiscard]] std::string counts() const override;
  void on_source(const pipescout_msgs::msg::MissionStatus& status) override;
  void stop_timers() override;
  void sync_files() override;
  void close_files() override;

 private:
  using Readings = pipescout_msgs::msg::OdometerReadings;
  using Fused = pipescout_msgs::msg::FusedOdometer;

  /// Exists from the first message on, which says what the columns are.
  struct Recording {
    std::vector<std::string> odometers;
    std::vector<std::string> columns;
    OdometryReport report;
    bool has_standard_deviations = false;
    std::unique_ptr<LineFile> readings{};  // made with the first of them
    std::unique_ptr<LineFile> fused{};
  };

  /// What parameters said when the component was configured.
  struct Settings {
    Duration completion_timeout{};
    std::string reference_name;
    std::size_t table_rows = 0;
    std::vector<std::string> notes;
  };

  void read_reference();
  void on_readings(const Readings& message);
  void on_fused(const Fused& message);
  /// Begins the recording with the first message. False when a later one is of other odometers.
  [[nodiscard]] bool accepts(const std::vector<std::string>& odometers);
  void write_readings(std::uint64_t number, const Readings& message);
  void progress();
  void judge(bool time_is_over);

  Parameter<double> completion_timeout_;
  Parameter<std::string> reference_file_;
  Parameter<std::string> reference_column_;
  Parameter<std::int64_t> table_rows_;
  Parameter<std::vector<std::string>> notes_;

  Settings settings_;
  std::vector<double> reference_;
  std::string reference_note_;

  std::optional<Recording> recording_;
  bool source_is_complete_ = false;
  std::uint64_t expected_ = 0;  // readings, as the source says; 0: unknown
  std::uint64_t reported_percent_ = 0;

  Subscription<Readings> readings_subscription_;
  Subscription<Fused> fused_subscription_;
  std::shared_ptr<Timer> timeout_;
};

}  // namespace pipescout
