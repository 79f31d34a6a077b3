// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <stdexcept>
#include <string>

namespace pipescout::bags {

/// What is wrong with a bag.
enum class BagFault : std::uint8_t {
  kNotFound,     ///< there is no such file or folder, or it holds no bag
  kExists,       ///< a new bag would overwrite something
  kMalformed,    ///< bytes that are not what the format says
  kIncomplete,   ///< the file ends too early, as after a kill: `recover_bag` mends it
  kChecksum,     ///< bytes changed since they were written
  kUnsupported,  ///< a version, compression or encoding that is not known here
  kNoSpace,      ///< the disk is full, or the file has reached the largest size allowed
  kSystem,       ///< the operating system failed to read or write
  kUsage         ///< the call makes no sense: an unknown topic, a closed writer
};

/// Everything that this package throws about bags. what() is
/// "FILE: offset OFFSET: FIELD: message", without the parts that do not apply.
class BagError : public std::runtime_error {
 public:
  BagError(BagFault fault, std::filesystem::path file, const std::string& message);
  /// `offset`: bytes from the start of the file.
  BagError(BagFault fault, std::filesystem::path file, std::uint64_t offset,
           const std::string& field, const std::string& message);

  [[nodiscard]] BagFault fault() const noexcept { return fault_; }
  [[nodiscard]] const std::filesystem::path& file() const noexcept { return file_; }
  [[nodiscard]] std::optional<std::uint64_t> offset() const noexcept { return offset_; }

 private:
  BagFault fault_;
  std::filesystem::path file_;
  std::optional<std::uint64_t> offset_;
};

}  // namespace pipescout::bags
