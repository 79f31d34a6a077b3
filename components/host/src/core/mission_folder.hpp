// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <set>
#include <string>
#include <string_view>
#include <vector>

#include "pipescout/command_line/mission_summary.hpp"
#include "pipescout/runtime/logger.hpp"
#include "pipescout/runtime/time.hpp"

namespace pipescout::host {

using command_line::MissionFolderError;

/// A name for a mission folder that nobody else can take: `missions/<mission>_<UTC time>` below
/// `parent`, with "_2", "_3", ... behind it when that is taken. The folder is made at once, and
/// goes with this object if it is still empty then.
class ReservedMissionFolder {
 public:
  /// Throws MissionFolderError.
  ReservedMissionFolder(const std::filesystem::path& parent, const std::string& mission, Time now);
  ReservedMissionFolder(const ReservedMissionFolder&) = delete;
  ReservedMissionFolder& operator=(const ReservedMissionFolder&) = delete;
  ~ReservedMissionFolder();

  [[nodiscard]] const std::filesystem::path& path() const noexcept { return path_; }

 private:
  std::filesystem::path path_;
  bool made_missions_ = false;
};

/// The folder of one run. Thread-safe.
class MissionFolder {
 public:
  /// Makes the folder; it may exist, but must not hold a mission, nor may another run begin one
  /// there at the same time. Throws MissionFolderError.
  explicit MissionFolder(std::filesystem::path path);
  MissionFolder(const MissionFolder&) = delete;
  MissionFolder& operator=(const MissionFolder&) = delete;
  ~MissionFolder();

  [[nodiscard]] const std::filesystem::path& path() const noexcept { return path_; }
  /// For a run that did nothing: removes what the folder did not hold when this object was made,
  /// then the folder and its parents, if this object made them and they are empty. Nothing may be
  /// written into it any more. What cannot be removed stays.
  void discard();
  /// Throws std::system_error naming the file.
  void write_composition(const std::string& yaml) const;
  /// Throws std::system_error naming the file.
  void write_versions(const std::string& yaml) const;
  /// Adds a line to `mission.log`, at once, as the console shows it. A full disk is not reported:
  /// there is nowhere to say it.
  void log(LogSeverity severity, Time stamp, std::string_view name, std::string_view text);

 private:
  std::filesystem::path path_;
  std::set<std::filesystem::path> before_;   ///< what the folder held
  std::vector<std::filesystem::path> made_;  ///< folders, the innermost first
  int log_ = -1;
};

}  // namespace pipescout::host
