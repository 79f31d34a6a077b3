// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <map>
#include <vector>

#include "file_access.hpp"
#include "mcap_records.hpp"
#include "pipescout/bags/bag_error.hpp"

namespace pipescout::bags::mcap {

/// A chunk of a file. The times are those of its messages' log times.
struct ChunkPlace {
  std::uint64_t offset = 0;  ///< of the record, with its prefix
  std::uint64_t length = 0;  ///< as far as the file goes
  std::uint64_t start_time = 0;
  std::uint64_t end_time = 0;
  std::vector<std::uint16_t> channels;  ///< with messages in it, sorted
  bool channels_known = false;
};

/// A message outside of chunks.
struct LooseMessage {
  std::uint64_t log_time = 0;
  std::uint64_t offset = 0;  ///< of the record's content
  std::uint64_t size = 0;    ///< of the content
  std::uint16_t channel = 0;
};

/// Where everything is in a file.
struct FileIndex {
  std::map<std::uint16_t, Schema> schemas;
  std::map<std::uint16_t, Channel> channels;
  std::vector<ChunkPlace> chunks;
  std::vector<LooseMessage> loose;  ///< by log time, then by place
  std::map<std::uint16_t, std::uint64_t> counts;
  std::uint64_t start_time = 0;
  std::uint64_t end_time = 0;
  bool has_checksums = false;
  std::vector<BagError> faults;
};

/// From the summary at the file's end; where there is none or it is damaged, from all records of
/// the file. Throws BagError when the file does not begin like MCAP, or cannot be read.
[[nodiscard]] FileIndex index_file(const InputFile& file);

/// Unpacks a chunk's records as far as possible and checks their CRC. What is wrong goes to
/// `faults`; the records of a chunk whose CRC is wrong are not returned.
void unpack_chunk(const InputFile& file, std::uint64_t offset, const Chunk& chunk, Bytes& records,
                  std::vector<BagError>& faults);

}  // namespace pipescout::bags::mcap
