// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <string>
#include <string_view>

/// Files that stay usable when the process is killed at any moment.
namespace pipescout {

/// A text file that grows by whole lines. Each line is passed to the operating system at once, in
/// one call: after a kill of the process all previous lines are complete. (A kill during that call
/// can truncate the last line; it then has no line end.) Not thread-safe.
class LineFile {
 public:
  /// Creates the file. Throws std::system_error naming it, also when it exists already.
  explicit LineFile(std::filesystem::path path);
  /// Closes the file without waiting for the disk.
  ~LineFile();
  LineFile(const LineFile&) = delete;
  LineFile& operator=(const LineFile&) = delete;

  /// `line` has no line end. Throws std::system_error naming the file; a partly written line is
  /// then removed.
  void write(std::string_view line);
  /// Returns once everything is on the disk. Throws std::system_error naming the file.
  void sync();

  [[nodiscard]] const std::filesystem::path& path() const noexcept { return path_; }

 private:
  std::filesystem::path path_;
  int descriptor_;
  std::string buffer_;
};

/// Event that written content must survive after the call has returned.
enum class Survives {
  kKill,      ///< the end of the process; does not wait for the disk, so a callback may use it
  kPowerLoss  ///< the end of the machine; waits for the disk
};

/// Replaces a file atomically: readers see either the old or the new content, whenever the process
/// stops; with kPowerLoss also whenever the machine stops. Throws std::system_error naming the
/// file.
void replace_file(const std::filesystem::path& path, std::string_view content,
                  Survives survives = Survives::kPowerLoss);

}  // namespace pipescout
