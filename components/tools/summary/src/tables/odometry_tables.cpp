// SPDX-License-Identifier: Apache-2.0

#include <cmath>
#include <cstdint>
#include <optional>
#include <pipescout_msgs/msg/fused_odometer.hpp>
#include <pipescout_msgs/msg/odometer_readings.hpp>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "pipescout/catalogue/odometer_text.hpp"
#include "pipescout/catalogue/topics.hpp"
#include "pipescout/csv/csv_file.hpp"
#include "pipescout/csv/csv_reader.hpp"
#include "pipescout/odometer_readings/readings_csv.hpp"
#include "pipescout/runtime/conversions.hpp"
#include "tables/makers.hpp"
#include "tables/odometry_report.hpp"

namespace pipescout::summary {

namespace {

/// More than any robot has; a message with more is a fault, and no file gets so many columns.
constexpr std::size_t kMaximumOdometers = 64;

std::string fused_header(const std::vector<std::string>& columns) {
  std::string header = "reading,stamp,distance,standard_deviation,status,fusion_set";
  for (const std::string& column : columns) {
    header += "," + column + ".rejection";
  }
  return header;
}

std::string fused_line(std::optional<std::uint64_t> reading, const OdometryReport::Fused& fused,
                       const std::vector<std::uint8_t>& rejections) {
  std::string line =
      (reading ? std::to_string(*reading) : "") + "," +
      format_stamp(fused.stamp.time_since_epoch()) + "," + format_csv_number(fused.distance) + "," +
      format_csv_number(fused.standard_deviation) + "," +
      (fused.has_consensus ? "ok" : "no consensus") + "," + format_fusion_set(fused.in_fusion_set);
  for (const std::uint8_t reason : rejections) {
    line += std::string(",") + rejection_text(reason);
  }
  return line;
}

class OdometryTables final : public TableMaker {
 public:
  OdometryTables(const Robot& robot, TableOptions::Odometry options,
                 std::optional<std::vector<double>> offsets);

 protected:
  MissionSection section(const std::string& figure_prefix) const override;
  std::string counts() const override;
  /// Every reading has its fused distance.
  bool has_data() const override;
  /// Odometers that are followed over time, each at a rate of its own, have no such table.
  bool has_section() const override { return recording_ && !follows_odometers_; }
  std::string file_names() const override { return "readings.csv, fused.csv"; }
  void on_source(const pipescout_msgs::msg::MissionStatus& status) override {
    expected_ = status.total != 0 ? status.total : expected_;
  }

 private:
  using Readings = pipescout_msgs::msg::OdometerReadings;
  using Fused = pipescout_msgs::msg::FusedOdometer;

  /// Exists from the first message on, which says what the columns are.
  struct Recording {
    std::vector<std::string> odometers;
    std::vector<std::string> columns;
    OdometryReport report;
    bool has_standard_deviations = false;
  };

  void read_reference(const std::string& file);
  void on_readings(const Readings& message);
  void on_fused(const Fused& message);
  /// Begins with the first message. False when a later one is of other odometers.
  [[nodiscard]] bool accepts(const std::vector<std::string>& odometers);
  [[nodiscard]] std::optional<std::vector<double>> known_offsets(std::size_t odometers) const;
  void write_readings(std::uint64_t number, const Readings& message);

