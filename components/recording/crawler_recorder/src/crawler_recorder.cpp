// SPDX-License-Identifier: Apache-2.0
#include "pipescout/crawler_recorder/crawler_recorder.hpp"

#include <cmath>
#include <utility>

#include "pipescout/catalogue/topics.hpp"
#include "pipescout/crawler_recorder/csv_lines.hpp"
#include "pipescout/odometer_readings/readings_csv.hpp"
#include "pipescout/runtime/conversions.hpp"
#include "pipescout/runtime/register_component.hpp"

namespace pipescout {

namespace {

/// More than any robot has; no file gets so many columns.
constexpr std::size_t kMaximumOdometers = 64;
constexpr std::size_t kMaximumChannels = 64;

CrawlerReport::Position to_report(const pipescout_msgs::msg::PipePosition& message) {
  return {.stamp = from_message(message.header.stamp),
          .locked = message.locked,
          .joint = message.joint,
          .into_joint = message.distance_into_joint,
          .standard_deviation = std::sqrt(message.covariance[0]),
          .odometer_distance = message.odometer_distance};
}

}  // namespace

CrawlerRecorder::CrawlerRecorder(ComponentOptions options)
    : MissionRecorder(std::move(options), "crawler") {
  settle_time_ = parameters().declare<double>(
      "settle_time", 0.5,
      {.description = "s without any message after which a completed run is closed",
       .floating_point_range = FloatingPointRange{0.01, 3600.0}});
  record_signal_ = parameters().declare<bool>(
      "record_signal", true, {.description = "write the samples of eddy_current too"});
  table_rows_ = parameters().declare<std::int64_t>(
      "table_rows", 100,
      {.description = "welds shown in the summary's table; the file contains all",
       .integer_range = IntegerRange{1, 100000}});
}

CrawlerRecorder::~CrawlerRecorder() = default;

CallbackReturn CrawlerRecorder::on_configure() {
  settle_ = from_seconds(settle_time_.get());
  with_signal_ = record_signal_.get();
  report_.emplace(static_cast<std::size_t>(table_rows_.get()));
  odometers_.clear();
  channels_ = 0;
  messages_ = 0;
  open_recording();
  fused_subscription_ = record(topics::kOdometerFused, &CrawlerRecorder::on_fused);
  samples_subscription_ = record(topics::kEddyCurrent, &CrawlerRecorder::on_samples);
  weld_subscription_ = record(topics::kWeld, &CrawlerRecorder::on_weld);
  position_subscription_ = record(topics::kPipePosition, &CrawlerRecorder::on_position);
  truth_subscription_ = record(topics::kTruePipePosition, &CrawlerRecorder::on_truth);
  return CallbackReturn::kSuccess;
}

template <class T>
Subscription<T> CrawlerRecorder::record(const Topic<T>& topic,
                                        void (CrawlerRecorder::*write)(const T&)) {
  return create_subscription(topic, [this, write](const T& message) {
    ++messages_;
    section_has_changed();
    guarded([&] { (this->*write)(message); });
  });
}

void CrawlerRecorder::on_fused(const Fused& message) {
  const std::size_t odometers = message.name.size();
  const auto fits = [odometers](std::size_t size) { return size == odometers || size == 0; };
  if (odometers == 0 || odometers > kMaximumOdometers ||
      message.rejection_reason.size() != odometers ||
      message.support.size() != odometers * odometers || !fits(message.health.size()) ||
      message.scale.size() != message.health.size() ||
      message.scale_standard_deviation.size() != message.health.size()) {
    report_fault("fused.malformed",
                 "fused distances with lists of different lengths are not recorded");
    return;
  }
  if (odometers_.empty()) {
    odometers_ = message.name;
  } else if (odometers_ != message.name) {
    report_fault("fused.other_odometers",
                 "fused distances of different odometers than before are not recorded");
    return;
  }
  file(fused_file_, "fused.csv", fused_csv_header(odometer_column_names(odometers_)))
      .write(fused_csv_line(message));
}

void CrawlerRecorder::on_samples(const Samples& message) {
  const std::size_t channels = message.channels;
  if (channels == 0 || channels > kMaximumChannels || message.x.size() % channels != 0 ||
      message.y.size() != message.x.size() || !(message.sample_interval > 0.0)) {
    report_fault("eddy_current.malformed",
                 "eddy-current samples with lists of inconsistent lengths are not recorded");
    return;
  }
  if (!with_signal_) {
    return;
  }
  if (channels_ == 0) {
    channels_ = channels;
  } else if (channels_ != channels) {
    report_fault("eddy_current.other_channels",
                 "eddy-current samples of another number of channels are not recorded");
    return;
  }
  LineFile& lines = file(samples_file_, "eddy_current.csv", samples_csv_header(channels));
  for (std::size_t k = 0; k < message.x.size() / channels; ++k) {
    lines.write(samples_csv_line(message, k));
  }
}

void CrawlerRecorder::on_weld(const Weld& message) {
  file(welds_file_, "welds.csv", weld_csv_header()).write(weld_csv_line(message));
  const bool known = message.weld >= 0;
  report_->add_weld({.id = !known                    ? ""
                           : message.weld_id.empty() ? std::to_string(message.weld)
                                                     : message.weld_id,
                     .chainage = message.chainage,
                     .distance = message.distance,
                     .standard_deviation = message.standard_deviation,
                     .confidence = message.confidence,
                     .probability = message.weld_probability});
}

void CrawlerRecorder::on_position(const Position& message) {
  file(positions_file_, "positions.csv", position_csv_header()).write(position_csv_line(message));
  report_->add_position(to_report(message));
}

void CrawlerRecorder::on_truth(const Position& message) {
  file(truth_file_, "truth.csv", position_csv_header()).write(position_csv_line(message));
  report_->add_truth(to_report(message));
}

void CrawlerRecorder::on_source(const pipescout_msgs::msg::MissionStatus& status) {
  using pipescout_msgs::msg::MissionStatus;
  if (status.state == MissionStatus::COMPLETE && !settle_timer_) {
    wait_for_the_last();
  } else if (status.state == MissionStatus::RUNNING && status.total != 0) {
    report_progress(status.done, status.total);
  }
}

/// Messages may still be under way when the source says that it is complete.
void CrawlerRecorder::wait_for_the_last() {
  messages_when_asked_ = messages_;
  settle_timer_ = create_timer(settle_, [this] {
    if (messages_ == std::exchange(messages_when_asked_, messages_)) {
      end(report_->positions() > 0 ? Outcome::kComplete : Outcome::kFailed, counts());
    }
  });
}

LineFile& CrawlerRecorder::file(std::unique_ptr<LineFile>& file, const char* name,
                                const std::string& header) {
  if (!file) {
    file = std::make_unique<LineFile>(data_folder() / name);
    file->write(header);
  }
  return *file;
}

std::string CrawlerRecorder::counts() const {
  return std::to_string(report_->positions()) + " positions and " +
         std::to_string(report_->welds()) + " welds recorded";
}

MissionSection CrawlerRecorder::section(const std::string& figure_prefix) const {
  MissionSection section = report_->section(figure_prefix);
  section.notes.push_back("Data: " + data_folder_name() +
                          "/fused.csv, welds.csv, positions.csv, truth.csv, eddy_current.csv.");
  return section;
}

void CrawlerRecorder::stop_timers() {
  settle_timer_.reset();
}

void CrawlerRecorder::sync_files() {
  for (const auto* lines :
       {&fused_file_, &samples_file_, &welds_file_, &positions_file_, &truth_file_}) {
    if (*lines) {
      (*lines)->sync();
    }
  }
}

void CrawlerRecorder::close_files() {
  fused_subscription_ = {};
  samples_subscription_ = {};
  weld_subscription_ = {};
  position_subscription_ = {};
  truth_subscription_ = {};
  for (auto* lines : {&fused_file_, &samples_file_, &welds_file_, &positions_file_, &truth_file_}) {
    lines->reset();
  }
}

}  // namespace pipescout

PIPESCOUT_REGISTER_COMPONENT(pipescout::CrawlerRecorder)
