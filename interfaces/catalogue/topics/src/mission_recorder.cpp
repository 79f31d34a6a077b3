// SPDX-License-Identifier: Apache-2.0
#include "pipescout/catalogue/mission_recorder.hpp"

#include <pipescout_msgs/msg/mission_status.hpp>
#include <stdexcept>
#include <system_error>
#include <utility>

#include "pipescout/catalogue/topics.hpp"

namespace pipescout {

namespace {

/// How much of the summary a mission that is killed can lose; the data files lose nothing.
constexpr Duration kSectionPeriod = std::chrono::seconds(5);

}  // namespace

MissionRecorder::MissionRecorder(ComponentOptions options, std::string data_name)
    : Component(std::move(options)), data_name_(std::move(data_name)) {
  mission_folder_parameter_ = parameters().declare<std::string>(
      "mission_folder", "", {.description = "existing folder to which the recording is written"});
  source_parameter_ = parameters().declare<std::string>(
      "source", "",
      {.description = "node whose completion on mission/status ends the recording, relative to the "
                      "namespace; empty: the recording ends with the process"});
}

void MissionRecorder::open_recording() {
  mission_folder_ = mission_folder_parameter_.get();
  if (mission_folder_.empty()) {
    throw std::invalid_argument("parameter 'mission_folder' is empty");
  }
  const std::string source = source_parameter_.get();
  source_node_ = source.empty() ? "" : expand_topic_name(source, node_name());
  data_folder_ = make_mission_data_folder(mission_folder_, node_name().ns, data_name_);
  outcome_ = Outcome::kRunning;
  outcome_text_.clear();
  section_is_old_ = true;
  section_is_on_disk_ = false;
  cannot_write_ = false;
  status_subscription_ = create_subscription(
      topics::kMissionStatus,
      [this](const pipescout_msgs::msg::MissionStatus& status) { on_status(status); });
  section_timer_ =
      create_timer(kSectionPeriod, [this] { guarded([this] { write_section(Survives::kKill); }); });
}

std::string MissionRecorder::data_folder_name() const {
  return data_folder_.lexically_relative(mission_folder_).string();
}

CallbackReturn MissionRecorder::on_deactivate() {
  save();
  return CallbackReturn::kSuccess;
}

CallbackReturn MissionRecorder::on_cleanup() {
  finish();
  return CallbackReturn::kSuccess;
}

CallbackReturn MissionRecorder::on_shutdown() {
  finish();
  return CallbackReturn::kSuccess;
}

void MissionRecorder::on_status(const pipescout_msgs::msg::MissionStatus& status) {
  if (source_node_.empty() || status.node != source_node_ || outcome_ != Outcome::kRunning) {
    return;
  }
  if (status.state == pipescout_msgs::msg::MissionStatus::FAILED) {
    end(Outcome::kFailed, source_node_ + " failed: " + status.message);
  } else {
    on_source(status);
  }
}

void MissionRecorder::guarded(const std::function<void()>& write) {
  if (cannot_write_) {
    diagnostics().count("not_recorded");
    return;
  }
  try {
    write();
  } catch (const std::system_error& error) {
    cannot_write_ = true;
    section_timer_.reset();
    end(Outcome::kFailed, error.what());
  }
}

void MissionRecorder::end(Outcome outcome, const std::string& text) {
  stop_timers();
  outcome_ = outcome;
  outcome_text_ = text;
  section_is_old_ = true;
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

void MissionRecorder::write_section(Survives survives) {
  if (!section_is_old_ && (survives == Survives::kKill || section_is_on_disk_)) {
    return;
  }
  const std::string name = mission_section_name(node_name().fully_qualified());
  MissionSection content = section(name.substr(0, name.rfind('.') + 1));
  const char* const state = outcome_ == Outcome::kComplete ? "Complete"
                            : outcome_ == Outcome::kFailed ? "Failed"
                                                           : "Not complete";
  content.notes.insert(
      content.notes.begin(),
      std::string(state) + ": " + (outcome_text_.empty() ? counts() : outcome_text_) + ".");
  write_mission_section(mission_folder_, name, content, survives);
  section_is_old_ = false;
  section_is_on_disk_ = survives == Survives::kPowerLoss;
}

/// Waits for the disk, which no callback of a running mission may do: others share its executor.
void MissionRecorder::save() {
  sync_files();
  write_section(Survives::kPowerLoss);
}

/// Closes what open_recording opened; may be called at any time, any number of times.
void MissionRecorder::finish() {
  stop_timers();
  section_timer_.reset();
  status_subscription_ = {};
  if (data_folder_.empty()) {
    return;
  }
  save();
  close_files();
  // Only a folder without files goes.
  std::error_code ignored;
  std::filesystem::remove(data_folder_, ignored);
  data_folder_.clear();
}

}  // namespace pipescout
