// SPDX-License-Identifier: Apache-2.0
#include "pipescout/odometry_recorder/odometry_recorder.hpp"

#include <array>
#include <cmath>
#include <utility>

#include "pipescout/catalogue/odometer_text.hpp"
#include "pipescout/catalogue/topics.hpp"
#include "pipescout/csv/csv_file.hpp"
#include "pipescout/csv/csv_table.hpp"
#include "pipescout/mission_folder/mission_section.hpp"
#include "pipescout/odometer_readings/readings_csv.hpp"
#include "pipescout/runtime/conversions.hpp"
#include "pipescout/runtime/register_component.hpp"

namespace pipescout {

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
  std::string line = (reading ? std::to_string(*reading) : "") + "," +
                     format_stamp(fused.stamp.time_since_epoch()) + "," +
                     format_csv_number(fused.distance) + "," +
                     format_csv_number(fused.standard_deviation) + "," +
                     (fused.has_consensus ? "ok" : "no consensus") + "," + fused.fusion_set;
  for (const std::uint8_t reason : rejections) {
    line += std::string(",") + rejection_text(reason);
  }
  return line;
}

}  // namespace

OdometryRecorder::OdometryRecorder(ComponentOptions options)
    : MissionRecorder(std::move(options), "odometry") {
  completion_timeout_ = parameters().declare<double>(
      "completion_timeout", 5.0,
      {.description =
           "s after completion of the source in which delayed messages are still recorded",
       .floating_point_range = FloatingPointRange{0.01, 3600.0}});
  reference_file_ = parameters().declare<std::string>(
      "reference_file", "",
      {.description = "CSV file with the reference, one row per reading; empty: none"});
  reference_column_ = parameters().declare<std::string>(
      "reference_column", "paper",
      {.description = "its column of reference values for the fused distance, m"});
  table_rows_ = parameters().declare<std::int64_t>(
      "table_rows", 200,
      {.description = "readings shown in the summary's table; the files contain all",
       .integer_range = IntegerRange{1, 100000}});
  notes_ = parameters().declare<std::vector<std::string>>(
      "notes", {}, {.description = "sentences printed below the table"});
}

OdometryRecorder::~OdometryRecorder() = default;

CallbackReturn OdometryRecorder::on_configure() {
  settings_ = {.completion_timeout = from_seconds(completion_timeout_.get()),
               .reference_name = reference_column_.get(),
               .table_rows = static_cast<std::size_t>(table_rows_.get()),
               .notes = notes_.get()};
  read_reference();
  source_is_complete_ = false;
  expected_ = 0;
  reported_percent_ = 0;
  open_recording();

  readings_subscription_ = create_subscription(
      topics::kOdometerReadings,
      [this](const Readings& message) { guarded([&] { on_readings(message); }); });
  fused_subscription_ = create_subscription(topics::kOdometerFused, [this](const Fused& message) {
    guarded([&] { on_fused(message); });
  });
  return CallbackReturn::kSuccess;
}

void OdometryRecorder::read_reference() {
  reference_.clear();
  reference_note_.clear();
  const std::string file = reference_file_.get();
  if (file.empty()) {
    return;
  }
  const std::string text = read_csv_text(file);
  CsvReader reader(text, file);
  const auto column = reader.find_column(settings_.reference_name);
  if (!column) {
    reference_note_ =
        "There is no reference: no column '" + settings_.reference_name + "' in " + file + ".";
    return;
  }
  while (reader.next()) {
    const auto value = parse_csv_number(reader.cells()[*column]);
    if (!value) {
      reader.refuse(*column, "a number");
    }
    reference_.push_back(*value);
  }
}

void OdometryRecorder::on_readings(const Readings& message) {
  const std::size_t odometers = message.name.size();
  const bool has_standard_deviations = !message.standard_deviation.empty();
  if (odometers == 0 || odometers > kMaximumOdometers || message.distance.size() != odometers ||
      message.valid.size() != odometers ||
      (has_standard_deviations && message.standard_deviation.size() != odometers)) {
    report_fault("readings.malformed", "readings with lists of different lengths are not recorded");
    return;
  }
  if (!accepts(message.name) ||
      (recording_->readings && recording_->has_standard_deviations != has_standard_deviations)) {
    report_fault("readings.other_odometers",
                 "readings of different odometers than before are not recorded");
    return;
  }
  write_readings(
      recording_->report.add_reading(from_message(message.header.stamp), message.distance),
      message);
  judge(false);
}

