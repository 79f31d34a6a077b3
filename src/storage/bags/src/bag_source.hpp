// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <queue>
#include <string>
#include <unordered_map>
#include <utility>
#include <vector>

#include "bytes.hpp"
#include "pipescout/bags/bag_error.hpp"
#include "pipescout/bags/bag_types.hpp"
#include "storage_file.hpp"

namespace pipescout::bags {

/// The files of a bag in a folder, by the number in their names.
[[nodiscard]] std::vector<std::filesystem::path> files_in(const std::filesystem::path& folder);

/// A file of a bag that is read; one that is compressed is unpacked to a temporary file.
class OpenedFile {
 public:
  explicit OpenedFile(const std::filesystem::path& path);
  ~OpenedFile();
  OpenedFile(const OpenedFile&) = delete;
  OpenedFile& operator=(const OpenedFile&) = delete;

  [[nodiscard]] FileReader& reader() const noexcept { return *reader_; }
  /// Those of the reader, and what unpacking met.
  [[nodiscard]] std::vector<BagError> faults() const;

 private:
  std::filesystem::path unpacked_folder_;  ///< empty: not compressed
  std::optional<BagError> fault_;
  std::unique_ptr<FileReader> reader_;
};

/// All files of a bag, merged by log time; BagReader without its exceptions.
class BagSource {
 public:
  /// Throws BagError when nothing can be read at all.
  explicit BagSource(std::filesystem::path bag);

  [[nodiscard]] const std::filesystem::path& path() const noexcept { return path_; }
  [[nodiscard]] bool has_metadata_file() const noexcept { return has_metadata_file_; }
  [[nodiscard]] const BagMetadata& metadata() const noexcept { return metadata_; }
  [[nodiscard]] const std::vector<BagTopic>& topics() const noexcept { return topics_; }
  /// Files by the metadata or in the folder.
  [[nodiscard]] std::vector<std::filesystem::path> files() const;
  [[nodiscard]] bool has_checksums() const noexcept { return has_checksums_; }

  void set_filter(BagFilter filter);
  void seek(std::int64_t time);
  [[nodiscard]] bool next(BagMessage& message);
  /// What could not be read up to now.
  [[nodiscard]] const std::vector<BagError>& faults() const noexcept { return faults_; }

 private:
  struct File {
    std::filesystem::path path;
    std::optional<std::pair<std::int64_t, std::int64_t>> times;  ///< first and last, where known
    std::unique_ptr<OpenedFile> opened;
    std::vector<TopicIndex> topics;  ///< of the bag, by the topic of the file
    BagMessage message;              ///< the next one
    std::size_t faults_told = 0;
    bool is_broken = false;
  };
  struct Head {
    std::int64_t log_time;
    std::size_t file;
    bool operator<(const Head& other) const {
      return std::pair(log_time, file) > std::pair(other.log_time, other.file);
    }
  };

  void find_files();
  void read_all_topics();
  void describe_files();
  bool open(File& file);
  void close(File& file);
  void take_faults(File& file);
  TopicIndex index_of(const BagTopic& topic);
  void begin(std::int64_t start);
  void start(std::size_t file);
  void advance(std::size_t file);
  [[nodiscard]] bool unpack_message(const File& file, BagMessage& message);

  std::filesystem::path path_;
  bool has_metadata_file_ = false;
  bool has_checksums_ = true;
  BagMetadata metadata_;
  std::vector<BagTopic> topics_;
  std::vector<File> files_;
  std::vector<BagError> faults_;

  BagFilter filter_;
  std::int64_t start_ = 0;
  std::vector<bool> wanted_;
  std::vector<std::size_t> pending_;  ///< files by their start
  std::size_t next_pending_ = 0;
  std::priority_queue<Head> active_;
  std::optional<std::size_t> last_;  ///< file of the message that was handed out last
  Bytes unpacked_;
};

/// Metadata that grow file by file.
class MetadataSum {
 public:
  void add(const std::filesystem::path& path, const FileContent& content);
  [[nodiscard]] const BagMetadata& metadata() const noexcept { return metadata_; }

 private:
  BagMetadata metadata_;
};

/// What the files of a folder say, without what a metadata file says. Faults go to `faults`.
[[nodiscard]] BagMetadata metadata_of_files(const std::vector<std::filesystem::path>& files,
                                            Compression compression, std::vector<BagError>& faults);

/// Whether a message is compressed by itself: no CDR begins like zstd.
[[nodiscard]] bool is_zstd(ByteView bytes) noexcept;

/// All of a small text file. Throws BagError.
[[nodiscard]] std::string read_text(const std::filesystem::path& path);

}  // namespace pipescout::bags
