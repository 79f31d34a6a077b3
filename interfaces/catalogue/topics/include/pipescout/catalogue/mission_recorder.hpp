// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <functional>
#include <memory>
#include <string>

#include "pipescout/mission_folder/mission_section.hpp"
#include "pipescout/runtime/component.hpp"
#include "pipescout/runtime/subscription.hpp"

namespace pipescout_msgs::msg {
struct MissionStatus;
}

namespace pipescout {

/// Base of components that write to the mission folder: data files, and a section of the mission's
/// summary, which is rewritten every few seconds and when the recording ends. Reports completion or
/// failure on `mission/status`.
///
/// Parameters, both read by `open_recording`: `mission_folder`, an existing folder, and `source`,
/// the node whose completion on `mission/status` ends the recording (empty: none).
class MissionRecorder : public Component {
 protected:
  enum class Outcome { kRunning, kComplete, kFailed };

  /// `data_name`: name of the data folder, within that of the node's namespace.
  MissionRecorder(ComponentOptions options, std::string data_name);

  /// For on_configure: creates the data folder and subscribes to the status of the source. Throws
  /// std::invalid_argument when there is no mission folder, std::system_error naming it.
  void open_recording();

  /// Runs a function that writes. If it throws std::system_error, the mission fails and nothing
  /// more is written: later calls are counted as `not_recorded`.
  void guarded(const std::function<void()>& write);
  /// Marks the section as changed since it was last written.
  void section_has_changed() noexcept { section_is_old_ = true; }
  /// Writes the section for the last time and reports the outcome, which is not kRunning.
  void end(Outcome outcome, const std::string& text);

  [[nodiscard]] Outcome outcome() const noexcept { return outcome_; }
  [[nodiscard]] const std::filesystem::path& data_folder() const noexcept { return data_folder_; }
  /// Relative to the mission folder, for messages.
  [[nodiscard]] std::string data_folder_name() const;

  // A derived class overrides on_configure, and these:

  /// Without a note on the outcome. `figure_prefix` is the prefix of the figures' names.
  [[nodiscard]] virtual MissionSection section(const std::string& figure_prefix) const = 0;
  /// The counts so far, as a part of a sentence.
  [[nodiscard]] virtual std::string counts() const = 0;
  /// The source reported progress or completion while the recording runs.
  virtual void on_source(const pipescout_msgs::msg::MissionStatus& status) = 0;
  /// The recording has ended: stop timers.
  virtual void stop_timers() = 0;
  /// Waits until the data files are on the disk.
  virtual void sync_files() = 0;
  /// Releases subscriptions and data files.
  virtual void close_files() = 0;

  CallbackReturn on_deactivate() override;
  CallbackReturn on_cleanup() override;
  CallbackReturn on_shutdown() override;

 private:
  void on_status(const pipescout_msgs::msg::MissionStatus& status);
  void write_section(Survives survives);
  void save();
  void finish();

  std::string data_name_;
  Parameter<std::string> mission_folder_parameter_;
  Parameter<std::string> source_parameter_;

  std::filesystem::path mission_folder_;
  std::filesystem::path data_folder_;  // empty: no recording
  std::string source_node_;            // fully qualified, or empty
  Outcome outcome_ = Outcome::kRunning;
  std::string outcome_text_;
  bool section_is_old_ = false;
  bool section_is_on_disk_ = false;
  bool cannot_write_ = false;
  Subscription<pipescout_msgs::msg::MissionStatus> status_subscription_;
  std::shared_ptr<Timer> section_timer_;
};

}  // namespace pipescout
