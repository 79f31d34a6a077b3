// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "pipescout/bags/bag_error.hpp"
#include "pipescout/bags/bag_types.hpp"

namespace pipescout::bags {

/// Reads the messages of a bag by rising log time; those of equal times in the order of the files
/// and in them.
///
/// Files that were cut or damaged are read as far as they go: `next` first hands out every message
/// that can be read, then throws. Not thread-safe: one thread at a time; several readers of one bag
/// do not disturb each other. Memory: the chunks whose log times overlap, or SQLite's own few MB;
/// an index of some 24 bytes for each message of MCAP files without chunks. Nothing in the bag's
/// folder is changed or made, and it may be write-protected. A file compressed as a whole is
/// unpacked into the folder for temporary files while it is read, and a database whose writer was
/// killed is copied there to be completed.
class BagReader {
 public:
  /// A bag's folder, with or without `metadata.yaml`, or a single .db3, .mcap or .bag file.
  /// Throws BagError when it is no bag, or nothing in it can be read.
  explicit BagReader(std::filesystem::path bag);
  ~BagReader();
  BagReader(const BagReader&) = delete;
  BagReader& operator=(const BagReader&) = delete;

  /// What `metadata.yaml` says; where there is none, what the files say.
  [[nodiscard]] const BagMetadata& metadata() const noexcept;
  /// The topics of all files, with their schemas; TopicIndex is the position in it.
  [[nodiscard]] const std::vector<BagTopic>& topics() const noexcept;

  /// Reads from the start anew, and only what the filter lets pass: chunks and files without any of
  /// it are not read. Names that the bag does not have are no error.
  void set_filter(BagFilter filter);
  /// The next message will be the first one at or after `time` (ns), within the filter.
  void seek(std::int64_t time);

  /// The next message, none behind the last one. Its data is valid until the next call of any
  /// function. Throws BagError once, when all that can be read has been handed out and something
  /// could not; the next call then gives none.
  [[nodiscard]] std::optional<BagMessage> next();
  /// The same for programs that use a damaged bag as far as it goes: where `next` throws, none, and
  /// `damage` gets what it says.
  [[nodiscard]] std::optional<BagMessage> next_before_damage(std::string& damage);

 private:
  class Implementation;
  std::unique_ptr<Implementation> implementation_;
};

}  // namespace pipescout::bags