void OdometryRecorder::on_fused(const Fused& message) {
  const std::size_t odometers = message.name.size();
  if (odometers == 0 || odometers > kMaximumOdometers ||
      message.in_fusion_set.size() != odometers || message.rejection_reason.size() != odometers) {
    report_fault("fused.malformed",
                 "fused distances with lists of different lengths are not recorded");
    return;
  }
  if (!accepts(message.name)) {
    report_fault("fused.other_odometers",
                 "fused distances of different odometers than before are not recorded");
    return;
  }
  const OdometryReport::Fused fused{
      .stamp = from_message(message.header.stamp),
      .has_consensus = message.status == pipescout_msgs::msg::FusedOdometer::STATUS_OK,
      .distance = message.distance,
      .standard_deviation = std::sqrt(message.variance),
      .fusion_set = format_fusion_set(message.in_fusion_set)};
  const auto reading = recording_->report.add_fused(fused);
  section_has_changed();
  if (!recording_->fused) {
    recording_->fused = std::make_unique<LineFile>(data_folder() / "fused.csv");
    recording_->fused->write(fused_header(recording_->columns));
  }
  recording_->fused->write(fused_line(reading, fused, message.rejection_reason));
  progress();
  judge(false);
}

void OdometryRecorder::on_source(const pipescout_msgs::msg::MissionStatus& status) {
  if (status.total != 0) {
    expected_ = status.total;
  }
  if (status.state == pipescout_msgs::msg::MissionStatus::COMPLETE && !source_is_complete_) {
    source_is_complete_ = true;
    timeout_ = create_timer(settings_.completion_timeout, [this] {
      timeout_.reset();
      judge(true);
    });
    judge(false);
  }
}

bool OdometryRecorder::accepts(const std::vector<std::string>& odometers) {
  if (!recording_) {
    const std::vector<std::string> columns = odometer_column_names(odometers);
    recording_.emplace(
        Recording{.odometers = odometers,
                  .columns = columns,
                  .report = OdometryReport({.odometers = columns,
                                            .reference = std::move(reference_),
                                            .reference_name = settings_.reference_name,
                                            .maximum_rows = settings_.table_rows})});
  }
  return recording_->odometers == odometers;
}

void OdometryRecorder::write_readings(std::uint64_t number, const Readings& message) {
  section_has_changed();
  if (!recording_->readings) {
    recording_->has_standard_deviations = !message.standard_deviation.empty();
    recording_->readings = std::make_unique<LineFile>(data_folder() / "readings.csv");
    recording_->readings->write(
        format_readings_header(recording_->columns, recording_->has_standard_deviations));
  }
  const Time stamp = from_message(message.header.stamp);
  recording_->readings->write(
      format_readings_row(number, {.stamp = stamp.time_since_epoch(),
                                   .distance = message.distance,
                                   .standard_deviation = message.standard_deviation,
                                   .valid = message.valid}));
}

void OdometryRecorder::progress() {
  const std::uint64_t pairs = recording_->report.pairs();
  // At most a hundred reports, however many readings.
  if (expected_ == 0 || outcome() != Outcome::kRunning ||
      pairs * 100 / expected_ == reported_percent_) {
    return;
  }
  reported_percent_ = pairs * 100 / expected_;
  report_progress(pairs, expected_);
}

/// Decides whether the recording is complete, now or, when its time is over, for good.
void OdometryRecorder::judge(bool time_is_over) {
  if (!source_is_complete_ || outcome() != Outcome::kRunning) {
    return;
  }
  const std::uint64_t readings = recording_ ? recording_->report.readings() : 0;
  const std::uint64_t pairs = recording_ ? recording_->report.pairs() : 0;
  if (expected_ != 0 && readings == expected_ && pairs == expected_) {
    end(Outcome::kComplete, counts());
  } else if (time_is_over) {
    // A source that does not say how many there are leaves only this to check.
    const bool matches = expected_ == 0 && readings != 0 && pairs == readings;
    end(matches ? Outcome::kComplete : Outcome::kFailed, counts());
  }
}

std::string OdometryRecorder::counts() const {
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

MissionSection OdometryRecorder::section(const std::string& figure_prefix) const {
  MissionSection section;
  section.title = "Odometry";
  if (recording_) {
    section = recording_->report.section(figure_prefix);
  }
  if (!reference_note_.empty()) {
    section.notes.push_back(reference_note_);
  }
  section.notes.insert(section.notes.end(), settings_.notes.begin(), settings_.notes.end());
  if (recording_) {
    section.notes.push_back("Data: " + data_folder_name() + "/readings.csv, fused.csv.");
  }
  return section;
}

void OdometryRecorder::stop_timers() {
  timeout_.reset();
}

void OdometryRecorder::sync_files() {
  if (recording_ && recording_->readings) {
    recording_->readings->sync();
  }
  if (recording_ && recording_->fused) {
    recording_->fused->sync();
  }
}

void OdometryRecorder::close_files() {
  readings_subscription_ = {};
  fused_subscription_ = {};
  recording_.reset();
}

}  // namespace pipescout

PIPESCOUT_REGISTER_COMPONENT(pipescout::OdometryRecorder)
