// SPDX-License-Identifier: Apache-2.0
#include "pipescout/crawler_recorder/crawler_recorder.hpp"

#include <cmath>
#include <stdexcept>
#include <system_error>
#include <utility>

#include "pipescout/crawler_recorder/csv_lines.hpp"
#include "pipescout/interfaces/conversions.hpp"
#include "pipescout/interfaces/mission_section.hpp"
#include "pipescout/interfaces/register_component.hpp"
#include "pipescout/interfaces/topics.hpp"
#include "pipescout/odometer_replay/readings_csv.hpp"

namespace pipescout {

namespace {

/// More than any robot has; no file gets so many columns.
constexpr std::size_t kMaximumOdometers = 64;
constexpr std::size_t kMaximumChannels = 64;
/// How much of the summary a mission that is killed can lose; the data files lose nothing.
constexpr Duration kSectionPeriod = std::chrono::seconds(5);

CrawlerReport::Position to_report(const pipescout_msgs::msg::PipePosition& message) {
  return {.stamp = from_message(message.header().stamp()),
          .locked = message.locked(),
          .joint = message.joint(),
          .into_joint = message.distance_into_joint(),
          .standard_deviation = std::sqrt(message.covariance()[0]),
          .odometer_distance = message.odometer_distance()};
}

}  // namespace

CrawlerRecorder::CrawlerRecorder(ComponentOptions options) : Component(std::move(options)) {
  mission_folder_ = parameters().declare<std::string>(
      "mission_folder", "", {.description = "existing folder that the recording goes into"});
  source_ = parameters().declare<std::string>(
      "source", "",
      {.description = "node that says on mission/status when the run is over, relative to the "
                      "namespace; empty: the recording has no end of its own"});
  settle_time_ = parameters().declare<double>(
      "settle_time", 0.5,
      {.description = "s without any message after which a run that is over is complete",
       .floating_point_range = FloatingPointRange{0.01, 3600.0}});
  record_signal_ = parameters().declare<bool>(
      "record_signal", true, {.description = "write the samples of eddy_current too"});
  table_rows_ = parameters().declare<std::int64_t>(
      "table_rows", 100,
      {.description = "welds that the summary's table shows; the file holds all",
       .integer_range = IntegerRange{1, 100000}});
}

CrawlerRecorder::~CrawlerRecorder() {
  close();
}

CallbackReturn CrawlerRecorder::on_configure() {
  mission_path_ = mission_folder_.get();
  if (mission_path_.empty()) {
    throw std::invalid_argument("parameter 'mission_folder' is empty");
  }
  settle_ = from_seconds(settle_time_.get());
  with_signal_ = record_signal_.get();
  const std::string source = source_.get();
  source_node_ = source.empty() ? "" : expand_topic_name(source, node_name());
  report_.emplace(static_cast<std::size_t>(table_rows_.get()));
  data_folder_ = make_mission_data_folder(mission_path_, node_name().ns, "crawler");
  odometers_.clear();
  channels_ = 0;
  outcome_ = Outcome::kRunning;
  outcome_text_.clear();
  messages_ = 0;
  cannot_write_ = false;
  subscribe();
  section_timer_ =
      create_timer(kSectionPeriod, [this] { guarded([this] { write_section(Survives::kKill); }); });
  return CallbackReturn::kSuccess;
}

void CrawlerRecorder::subscribe() {
  fused_subscription_ = create_subscription(topics::kOdometerFused, [this](const Fused& message) {
    guarded([&] { on_fused(message); });
  });
  samples_subscription_ = create_subscription(topics::kEddyCurrent, [this](const Samples& message) {
    guarded([&] { on_samples(message); });
  });
  weld_subscription_ = create_subscription(
      topics::kWeld, [this](const Weld& message) { guarded([&] { on_weld(message); }); });
  position_subscription_ = create_subscription(
      topics::kPipePosition,
      [this](const Position& message) { guarded([&] { on_position(message); }); });
  truth_subscription_ =
      create_subscription(topics::kTruePipePosition,
                          [this](const Position& message) { guarded([&] { on_truth(message); }); });
  status_subscription_ = create_subscription(topics::kMissionStatus,
                                             [this](const Status& message) { on_status(message); });
}

CallbackReturn CrawlerRecorder::on_deactivate() {
  save();
  return CallbackReturn::kSuccess;
}

CallbackReturn CrawlerRecorder::on_cleanup() {
  finish();
  return CallbackReturn::kSuccess;
}

CallbackReturn CrawlerRecorder::on_shutdown() {
  finish();
  return CallbackReturn::kSuccess;
}

void CrawlerRecorder::on_fused(const Fused& message) {
  const std::size_t odometers = message.name().size();
  const auto fits = [odometers](std::size_t size) { return size == odometers || size == 0; };
  if (odometers == 0 || odometers > kMaximumOdometers ||
      message.rejection_reason().size() != odometers ||
      message.support().size() != odometers * odometers || !fits(message.health().size()) ||
      message.scale().size() != message.health().size() ||
      message.scale_standard_deviation().size() != message.health().size()) {
    report_fault("fused.malformed",
                 "fused distances whose lists are not of one length are not recorded");
    return;
  }
  if (odometers_.empty()) {
    odometers_ = message.name();
  } else if (odometers_ != message.name()) {
    report_fault("fused.other_odometers",
                 "fused distances of other odometers than before are not recorded");
    return;
  }
  file(fused_file_, "fused.csv", fused_csv_header(odometer_column_names(odometers_)))
      .write(fused_csv_line(message));
}

void CrawlerRecorder::on_samples(const Samples& message) {
  const std::size_t channels = message.channels();
  if (channels == 0 || channels > kMaximumChannels || message.x().size() % channels != 0 ||
      message.y().size() != message.x().size() || !(message.sample_interval() > 0.0)) {
    report_fault("eddy_current.malformed",
                 "eddy-current samples whose lists do not fit together are not recorded");
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
  for (std::size_t k = 0; k < message.x().size() / channels; ++k) {
    lines.write(samples_csv_line(message, k));
  }
}

void CrawlerRecorder::on_weld(const Weld& message) {
  file(welds_file_, "welds.csv", weld_csv_header()).write(weld_csv_line(message));
  const bool known = message.weld() >= 0;
  report_->add_weld({.id = !known                      ? ""
                           : message.weld_id().empty() ? std::to_string(message.weld())
                                                       : message.weld_id(),
                     .chainage = message.chainage(),
                     .distance = message.distance(),
                     .standard_deviation = message.standard_deviation(),
                     .confidence = message.confidence(),
                     .probability = message.weld_probability()});
}

void CrawlerRecorder::on_position(const Position& message) {
  file(positions_file_, "positions.csv", position_csv_header()).write(position_csv_line(message));
  report_->add_position(to_report(message));
}

void CrawlerRecorder::on_truth(const Position& message) {
  file(truth_file_, "truth.csv", position_csv_header()).write(position_csv_line(message));
  report_->add_truth(to_report(message));
}

void CrawlerRecorder::on_status(const Status& message) {
  namespace constants = pipescout_msgs::msg::MissionStatus_Constants;
  if (source_node_.empty() || message.node() != source_node_ || outcome_ != Outcome::kRunning) {
    return;
  }
  if (message.state() == constants::FAILED) {
    end(Outcome::kFailed, source_node_ + " failed: " + message.message());
  } else if (message.state() == constants::COMPLETE && !settle_timer_) {
    wait_for_the_last();
  } else if (message.state() == constants::RUNNING && message.total() != 0) {
    report_progress(message.done(), message.total());
  }
}

/// Messages may still be under way when the source says that it is complete.
void CrawlerRecorder::wait_for_the_last() {
  messages_when_asked_ = messages_;
  settle_timer_ = create_timer(settle_, [this] {
    if (messages_ != std::exchange(messages_when_asked_, messages_)) {
      return;
    }
    settle_timer_.reset();
    end(report_->positions() > 0 ? Outcome::kComplete : Outcome::kFailed, counts());
  });
}

void CrawlerRecorder::guarded(const std::function<void()>& write) {
  ++messages_;
  if (cannot_write_) {
    diagnostics().count("not_recorded");
    return;
  }
  try {
    write();
  } catch (const std::system_error& error) {
    cannot_write_ = true;
    section_timer_.reset();
    settle_timer_.reset();
    end(Outcome::kFailed, error.what());
  }
}

LineFile& CrawlerRecorder::file(std::unique_ptr<LineFile>& file, const char* name,
                                const std::string& header) {
  if (!file) {
    file = std::make_unique<LineFile>(data_folder_ / name);
    file->write(header);
  }
  return *file;
}

std::string CrawlerRecorder::counts() const {
  return std::to_string(report_->positions()) + " positions and " +
         std::to_string(report_->welds()) + " welds recorded";
}

void CrawlerRecorder::end(Outcome outcome, const std::string& text) {
  outcome_ = outcome;
  outcome_text_ = text;
  try {
    write_section(Survives::kKill);
  } catch (const std::system_error& error) {
    outcome_ = Outcome::kFailed;
    outcome_text_ = outcome == Outcome::kFailed ? text + "; " + error.what() : error.what();
  }
  if (outcome_ == Outcome::kComplete) {
    report_complete(outcome_text_);
  } else {
    report_failed(outcome_text_);
  }
}

void CrawlerRecorder::write_section(Survives survives) {
  const std::string name = mission_section_name(node_name().fully_qualified());
  MissionSection section = report_->section(name.substr(0, name.rfind('.') + 1));
  const char* const state = outcome_ == Outcome::kComplete ? "Complete"
                            : outcome_ == Outcome::kFailed ? "Failed"
                                                           : "Not complete";
  section.notes.insert(
      section.notes.begin(),
      std::string(state) + ": " + (outcome_text_.empty() ? counts() : outcome_text_) + ".");
  section.notes.push_back("Data: " + data_folder_.lexically_relative(mission_path_).string() +
                          "/fused.csv, welds.csv, positions.csv, truth.csv, eddy_current.csv.");
  write_mission_section(mission_path_, name, section, survives);
}

/// Waits for the disk, which no callback of a running mission may do: others share its executor.
void CrawlerRecorder::save() {
  for (const auto* lines :
       {&fused_file_, &samples_file_, &welds_file_, &positions_file_, &truth_file_}) {
    if (*lines) {
      (*lines)->sync();
    }
  }
  write_section(Survives::kPowerLoss);
}

/// Closes what on_configure opened; may be called at any time, any number of times.
void CrawlerRecorder::finish() {
  settle_timer_.reset();
  section_timer_.reset();
  fused_subscription_ = {};
  samples_subscription_ = {};
  weld_subscription_ = {};
  position_subscription_ = {};
  truth_subscription_ = {};
  status_subscription_ = {};
  if (data_folder_.empty()) {
    return;
  }
  save();
  for (auto* lines : {&fused_file_, &samples_file_, &welds_file_, &positions_file_, &truth_file_}) {
    lines->reset();
  }
  // Only a folder without files goes.
  std::error_code ignored;
  std::filesystem::remove(data_folder_, ignored);
  data_folder_.clear();
}

}  // namespace pipescout

PIPESCOUT_REGISTER_COMPONENT(pipescout::CrawlerRecorder)
