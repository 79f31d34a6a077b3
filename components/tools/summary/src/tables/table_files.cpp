// SPDX-License-Identifier: Apache-2.0
#include "tables/table_files.hpp"

#include <cerrno>
#include <system_error>
#include <utility>

namespace pipescout::summary {
namespace {

namespace fs = std::filesystem;

[[noreturn]] void fail(const fs::path& path) {
  throw std::system_error(errno == 0 ? EIO : errno, std::generic_category(), path.string());
}

}  // namespace

TableFile::TableFile(const std::optional<fs::path>& path) {
  if (!path) {
    stream_.setstate(std::ios::badbit);
    return;
  }
  path_ = *path;
  errno = 0;
  stream_.open(path_, std::ios::binary);
  if (!stream_) {
    fail(path_);
  }
}

void TableFile::write(std::string_view line) {
  stream_ << line << '\n';
}

void TableFile::close() {
  if (path_.empty()) {
    return;
  }
  errno = 0;
  stream_.close();
  if (!stream_) {
    fail(path_);
  }
}

TableFiles::TableFiles(std::optional<fs::path> folder) : folder_(std::move(folder)) {}

TableFiles::~TableFiles() {
  if (!unfinished_.empty()) {
    std::error_code ignored;
    fs::remove_all(unfinished_, ignored);
  }
}

fs::path TableFiles::place(const fs::path& name) {
  if (unfinished_.empty()) {
    unfinished_ = folder_->parent_path() / ("." + folder_->filename().string() + ".unfinished");
    fs::remove_all(unfinished_);  // of a run that was killed
    fs::create_directories(unfinished_);
  }
  return unfinished_ / name;
}

TableFile& TableFiles::file(std::string_view name, const std::function<std::string()>& header) {
  if (const auto found = files_.find(name); found != files_.end()) {
    return found->second;
  }
  const auto path = folder_ ? std::optional(place(name)) : std::nullopt;
  TableFile& made = files_.try_emplace(std::string(name), path).first->second;
  made.write(header());
  return made;
}

void TableFiles::write_whole(const fs::path& name, std::string_view content) {
  if (!folder_) {
    return;
  }
  const fs::path path = place(name);
  fs::create_directories(path.parent_path());
  errno = 0;
  std::ofstream stream(path, std::ios::binary);
  stream.write(content.data(), static_cast<std::streamsize>(content.size()));
  stream.close();
  if (!stream) {
    fail(path);
  }
}

void TableFiles::finish() {
  for (auto& [name, file] : files_) {
    file.close();
  }
  files_.clear();
  if (unfinished_.empty()) {
    return;
  }
  fs::remove_all(*folder_);
  fs::rename(unfinished_, *folder_);
  unfinished_.clear();
}

}  // namespace pipescout::summary