  TableOptions::Odometry options_;
  std::optional<std::vector<double>> offsets_;
  std::vector<double> reference_;
  std::string reference_name_;  // the column
  std::string reference_note_;
  std::optional<Recording> recording_;
  bool has_readings_ = false;
  bool follows_odometers_ = false;  // the fusion, over time
  std::uint64_t expected_ = 0;      // readings, as the source says; 0: unknown
};

OdometryTables::OdometryTables(const Robot& robot, TableOptions::Odometry options,
                               std::optional<std::vector<double>> offsets)
    : TableMaker(robot, "odometry"), options_(std::move(options)), offsets_(std::move(offsets)) {
  if (!options_.reference_file.empty()) {
    read_reference(options_.reference_file.string());
  }
  record(topics::kOdometerReadings, "readings", [this](const Readings& m) { on_readings(m); });
  record(topics::kOdometerFused, "fused distances", [this](const Fused& m) { on_fused(m); });
}

bool OdometryTables::has_data() const {
  const std::uint64_t readings = recording_ ? recording_->report.readings() : 0;
  const std::uint64_t pairs = recording_ ? recording_->report.pairs() : 0;
  // A source that does not say how many there are leaves only this to check.
  return expected_ != 0 ? readings == expected_ && pairs == expected_
                        : readings != 0 && pairs == readings;
}

void OdometryTables::read_reference(const std::string& file) {
  const std::string text = read_csv_text(file);
  CsvReader reader(text, file);
  std::optional<std::size_t> column;
  std::string wanted;
  for (const std::string& name : options_.reference_columns) {
    if (column = reader.find_column(name); column) {
      reference_name_ = name;
      break;
    }
    wanted += (wanted.empty() ? "'" : "', '") + name;
  }
  if (!column) {
    reference_note_ = "There is no reference: no column " + wanted + "' in " + file + ".";
    return;
  }
  while (reader.next()) {
    const auto value = reader.number(*column);
    if (!value) {
      reader.refuse(*column, "a number");
    }
    reference_.push_back(*value);
  }
}

void OdometryTables::on_readings(const Readings& message) {
  const std::size_t odometers = message.name.size();
  const bool has_standard_deviations = !message.standard_deviation.empty();
  if (odometers == 0 || odometers > kMaximumOdometers || message.distance.size() != odometers ||
      message.valid.size() != odometers ||
      (has_standard_deviations && message.standard_deviation.size() != odometers)) {
    throw std::invalid_argument("lists of different lengths");
  }
  if (!accepts(message.name) ||
      (has_readings_ && recording_->has_standard_deviations != has_standard_deviations)) {
    throw std::invalid_argument("other odometers than before");
  }
  write_readings(
      recording_->report.add_reading(from_message(message.header.stamp), message.distance),
      message);
}

void OdometryTables::on_fused(const Fused& message) {
  const std::size_t odometers = message.name.size();
  follows_odometers_ = follows_odometers_ || !message.health.empty();
  if (odometers == 0 || odometers > kMaximumOdometers ||
      message.in_fusion_set.size() != odometers || message.rejection_reason.size() != odometers) {
    throw std::invalid_argument("lists of different lengths");
  }
  if (!accepts(message.name)) {
    throw std::invalid_argument("other odometers than before");
  }
  const OdometryReport::Fused fused{
      .stamp = from_message(message.header.stamp),
      .has_consensus = message.status == pipescout_msgs::msg::FusedOdometer::STATUS_OK,
      .distance = message.distance,
      .standard_deviation = std::sqrt(message.variance),
      .in_fusion_set = message.in_fusion_set};
  const auto reading = recording_->report.add_fused(fused);
  file("fused.csv", [this] {
    return fused_header(recording_->columns);
  }).write(fused_line(reading, fused, message.rejection_reason));
}

bool OdometryTables::accepts(const std::vector<std::string>& odometers) {
  if (!recording_) {
    const std::vector<std::string> columns = odometer_column_names(odometers);
    recording_.emplace(Recording{.odometers = odometers,
                                 .columns = columns,
                                 .report = OdometryReport({.odometers = columns,
                                                           .offsets = known_offsets(columns.size()),
                                                           .reference = std::move(reference_),
                                                           .reference_name = reference_name_,
                                                           .maximum_rows = options_.table_rows})});
  }
  return recording_->odometers == odometers;
}

/// Those of a fusion of other odometers tell nothing.
std::optional<std::vector<double>> OdometryTables::known_offsets(std::size_t odometers) const {
  if (offsets_ && offsets_->empty()) {
    return std::vector<double>(odometers, 0.0);
  }
  return offsets_ && offsets_->size() == odometers ? offsets_ : std::nullopt;
}

void OdometryTables::write_readings(std::uint64_t number, const Readings& message) {
  if (!has_readings_) {
    has_readings_ = true;
    recording_->has_standard_deviations = !message.standard_deviation.empty();
  }
  const Time stamp = from_message(message.header.stamp);
  file("readings.csv",
       [this] {
         return format_readings_header(recording_->columns, recording_->has_standard_deviations);
       })
      .write(format_readings_row(number, {.stamp = stamp.time_since_epoch(),
                                          .distance = message.distance,
                                          .standard_deviation = message.standard_deviation,
                                          .valid = message.valid}));
}

std::string OdometryTables::counts() const {
  const std::uint64_t readings = recording_ ? recording_->report.readings() : 0;
  const std::uint64_t fused = recording_ ? recording_->report.fused() : 0;
  const std::uint64_t pairs = recording_ ? recording_->report.pairs() : 0;
  std::string text = std::to_string(readings) +
                     (expected_ != 0 ? " of " + std::to_string(expected_) : "") +
                     " readings recorded, " + std::to_string(fused) + " fused distances";
  if (pairs != readings || pairs != fused) {
    text += ", " + std::to_string(pairs) + " of them with their readings";
  }
  return text;
}

MissionSection OdometryTables::section(const std::string& figure_prefix) const {
  MissionSection section = recording_->report.section(figure_prefix);
  if (!reference_note_.empty()) {
    section.notes.push_back(reference_note_);
  }
  section.notes.insert(section.notes.end(), options_.notes.begin(), options_.notes.end());
  return section;
}

}  // namespace

std::unique_ptr<TableMaker> odometry_tables(const Robot& robot,
                                            const TableOptions::Odometry& options,
                                            const std::optional<std::vector<double>>& offsets) {
  return std::make_unique<OdometryTables>(robot, options, offsets);
}

}  // namespace pipescout::summary
