// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <vector>

#include "file_access.hpp"
#include "pipescout/bags/bag_types.hpp"

namespace pipescout::bags {

/// The rows of a bag's tables from the leaf pages of a damaged or cut database, which SQLite itself
/// does not open: https://www.sqlite.org/fileformat2.html. Rows are told apart by their columns:
/// those of `topics` are texts, those of `messages` end with a blob.
class SqlitePages {
 public:
  struct Row {
    std::int64_t id = 0;
    std::int64_t topic = 0;
    std::int64_t time = 0;
    std::uint64_t blob_size = 0;
    std::uint64_t blob_offset = 0;    ///< in the payload
    std::uint64_t local_offset = 0;   ///< of the payload's first part, in the file
    std::uint64_t local_size = 0;     ///< of that part
    std::uint32_t overflow_page = 0;  ///< where it goes on; 0: nowhere
  };

  /// Reads all pages. Throws BagError when the file does not begin like a database.
  explicit SqlitePages(const InputFile& file);

  /// How large the file should be by the first 100 bytes; 0 where they do not tell.
  [[nodiscard]] static std::uint64_t size_by_header(ByteView header) noexcept;

  /// By id.
  [[nodiscard]] const std::map<std::int64_t, BagTopic>& topics() const noexcept { return topics_; }
  /// By time, then by id; only those whose data is in the file.
  [[nodiscard]] const std::vector<Row>& rows() const noexcept { return rows_; }
  /// The data of a row; false when it is not there.
  [[nodiscard]] bool read(const Row& row, Bytes& blob) const;

 private:
  void read_leaf(ByteView page, std::uint64_t page_offset, std::size_t header);
  void read_cell(ByteView page, std::uint64_t page_offset, std::size_t cell);
  [[nodiscard]] bool is_whole(const Row& row) const;

  const InputFile& file_;
  std::uint64_t page_size_ = 0;
  std::uint64_t usable_ = 0;
  std::map<std::int64_t, BagTopic> topics_;
  std::vector<Row> rows_;
};

}  // namespace pipescout::bags
