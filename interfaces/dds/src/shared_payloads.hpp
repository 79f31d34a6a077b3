// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <atomic>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <deque>
#include <filesystem>
#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "shared_memory.hpp"
#include "warnings.hpp"

/// Large messages between the processes of one machine: the writer serialises into a block of
/// shared memory, and what travels in the message's place, through DDS with all that DDS promises,
/// is a reference to the block, from which the reader deserialises. So there is one copy in and one
/// copy out. See docs/decisions/large-messages-by-reference.md.
namespace pipescout::dds {

/// First 12 bytes of the GUID of a participant and of all its endpoints.
using GuidPrefix = std::array<std::uint8_t, 12>;

/// Names the contents of a block.
struct PayloadReference {
  GuidPrefix participant{};    ///< that owns the block
  std::uint32_t block = 0;     ///< its number there
  std::uint64_t sequence = 0;  ///< of the contents: a block is used again
  std::uint32_t bytes = 0;
  bool operator==(const PayloadReference&) const = default;
};

inline constexpr std::size_t kReferenceBytes = 32;

/// Four bytes of encapsulation that no CDR has, and the fields.
void encode(const PayloadReference& reference, std::span<std::byte, kReferenceBytes> payload);
/// Nothing when the payload is that of an ordinary message.
[[nodiscard]] std::optional<PayloadReference> decode_reference(std::span<const std::byte> payload);

/// The participant property that announces the scope.
inline constexpr const char* kPayloadScopeProperty = "pipescout.payload_scope";

/// Processes with the same scope can open each other's blocks: same machine, same folder, same
/// user, same layout of the blocks. Nothing when the folder is no shared memory.
[[nodiscard]] std::optional<std::string> payload_scope(
    const std::filesystem::path& folder = kSharedMemoryFolder);

/// Where the blocks of one participant stand.
class PayloadFolder {
 public:
  PayloadFolder(const GuidPrefix& participant, std::shared_ptr<Warnings> warnings,
                std::filesystem::path folder = kSharedMemoryFolder)
      : participant_(participant), warnings_(std::move(warnings)), folder_(std::move(folder)) {}

  [[nodiscard]] const GuidPrefix& participant() const noexcept { return participant_; }
  [[nodiscard]] const std::filesystem::path& path() const noexcept { return folder_; }
  [[nodiscard]] Warnings& warnings() const noexcept { return *warnings_; }
  [[nodiscard]] std::uint32_t next_block() noexcept { return ++last_block_; }

 private:
  const GuidPrefix participant_;
  const std::shared_ptr<Warnings> warnings_;
  const std::filesystem::path folder_;
  std::atomic<std::uint32_t> last_block_{0};
};

/// The blocks of one writer. A block is used again once all readers took its message, or once the
/// message left the writer's history ("keep last"). Thread-safe.
class PayloadWriter {
 public:
  /// `depth`: of the writer's history.
  PayloadWriter(std::shared_ptr<PayloadFolder> folder, std::size_t depth);
  PayloadWriter(const PayloadWriter&) = delete;
  PayloadWriter& operator=(const PayloadWriter&) = delete;
  /// Removes the blocks.
  ~PayloadWriter();

  /// Lets `fill` write a message of that size, which so many readers are going to take; `fill`
  /// returns false when it could not. Nothing then, and when there is no room.
  [[nodiscard]] std::optional<PayloadReference> store(
      std::size_t bytes, std::size_t readers,
      const std::function<bool(std::span<std::byte>)>& fill);

  /// Waits until the readers took what is stored; not long, since some may be gone.
  void await_readers(std::chrono::milliseconds at_most);

 private:
  class Block;

  Block* free_block(std::size_t bytes);  // under mutex_; null: no room
  Block* add_block(std::size_t bytes);   // under mutex_; null: no room

  const std::shared_ptr<PayloadFolder> folder_;
  const std::size_t depth_;
  std::mutex mutex_;
  std::vector<std::unique_ptr<Block>> blocks_;
  std::deque<Block*> history_;  // of the last messages, oldest first
  std::uint64_t last_sequence_ = 0;
};

/// The blocks of other participants, as they are needed. Thread-safe.
class PayloadReader {
 public:
  explicit PayloadReader(std::filesystem::path folder = kSharedMemoryFolder);
  PayloadReader(const PayloadReader&) = delete;
  PayloadReader& operator=(const PayloadReader&) = delete;
  ~PayloadReader();

  /// Gives `read` the message, and tells the writer that it was taken. The bytes may change while
  /// they are read; false when they did, or are no longer there: what was read is worth nothing.
  [[nodiscard]] bool take(const PayloadReference& reference,
                          const std::function<void(std::span<const std::byte>)>& read);
  /// Gives the memory of a participant back that is gone.
  void forget(const GuidPrefix& participant);

 private:
  class Mapping;
  using Key = std::pair<GuidPrefix, std::uint32_t>;

  std::shared_ptr<Mapping> mapping(const Key& key);

  const std::filesystem::path folder_;
  std::mutex mutex_;
  std::map<Key, std::shared_ptr<Mapping>> mappings_;
};

}  // namespace pipescout::dds
