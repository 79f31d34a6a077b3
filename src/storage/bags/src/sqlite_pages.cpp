// SPDX-License-Identifier: Apache-2.0
#include "sqlite_pages.hpp"

#include <algorithm>
#include <array>
#include <bit>
#include <string>
#include <tuple>

#include "pipescout/bags/bag_error.hpp"

namespace pipescout::bags {
namespace {

constexpr std::string_view kMagic("SQLite format 3\0", 16);
constexpr std::uint64_t kHeaderSize = 100;
constexpr std::byte kTableLeaf{0x0D};

std::uint64_t big_endian(ByteView bytes) {
  std::uint64_t value = 0;
  for (const std::byte each : bytes) {
    value = value << 8U | std::to_integer<std::uint64_t>(each);
  }
  return value;
}

/// Takes a number of 1 to 9 bytes.
std::optional<std::uint64_t> take_varint(ByteCursor& from) {
  std::uint64_t value = 0;
  for (int k = 0; k < 9; ++k) {
    const auto byte = from.number<std::uint8_t>();
    if (!byte) {
      return std::nullopt;
    }
    if (k == 8) {
      return value << 8U | *byte;
    }
    value = value << 7U | (*byte & 0x7FU);
    if ((*byte & 0x80U) == 0) {
      return value;
    }
  }
  return value;
}

struct Column {
  std::uint64_t serial = 0;
  std::uint64_t offset = 0;  ///< in the payload
  std::uint64_t size = 0;

