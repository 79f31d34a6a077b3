// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <string>
#include <string_view>

/// Files that stay usable when the process is killed at any moment.
namespace pipescout {

/// A text file that grows by whole lines. Each line is given to the operating system when it is
/// written, by one call: a process that is killed leaves all lines before, whole. (A kill in the
/// middle of that call can cut the last line; it then has no line end.)
/// Not thread-safe.
class LineFile {
 public:
  /// Makes the file. Throws std::system_error naming it, also when it exists already.
  explicit LineFile(std::filesystem::path path);
  /// Closes the file without waiting for the disk.
  ~LineFile();
  LineFile(const LineFile&) = delete;
  LineFile& operator=(const LineFile&) = delete;

  /// `line` has no line end. Throws std::system_error naming the file; what had been written of the
  /// line is then taken back.
  void write(std::string_view line);
  /// Returns once everything is on the disk. Throws std::system_error naming the file.
  void sync();

  [[nodiscard]] const std::filesystem::path& path() const noexcept { return path_; }

 private:
  std::filesystem::path path_;
  int descriptor_;
  std::string buffer_;
};

/// What content must survive once the call that writes it has returned.
enum class Survives {
  kKill,      ///< the end of the process; does not wait for the disk, so a callback may write it
  kPowerLoss  ///< the end of the machine; waits for the disk
};

/// Writes a file anew, so that readers see the content before or the content after and nothing
/// between, whenever the process stops; with kPowerLoss also whenever the machine stops. Throws
/// std::system_error naming the file.
void replace_file(const std::filesystem::path& path, std::string_view content,
                  Survives survives = Survives::kPowerLoss);

}  // namespace pipescout
