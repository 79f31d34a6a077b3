// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>

namespace pipescout {

/// An empty folder of its own among the temporary files, which only its owner may read; removed
/// with all that is in it at the end.
class TemporaryFolder {
 public:
  /// Throws std::system_error naming it when it cannot be made.
  TemporaryFolder();
  ~TemporaryFolder();
  TemporaryFolder(const TemporaryFolder&) = delete;
  TemporaryFolder& operator=(const TemporaryFolder&) = delete;

  [[nodiscard]] const std::filesystem::path& path() const noexcept { return path_; }

 private:
  std::filesystem::path path_;
};

}  // namespace pipescout