  [[nodiscard]] bool is_text() const { return serial >= 13 && serial % 2 == 1; }
  [[nodiscard]] bool is_blob() const { return serial >= 12 && serial % 2 == 0; }
  [[nodiscard]] bool is_integer() const {
    return (serial >= 1 && serial <= 6) || serial == 8 || serial == 9;
  }
};

std::uint64_t size_of(std::uint64_t serial) {
  constexpr std::array<std::uint64_t, 12> kSizes{0, 1, 2, 3, 4, 6, 8, 8, 0, 0, 0, 0};
  return serial < kSizes.size() ? kSizes.at(serial) : (serial - 12) / 2;
}

/// The columns that a payload's header tells; none when it makes no sense.
std::optional<std::vector<Column>> columns_of(ByteView payload) {
  ByteCursor cursor(payload);
  const auto header = take_varint(cursor);
  constexpr std::uint64_t kMaxHeader = 64;
  if (!header || *header > std::min<std::uint64_t>(payload.size(), kMaxHeader)) {
    return std::nullopt;
  }
  std::vector<Column> columns;
  std::uint64_t offset = *header;
  while (cursor.position() < *header) {
    const auto serial = take_varint(cursor);
    if (!serial || *serial > std::uint64_t{1} << 40U) {
      return std::nullopt;
    }
    columns.push_back({*serial, offset, size_of(*serial)});
    offset += columns.back().size;
  }
  return columns;
}

std::optional<std::int64_t> integer(ByteView payload, const Column& column) {
  if (column.serial == 8 || column.serial == 9) {
    return static_cast<std::int64_t>(column.serial) - 8;
  }
  if (!column.is_integer() || column.offset + column.size > payload.size()) {
    return std::nullopt;
  }
  const std::uint64_t raw = big_endian(payload.subspan(column.offset, column.size));
  const auto shift = static_cast<unsigned>(64 - 8 * column.size);
  return std::bit_cast<std::int64_t>(raw << shift) >> shift;
}

}  // namespace

std::uint64_t SqlitePages::size_by_header(ByteView header) noexcept {
  std::uint64_t page_size = big_endian(header.subspan(16, 2));
  page_size = page_size == 1 ? 65536 : page_size;
  const ByteView change_counter = header.subspan(24, 4);
  const ByteView valid_for = header.subspan(92, 4);
  // The number of pages is only kept by writers that note for which change it holds.
  const bool is_valid = std::equal(change_counter.begin(), change_counter.end(), valid_for.begin());
  return is_valid ? big_endian(header.subspan(28, 4)) * page_size : 0;
}

SqlitePages::SqlitePages(const InputFile& file) : file_(file) {
  Bytes header;
  file.read(0, kHeaderSize, header);
  if (!kMagic.starts_with(text_of(header).substr(0, kMagic.size()))) {
    throw BagError(BagFault::kMalformed, file.path(), 0, "header", "is not that of SQLite");
  }
  if (header.size() < kHeaderSize) {
    throw BagError(BagFault::kIncomplete, file.path(), header.size(), "header", "is cut");
  }
  page_size_ = big_endian(std::span(header).subspan(16, 2));
  page_size_ = page_size_ == 1 ? 65536 : page_size_;
  if (page_size_ < 512 || !std::has_single_bit(page_size_)) {
    throw BagError(BagFault::kMalformed, file.path(), 16, "page size",
                   std::to_string(page_size_) + " is none");
  }
  usable_ = page_size_ - std::to_integer<std::uint64_t>(header[20]);
  Bytes page;
  for (std::uint64_t offset = 0; offset + page_size_ <= file.size(); offset += page_size_) {
    file.read(offset, page_size_, page);
    const std::size_t start = offset == 0 ? kHeaderSize : 0;
    if (page.size() == page_size_ && page[start] == kTableLeaf) {
      read_leaf(page, offset, start);
    }
  }
  const auto key = [](const Row& row) { return std::tuple(row.time, row.id); };
  std::sort(rows_.begin(), rows_.end(),
            [&](const Row& a, const Row& b) { return key(a) < key(b); });
  rows_.erase(std::unique(rows_.begin(), rows_.end(),
                          [&](const Row& a, const Row& b) { return key(a) == key(b); }),
              rows_.end());
}

void SqlitePages::read_leaf(ByteView page, std::uint64_t page_offset, std::size_t header) {
  const std::uint64_t count = big_endian(page.subspan(header + 3, 2));
  const std::size_t pointers = header + 8;
  for (std::size_t k = 0; k < count && pointers + 2 * k + 2 <= page.size(); ++k) {
    const auto cell = static_cast<std::size_t>(big_endian(page.subspan(pointers + 2 * k, 2)));
    if (cell < page.size()) {
      read_cell(page, page_offset, cell);
    }
  }
}

void SqlitePages::read_cell(ByteView page, std::uint64_t page_offset, std::size_t cell) {
  ByteCursor cursor(page.subspan(cell));
  const auto size = take_varint(cursor);
  const auto id = size ? take_varint(cursor) : std::nullopt;
  if (!id || *size > file_.size()) {
    return;
  }
  const std::uint64_t most = usable_ - 35;
  std::uint64_t local = *size;
  if (local > most) {
    const std::uint64_t least = (usable_ - 12) * 32 / 255 - 23;
    local = least + (*size - least) % (usable_ - 4);
    local = local <= most ? local : least;
  }
  const auto payload = cursor.bytes(local);
  if (!payload) {
    return;
  }
  Row row{.id = std::bit_cast<std::int64_t>(*id),
          .local_offset = page_offset + cell + cursor.position() - local,
          .local_size = local};
  if (local < *size) {
    const auto overflow = cursor.bytes(4);
    if (!overflow) {
      return;
    }
    row.overflow_page = static_cast<std::uint32_t>(big_endian(*overflow));
  }
  const auto columns = columns_of(*payload);
  // The id, which is the row's own number, is stored as NULL.
  if (!columns || columns->size() < 4 || (*columns)[0].serial != 0) {
    return;
  }
  const auto& column = *columns;
  if (columns->size() == 4 && column[3].is_blob()) {
    const auto topic = integer(*payload, column[1]);
    const auto time = integer(*payload, column[2]);
    row.blob_offset = column[3].offset;
    row.blob_size = column[3].size;
    if (topic && time && row.blob_offset + row.blob_size == *size && is_whole(row)) {
      row.topic = *topic;
      row.time = *time;
      rows_.push_back(row);
    }
  } else if (columns->size() >= 5 && std::all_of(column.begin() + 1, column.end(),
                                                 [](const Column& c) { return c.is_text(); })) {
    // Texts of QoS can be longer than a page.
    row.blob_offset = 0;
    row.blob_size = *size;
    Bytes all;
    if (read(row, all)) {
      const auto text = [&](std::size_t k) {
        const auto& place = column[k];
        return place.offset + place.size <= all.size()
                   ? std::string(text_of(std::span(all).subspan(place.offset, place.size)))
                   : std::string();
      };
      topics_[row.id] = BagTopic{.name = text(1),
                                 .type = text(2),
                                 .serialization_format = text(3),
                                 .offered_qos_profiles = text(4)};
    }
  }
}

bool SqlitePages::is_whole(const Row& row) const {
  const std::uint64_t end = row.blob_offset + row.blob_size;
  std::uint64_t have = row.local_size;
  std::uint32_t page = row.overflow_page;
  Bytes next;
  while (have < end) {
    const std::uint64_t offset = (std::uint64_t{page} - 1) * page_size_;
    if (page == 0 || offset + page_size_ > file_.size()) {
      return false;
    }
    file_.read(offset, 4, next);
    page = static_cast<std::uint32_t>(big_endian(next));
    have += usable_ - 4;
  }
  return true;
}

bool SqlitePages::read(const Row& row, Bytes& blob) const {
  const std::uint64_t end = row.blob_offset + row.blob_size;
  Bytes payload;
  file_.read(row.local_offset, row.local_size, payload);
  std::uint32_t page = row.overflow_page;
  Bytes part;
  while (payload.size() < end) {
    const std::uint64_t offset = (std::uint64_t{page} - 1) * page_size_;
    if (page == 0 || offset + page_size_ > file_.size()) {
      return false;
    }
    file_.read(offset, usable_, part);
    if (part.size() < usable_) {
      return false;
    }
    page = static_cast<std::uint32_t>(big_endian(std::span(part).first(4)));
    append(payload, std::span(part).subspan(4));
  }
  blob.assign(payload.begin() + static_cast<std::ptrdiff_t>(row.blob_offset),
              payload.begin() + static_cast<std::ptrdiff_t>(end));
  return true;
}

}  // namespace pipescout::bags
