// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "pipescout/bags/bag_types.hpp"
#include "pipescout/bags/bag_writer.hpp"

namespace pipescout::bags {

/// What was found in a bag.
struct BagReport {
  /// Messages that can be read.
  std::uint64_t messages = 0;
  /// One sentence each, with file and offset; empty when everything can be read and agrees.
  std::vector<std::string> faults;
  /// What no reader needs but a user should know: no metadata, no checksums.
  std::vector<std::string> notes;
};

/// Reads all of a bag, its checksums, and compares it with what metadata and summaries say. Never
/// throws for what is wrong with the bag: that is what it reports.
[[nodiscard]] BagReport check_bag(const std::filesystem::path& bag);

/// Writes `metadata.yaml` anew from the files of the folder. Throws BagError, and changes nothing
/// then, when a file cannot be read whole.
BagMetadata reindex_bag(const std::filesystem::path& folder);

/// Writes everything that can be read from a bag to a new one. `report.faults` is what could not.
/// Throws BagError when the new bag cannot be written, or when nothing can be read at all.
[[nodiscard]] BagReport recover_bag(const std::filesystem::path& bag,
                                    const std::filesystem::path& new_folder,
                                    const BagWriterOptions& options);

}  // namespace pipescout::bags
