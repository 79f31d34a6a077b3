// SPDX-License-Identifier: Apache-2.0
#include "core/mission_folder.hpp"

#include <fcntl.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <cstdio>
#include <cstring>
#include <utility>

#include "pipescout/files/utc_text.hpp"
#include "pipescout/files/whole_file.hpp"

namespace pipescout::host {

namespace fs = std::filesystem;

namespace {

std::string folder_name(const std::string& mission, Time now) {
  return mission + "_" +
         utc_text(std::chrono::floor<std::chrono::milliseconds>(now), UtcForm::kFileName);
}

[[noreturn]] void cannot_be_made(const fs::path& folder, const std::error_code& error) {
  throw MissionFolderError(folder.string() + ": cannot be created: " + error.message());
}

}  // namespace

ReservedMissionFolder::ReservedMissionFolder(const fs::path& parent, const std::string& mission,
                                             Time now) {
  const auto missions = parent / "missions";
  const auto name = folder_name(mission, now);
  std::error_code error;
  for (int i = 1;;) {
    made_missions_ = fs::create_directories(missions, error) || made_missions_;
    if (error) {
      cannot_be_made(missions, error);
    }
    path_ = missions / (i == 1 ? name : name + "_" + std::to_string(i));
    if (fs::create_directory(path_, error)) {
      return;
    }
    if (!error) {
      ++i;
    } else if (error != std::errc::no_such_file_or_directory) {
      cannot_be_made(path_, error);
    }
    // Else the run that made `missions` has just given it up.
  }
}

ReservedMissionFolder::~ReservedMissionFolder() {
  // These remove only what is empty.
  std::error_code error;
  if (fs::remove(path_, error) && made_missions_) {
    fs::remove(path_.parent_path(), error);
  }
}

MissionFolder::MissionFolder(fs::path path) : path_(std::move(path)) {
  std::error_code error;
  for (auto folder = path_; !folder.empty() && !fs::exists(folder, error);
       folder = folder.parent_path()) {
    made_.push_back(folder);
  }
  fs::create_directories(path_, error);
  if (error) {
    cannot_be_made(path_, error);
  }
  for (const auto& entry : fs::directory_iterator(path_, error)) {
    before_.insert(entry.path());
  }
  // Of two runs only one makes `sections`.
  const bool is_new =
      !fs::exists(path_ / "mission.yaml", error) && fs::create_directory(path_ / "sections", error);
  if (error) {
    cannot_be_made(path_, error);
  }
  if (!is_new) {
    throw MissionFolderError(path_.string() + ": contains a mission already; give another --out");
  }
  const auto file = path_ / "mission.log";
  log_ = open(file.c_str(), O_WRONLY | O_CREAT | O_APPEND | O_CLOEXEC, 0644);
  if (log_ < 0) {
    throw MissionFolderError(file.string() + ": cannot be written: " + std::strerror(errno));
  }
}

MissionFolder::~MissionFolder() {
  close(log_);
}

void MissionFolder::discard() {
  std::error_code error;
  std::vector<fs::path> added;
  for (const auto& entry : fs::directory_iterator(path_, error)) {
    if (!before_.contains(entry.path())) {
      added.push_back(entry.path());
    }
  }
  for (const auto& entry : added) {
    fs::remove_all(entry, error);
  }
  for (const auto& folder : made_) {
    fs::remove(folder, error);
  }
}

void MissionFolder::write_composition(const std::string& yaml) const {
  replace_file(path_ / "mission.yaml", yaml);
}

void MissionFolder::write_versions(const std::string& yaml) const {
  replace_file(path_ / "versions.yaml", yaml);
}

void MissionFolder::log(LogSeverity severity, Time stamp, std::string_view name,
                        std::string_view text) {
  const auto since_epoch = stamp.time_since_epoch().count();
  std::array<char, 48> time{};
  std::snprintf(time.data(), time.size(), "%lld.%09lld",
                static_cast<long long>(since_epoch / 1000000000),
                static_cast<long long>(since_epoch % 1000000000));
  std::string line = std::string("[") + to_string(severity) + "] [" + time.data() + "] [";
  line.append(name).append("]: ").append(text) += '\n';
  // One write per line: lines of several threads never mix.
  [[maybe_unused]] const auto written = write(log_, line.data(), line.size());
}

}  // namespace pipescout::host
