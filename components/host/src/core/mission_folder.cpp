// SPDX-License-Identifier: Apache-2.0
#include "core/mission_folder.hpp"

#include <fcntl.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <cstdio>
#include <cstring>
#include <ctime>
#include <utility>

#include "pipescout/interfaces/whole_file.hpp"

namespace pipescout::host {

namespace fs = std::filesystem;

fs::path default_mission_folder(const fs::path& parent, const std::string& mission, Time now) {
  const auto seconds = std::chrono::floor<std::chrono::seconds>(now);
  const std::time_t time = std::chrono::system_clock::to_time_t(
      std::chrono::time_point_cast<std::chrono::system_clock::duration>(seconds));
  std::tm utc{};
  gmtime_r(&time, &utc);
  std::array<char, 32> stamp{};
  std::strftime(stamp.data(), stamp.size(), "%Y-%m-%dT%H-%M-%SZ", &utc);
  const auto name = mission + "_" + stamp.data();
  auto folder = parent / "missions" / name;
  for (int i = 2; fs::exists(folder); ++i) {
    folder = parent / "missions" / (name + "_" + std::to_string(i));
  }
  return folder;
}

MissionFolder::MissionFolder(fs::path path) : path_(std::move(path)) {
  std::error_code error;
  for (const char* trace : {"mission.yaml", "sections"}) {
    if (fs::exists(path_ / trace, error)) {
      throw MissionFolderError(path_.string() + ": holds a mission already; give another --out");
    }
  }
  fs::create_directories(path_ / "sections", error);
  if (error) {
    throw MissionFolderError(path_.string() + ": cannot be made: " + error.message());
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

void MissionFolder::write_composition(const std::string& yaml) const {
  replace_file(path_ / "mission.yaml", yaml);
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
