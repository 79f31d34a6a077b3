// SPDX-License-Identifier: Apache-2.0
#include "pipescout/catalogue/stream_recorder.hpp"

#include <array>
#include <cstdio>
#include <pipescout_msgs/msg/mission_status.hpp>
#include <utility>

#include "pipescout/runtime/conversions.hpp"

namespace pipescout {

namespace {

/// Silence is noticed by a quarter of itself late.
constexpr int kLooksPerSilence = 4;

}  // namespace

StreamRecorder::StreamRecorder(ComponentOptions options, std::string data_name)
    : MissionRecorder(std::move(options), std::move(data_name)) {
  settle_time_ = parameters().declare<double>(
      "settle_time", 0.5,
      {.description = "s after the end of the source in which delayed messages are still recorded",
       .floating_point_range = FloatingPointRange{0.01, 3600.0}});
  silent_after_ =
      parameters().declare<double>("silent_after", 30.0,
                                   {.description = "s without any message after which a recording "
                                                   "with an incomplete source fails; 0: no limit",
                                    .floating_point_range = FloatingPointRange{0.0, 86400.0}});
}

void StreamRecorder::begin_recording() {
  settle_ = from_seconds(settle_time_.get());
  silence_ = from_seconds(silent_after_.get());
  heard_at_.reset();
  source_end_.reset();
  open_recording();
  if (silence_ > Duration::zero()) {
    silence_timer_ = create_timer(silence_ / kLooksPerSilence, [this] { look_for_silence(); });
  }
}

void StreamRecorder::hear(const std::function<void()>& write, const std::string& counter) {
  heard_at_ = steady_now();
  section_has_changed();
  guarded([&] {
    try {
      write();
    } catch (const std::invalid_argument& error) {
      report_fault(counter + ".malformed", counter + " is not recorded: " + error.what());
    }
  });
}

LineFile& StreamRecorder::file(std::string_view name, std::string (*header)()) {
  if (const auto found = files_.find(name); found != files_.end()) {
    return found->second;
  }
  LineFile& made =
      files_.try_emplace(std::string(name), data_folder() / std::string(name)).first->second;
  made.write(header());
  return made;
}

void StreamRecorder::on_progress(const pipescout_msgs::msg::MissionStatus& /*status*/) {}

CallbackReturn StreamRecorder::on_deactivate() {
  // It does not hear what comes meanwhile.
  heard_at_.reset();
  return MissionRecorder::on_deactivate();
}

void StreamRecorder::on_source(const pipescout_msgs::msg::MissionStatus& status) {
  using pipescout_msgs::msg::MissionStatus;
  heard_at_ = steady_now();
  section_has_changed();
  guarded([&] { on_progress(status); });
  if (status.state == MissionStatus::COMPLETE && !settle_timer_) {
    if (const Time stamp = from_message(status.header.stamp); stamp > Time{}) {
      source_end_ = stamp;
    }
    settle_timer_ = create_timer(
        settle_, [this] { end(has_data() ? Outcome::kComplete : Outcome::kFailed, counts()); });
  } else if (status.state == MissionStatus::RUNNING && status.total != 0) {
    report_progress(status.done, status.total);
  }
}

void StreamRecorder::look_for_silence() {
  if (!heard_at_ || settle_timer_ || steady_now() - *heard_at_ < silence_) {
    return;
  }
  heard_at_.reset();
  std::array<char, 64> text{};
  std::snprintf(text.data(), text.size(), "no message has arrived for %g s", to_seconds(silence_));
  const auto source = parameters().get("source").get<std::string>();
  if (source.empty()) {
    report_fault("silent", text.data());
  } else {
    end(Outcome::kFailed, std::string(text.data()) + ", and '" + source +
                              "' has not reported completion: " + counts());
  }
}

void StreamRecorder::stop_timers() {
  settle_timer_.reset();
  silence_timer_.reset();
}

void StreamRecorder::sync_files() {
  for (auto& [name, lines] : files_) {
    lines.sync();
  }
}

void StreamRecorder::close_files() {
  subscriptions_.clear();
  files_.clear();
}

}  // namespace pipescout
