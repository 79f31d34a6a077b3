// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <fstream>
#include <functional>
#include <map>
#include <optional>
#include <string>
#include <string_view>

namespace pipescout::summary {

/// A data file that grows by lines.
class TableFile {
 public:
  /// Nothing: lines are not kept. Throws std::system_error naming the file.
  explicit TableFile(const std::optional<std::filesystem::path>& path);

  void write(std::string_view line);
  /// Throws std::system_error naming the file when it is not whole.
  void close();

 private:
  std::filesystem::path path_;
  std::ofstream stream_;
};

/// The data files of one subject. They are written into a folder beside the one that is wanted, and
/// take its place when all are there: a reader never meets half of them.
class TableFiles {
 public:
  /// Nothing: no files. The folder is made with the first file.
  explicit TableFiles(std::optional<std::filesystem::path> folder);
  TableFiles(const TableFiles&) = delete;
  TableFiles& operator=(const TableFiles&) = delete;
  /// What was not finished goes.
  ~TableFiles();

  /// The file of this name; a new one begins with the header. Throws std::system_error naming it.
  [[nodiscard]] TableFile& file(std::string_view name, const std::function<std::string()>& header);
  /// A file as a whole; its folders are made. Throws std::system_error naming it.
  void write_whole(const std::filesystem::path& name, std::string_view content);
  /// Puts the folder in its place; what was there goes. Throws std::system_error,
  /// std::filesystem::filesystem_error.
  void finish();

 private:
  [[nodiscard]] std::filesystem::path place(const std::filesystem::path& name);

  std::optional<std::filesystem::path> folder_;
  std::filesystem::path unfinished_;  // empty: no file yet
  std::map<std::string, TableFile, std::less<>> files_;
};

}  // namespace pipescout::summary
