// SPDX-License-Identifier: Apache-2.0
#include "pipescout/bags/bag_writer.hpp"

#include <algorithm>
#include <future>
#include <optional>
#include <stdexcept>
#include <string>
#include <system_error>
#include <unordered_map>
#include <utility>
#include <vector>

#include "bag_source.hpp"
#include "compression.hpp"
#include "file_access.hpp"
#include "pipescout/bags/bag_error.hpp"
#include "pipescout/bags/bag_metadata.hpp"
#include "pipescout/files/whole_file.hpp"
#include "storage_file.hpp"

namespace pipescout::bags {
namespace {

namespace fs = std::filesystem;
using Clock = std::chrono::steady_clock;

/// A kill may cost one second; the rest is for the flush itself and for the caller's pauses.
constexpr std::chrono::milliseconds kFlushPeriod{800};
/// Of rosbag2: smaller SQLite files would hold no message.
constexpr std::uint64_t kSmallestSplit = 86016;

void check(const BagWriterOptions& options) {
  const auto refuse = [](const std::string& what) { throw std::invalid_argument(what); };
  if (options.storage == Storage::kRos1) {
    refuse("storage: bags of ROS 1 are only read");
  }
  if (options.max_file_size != 0 && options.max_file_size < kSmallestSplit) {
    refuse("max_file_size: " + std::to_string(options.max_file_size) + " is not 0 nor at least " +
           std::to_string(kSmallestSplit));
  }
  if (options.max_file_duration.count() < 0) {
    refuse("max_file_duration: is negative");
  }
  if (options.compression_level < 1 || options.compression_level > 19) {
    refuse("compression_level: " + std::to_string(options.compression_level) +
           " is not from 1 to 19");
  }
  if (options.chunk_size < 1 || options.chunk_size > std::uint64_t{1} << 30U) {
    refuse("chunk_size: " + std::to_string(options.chunk_size) + " is not from 1 byte to 1 GiB");
  }
}

}  // namespace

class BagWriter::Implementation {
 public:
  Implementation(fs::path folder, const BagWriterOptions& options)
      : folder_(std::move(folder)), options_(options) {
    check(options);
    // "bag/" names the same folder as "bag".
    folder_ = folder_.has_filename() ? folder_ : folder_.parent_path();
    std::error_code error;
    if (fs::exists(folder_, error)) {
      throw BagError(BagFault::kExists, folder_, "exists already; a bag is never overwritten");
    }
    if (!fs::create_directories(folder_, error)) {
      throw_system_error(error ? error.value() : EEXIST, folder_, "cannot be made");
    }
    if (options.compression == Compression::kMessage) {
      compressor_.emplace(options.compression_level);
    }
    metadata_.storage = options.storage;
    metadata_.compression = options.compression;
    begin_file();
  }

  ~Implementation() {
    try {
      close();
    } catch (const std::exception&) {
      // Whoever wants to know calls close().
    }
  }

  TopicIndex add_topic(const BagTopic& topic) {
    require_usable();
    if (topic.name.empty() || topic.type.empty()) {
      throw BagError(BagFault::kUsage, folder_,
                     "a topic needs a name and a type: '" + topic.name + "', '" + topic.type + "'");
    }
    const auto [entry, is_new] =
        indexes_.try_emplace(topic.name, static_cast<TopicIndex>(metadata_.topics.size()));
    if (!is_new) {
      const BagTopic& known = metadata_.topics[entry->second].topic;
      if (known.type != topic.type) {
        throw BagError(BagFault::kUsage, folder_,
                       topic.name + " is of type " + known.type + " already, not " + topic.type);
      }
      return entry->second;
    }
    metadata_.topics.push_back({topic, 0});
    guarded([&] { file_->add_topic(topic); });
    return entry->second;
  }

  void write(const BagMessage& message) {
    require_usable();
    check_message(message);
    guarded([&] {
      BagMessage stored = message;
      if (compressor_) {
        compressor_->compress(message.data, packed_);
        stored.data = packed_;
      }
      BagFile& current = metadata_.files.back();
      if (current.messages > 0 && is_full(current, stored)) {
        end_file();
        begin_file();
      }
      file_->write(stored);
      count(stored);
      flush_if_due();
    });
  }

  void flush() {
    require_usable();
    guarded([&] {
      file_->flush();
      last_flush_ = Clock::now();
    });
  }

  void flush_if_due() {
    if (options_.flush_by_time && Clock::now() - last_flush_ >= kFlushPeriod) {
      flush();
    }
  }

  void split() {
    require_usable();
    guarded([&] {
      end_file();
      begin_file();
    });
  }

  void close() {
    if (std::exchange(closed_, true)) {
      return;
    }
    if (failed_) {
      close_after_error();
      return;
    }
    try {
      end_file();
      wait_for_compression();
      write_metadata();
    } catch (...) {
      failed_ = true;
      close_after_error();
      throw;
    }
  }

  [[nodiscard]] const BagMetadata& metadata() const noexcept { return metadata_; }
  [[nodiscard]] const fs::path& folder() const noexcept { return folder_; }

 private:
  void require_usable() const {
    if (closed_ || failed_) {
      throw BagError(BagFault::kUsage, folder_,
                     closed_ ? "the bag is closed" : "the bag had an error, it can only be closed");
    }
  }

