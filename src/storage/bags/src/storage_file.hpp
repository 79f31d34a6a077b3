// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "pipescout/bags/bag_error.hpp"
#include "pipescout/bags/bag_types.hpp"
#include "pipescout/bags/bag_writer.hpp"

/// What BagWriter and BagReader ask of one file, whatever its format.
namespace pipescout::bags {

/// Largest message, bytes: what SQLite can hold, less some.
inline constexpr std::uint64_t kMaxMessageSize = 1'000'000'000;

/// One new file of a bag. After an error only `close` may be called.
class FileWriter {
 public:
  FileWriter() = default;
  virtual ~FileWriter() = default;
  FileWriter(const FileWriter&) = delete;
  FileWriter& operator=(const FileWriter&) = delete;

  /// Topics come in the order of their indexes.
  virtual void add_topic(const BagTopic& topic) = 0;
  virtual void write(const BagMessage& message) = 0;
  /// Size of the file if it ended now, about.
  [[nodiscard]] virtual std::uint64_t size() const = 0;
  /// After it a kill costs nothing that was written before.
  virtual void flush() = 0;
  /// Completes the file. Where that fails, the file is left so that readers find what was flushed.
  /// `metadata`: the whole bag's up to now, as YAML.
  virtual void close(const std::string& metadata) = 0;
};

/// What one file holds.
struct FileContent {
  std::vector<BagTopic> topics;
  /// By topic.
  std::vector<std::uint64_t> counts;
  std::uint64_t messages = 0;
  std::int64_t start = 0;  ///< ns; 0 without messages
  std::int64_t end = 0;
};

/// One file of a bag that is read.
class FileReader {
 public:
  FileReader() = default;
  virtual ~FileReader() = default;
  FileReader(const FileReader&) = delete;
  FileReader& operator=(const FileReader&) = delete;

  /// Only the topics; quick.
  [[nodiscard]] virtual const std::vector<BagTopic>& topics() const = 0;
  /// May read all of the file.
  [[nodiscard]] virtual const FileContent& content() = 0;
  /// Begins anew with the wanted topics and times.
  virtual void select(const std::vector<bool>& wanted, std::int64_t start, std::int64_t end) = 0;
  /// The next message; false behind the last one. What cannot be read goes to `faults`.
  virtual bool next(BagMessage& message) = 0;
  /// What was found to be wrong up to now.
  [[nodiscard]] const std::vector<BagError>& faults() const noexcept { return faults_; }
  /// Whether the content has checksums.
  [[nodiscard]] virtual bool has_checksums() const noexcept = 0;

 protected:
  void add_fault(BagError fault) {
    // A file of rubbish could have any number of them.
    constexpr std::size_t kFaultsKept = 100;
    if (faults_.size() < kFaultsKept) {
      faults_.push_back(std::move(fault));
    }
  }

 private:
  std::vector<BagError> faults_;
};

[[nodiscard]] std::unique_ptr<FileWriter> make_mcap_writer(const std::filesystem::path& path,
                                                           const BagWriterOptions& options);
[[nodiscard]] std::unique_ptr<FileWriter> make_sqlite_writer(const std::filesystem::path& path,
                                                             const BagWriterOptions& options);

/// Open by the format that the first bytes say. Throw BagError when nothing can be read.
[[nodiscard]] std::unique_ptr<FileReader> open_file(const std::filesystem::path& path);
[[nodiscard]] std::unique_ptr<FileReader> open_mcap(const std::filesystem::path& path);
[[nodiscard]] std::unique_ptr<FileReader> open_sqlite(const std::filesystem::path& path);
[[nodiscard]] std::unique_ptr<FileReader> open_ros1_bag(const std::filesystem::path& path);

}  // namespace pipescout::bags