  void check_message(const BagMessage& message) const {
    const auto refuse = [&](const std::string& what) {
      throw BagError(BagFault::kUsage, folder_, what);
    };
    if (message.topic >= metadata_.topics.size()) {
      refuse("topic " + std::to_string(message.topic) + " was never added");
    }
    const std::string& name = metadata_.topics[message.topic].topic.name;
    if (message.log_time < 0 || message.publish_time < 0) {
      refuse(name + ": a message before 1970");
    }
    if (message.data.size() > kMaxMessageSize) {
      refuse(name + ": a message of " + std::to_string(message.data.size()) + " bytes, more than " +
             std::to_string(kMaxMessageSize));
    }
  }

  /// Remembers that an error ended the recording.
  template <class Call>
  void guarded(Call call) {
    try {
      call();
    } catch (...) {
      failed_ = true;
      throw;
    }
  }

  [[nodiscard]] bool is_full(const BagFile& current, const BagMessage& message) const {
    if (options_.max_file_size > 0 &&
        file_->size() + message.data.size() > options_.max_file_size) {
      return true;
    }
    return options_.max_file_duration.count() > 0 &&
           message.log_time - current.starting_time >= options_.max_file_duration.count();
  }

  void count(const BagMessage& message) {
    ++metadata_.topics[message.topic].messages;
    BagFile& file = metadata_.files.back();
    include(file.messages++ == 0, message.log_time, file.starting_time, file.duration);
    include(metadata_.messages++ == 0, message.log_time, metadata_.starting_time,
            metadata_.duration);
  }

  static void include(bool is_first, std::int64_t time, std::int64_t& start,
                      std::int64_t& duration) {
    const std::int64_t end = is_first ? time : std::max(start + duration, time);
    start = is_first ? time : std::min(start, time);
    duration = end - start;
  }

  void begin_file() {
    const bool is_sqlite = options_.storage == Storage::kSqlite;
    const std::string name = folder_.filename().string() + "_" +
                             std::to_string(metadata_.files.size()) +
                             (is_sqlite ? ".db3" : ".mcap");
    file_ = is_sqlite ? make_sqlite_writer(folder_ / name, options_)
                      : make_mcap_writer(folder_ / name, options_);
    metadata_.files.push_back({.path = name});
    for (const TopicCount& each : metadata_.topics) {
      file_->add_topic(each.topic);
    }
    last_flush_ = Clock::now();
  }

  void end_file() {
    // Its destructor closes what `close` could not.
    const std::unique_ptr<FileWriter> file = std::move(file_);
    file->close(metadata_to_yaml(metadata_));
    if (options_.compression == Compression::kFile) {
      wait_for_compression();
      const fs::path path = folder_ / metadata_.files.back().path;
      compressing_ = metadata_.files.size() - 1;
      compression_ = std::async(std::launch::async, [path, level = options_.compression_level] {
        compress_file(path, path.string() + ".zstd", level);
        fs::remove(path);
      });
    }
  }

  /// Until it is compressed, a file is listed as it is, and stays so after an error.
  void wait_for_compression() {
    if (!compression_.valid()) {
      return;
    }
    BagFile& file = metadata_.files[compressing_];
    try {
      compression_.get();
      file.path += ".zstd";
    } catch (...) {
      std::error_code ignored;
      fs::remove(folder_ / (file.path + ".zstd"), ignored);
      throw;
    }
  }

  void write_metadata() {
    const fs::path path = folder_ / kMetadataFile;
    try {
      replace_file(path, metadata_to_yaml(metadata_), Survives::kKill);
    } catch (const std::system_error& error) {
      throw_system_error(error.code().value(), path, "cannot be written");
    }
  }

  /// What is on the disk becomes a bag as far as there is space; the error was told already.
  void close_after_error() {
    try {
      wait_for_compression();
    } catch (const std::exception&) {
      // The file stays as it was before.
    }
    try {
      if (file_) {
        file_->close(metadata_to_yaml(metadata_));
      }
    } catch (const std::exception&) {
      // It is read without its end.
    }
    file_.reset();
    try {
      std::vector<BagError> faults;
      const Compression compression = metadata_.compression;
      metadata_ = metadata_of_files(files_in(folder_), compression, faults);
      write_metadata();
    } catch (const std::exception&) {
      // Readers do without metadata.
    }
  }

  fs::path folder_;
  BagWriterOptions options_;
  BagMetadata metadata_;
  std::unordered_map<std::string, TopicIndex> indexes_;
  std::unique_ptr<FileWriter> file_;
  std::optional<ZstdCompressor> compressor_;
  Bytes packed_;
  Clock::time_point last_flush_;
  std::future<void> compression_;
  std::size_t compressing_ = 0;  ///< the file that `compression_` is about
  bool failed_ = false;
  bool closed_ = false;
};

BagWriter::BagWriter(fs::path folder, const BagWriterOptions& options)
    : implementation_(std::make_unique<Implementation>(std::move(folder), options)) {}
BagWriter::~BagWriter() = default;
TopicIndex BagWriter::add_topic(const BagTopic& topic) {
  return implementation_->add_topic(topic);
}
void BagWriter::write(const BagMessage& message) {
  implementation_->write(message);
}
void BagWriter::flush() {
  implementation_->flush();
}
void BagWriter::flush_if_due() {
  implementation_->flush_if_due();
}
void BagWriter::split() {
  implementation_->split();
}
void BagWriter::close() {
  implementation_->close();
}
const BagMetadata& BagWriter::metadata() const noexcept {
  return implementation_->metadata();
}
const fs::path& BagWriter::folder() const noexcept {
  return implementation_->folder();
}

}  // namespace pipescout::bags
