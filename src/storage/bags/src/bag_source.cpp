// SPDX-License-Identifier: Apache-2.0
#include "bag_source.hpp"

#include <algorithm>
#include <cerrno>
#include <charconv>
#include <cstdlib>
#include <limits>
#include <system_error>
#include <tuple>

#include "compression.hpp"
#include "file_access.hpp"
#include "mcap_records.hpp"
#include "pipescout/bags/bag_metadata.hpp"
#include "pipescout/bags/topic_choice.hpp"

namespace pipescout::bags {
namespace {

namespace fs = std::filesystem;

/// More files than that are not kept open at once.
constexpr std::size_t kFilesKeptOpen = 8;

bool is_compressed(const fs::path& path) {
  return path.extension() == ".zstd";
}

/// The number behind the last '_': name_12.db3.
std::uint64_t number_of(const fs::path& path) {
  const std::string name = path.filename().string();
  const std::size_t start = name.rfind('_');
  std::uint64_t number = 0;
  if (start != std::string::npos) {
    std::from_chars(name.data() + start + 1, name.data() + name.size(), number);
  }
  return number;
}

}  // namespace

std::optional<Storage> storage_by_name(const fs::path& path) {
  const fs::path name = is_compressed(path) ? path.stem() : path.filename();
  if (name.extension() == ".db3") {
    return Storage::kSqlite;
  }
  if (name.extension() == ".mcap") {
    return Storage::kMcap;
  }
  if (name.extension() == ".bag") {
    return Storage::kRos1;
  }
  return std::nullopt;
}

std::vector<fs::path> files_in(const fs::path& folder) {
  std::vector<fs::path> files;
  std::error_code error;
  for (const auto& entry : fs::directory_iterator(folder, error)) {
    const auto storage = storage_by_name(entry.path());
    if (entry.is_regular_file() && storage && storage != Storage::kRos1) {
      files.push_back(entry.path());
    }
  }
  if (error) {
    throw_system_error(error.value(), folder, "cannot be listed");
  }
  std::sort(files.begin(), files.end(), [](const fs::path& a, const fs::path& b) {
    return std::pair(number_of(a), a) < std::pair(number_of(b), b);
  });
  return files;
}

bool is_zstd(ByteView bytes) noexcept {
  return text_of(bytes).starts_with("\x28\xB5\x2F\xFD");
}

std::string read_text(const fs::path& path) {
  const InputFile file(path);
  constexpr std::uint64_t kMaxSize = std::uint64_t{64} * 1024 * 1024;
  if (file.size() > kMaxSize) {
    throw BagError(BagFault::kMalformed, path, "is larger than 64 MiB");
  }
  Bytes content;
  file.read(0, file.size(), content);
  return std::string(text_of(content));
}

std::unique_ptr<FileReader> open_file(const fs::path& path) {
  Bytes start;
  constexpr std::uint64_t kStart = 16;
  InputFile(path).read(0, kStart, start);
  const std::string_view text = text_of(start);
  if (text.starts_with("SQLite format 3")) {
    return open_sqlite(path);
  }
  if (text.starts_with(text_of(std::as_bytes(std::span(mcap::kMagic))))) {
    return open_mcap(path);
  }
  if (text.starts_with("#ROSBAG V")) {
    return open_ros1_bag(path);
  }
  // It may be damaged at its very start: its name says what it should be.
  const auto storage = storage_by_name(path);
  if (!storage) {
    throw BagError(BagFault::kMalformed, path, "is neither SQLite nor MCAP nor a bag of ROS 1");
  }
  switch (*storage) {
    case Storage::kSqlite:
      return open_sqlite(path);
    case Storage::kMcap:
      return open_mcap(path);
    case Storage::kRos1:
      break;
  }
  return open_ros1_bag(path);
}

OpenedFile::OpenedFile(const fs::path& path) {
  if (!is_compressed(path)) {
    reader_ = open_file(path);
    return;
  }
  std::string name = (fs::temp_directory_path() / "pipescout_bag_XXXXXX").string();
  if (::mkdtemp(name.data()) == nullptr) {
    throw_system_error(errno, name, "cannot be made");
  }
  unpacked_folder_ = name;
  try {
    const fs::path unpacked = unpacked_folder_ / path.stem();
    if (!unpack_file(path, unpacked)) {
      fault_ = BagError(BagFault::kIncomplete, path, "the compressed file is cut");
    }
    reader_ = open_file(unpacked);
  } catch (...) {
    std::error_code ignored;
    fs::remove_all(unpacked_folder_, ignored);
    throw;
  }
}

OpenedFile::~OpenedFile() {
  reader_.reset();
  if (!unpacked_folder_.empty()) {
    std::error_code ignored;
    fs::remove_all(unpacked_folder_, ignored);
  }
}

std::vector<BagError> OpenedFile::faults() const {
  std::vector<BagError> result;
  if (fault_) {
    result.push_back(*fault_);
  }
  result.insert(result.end(), reader_->faults().begin(), reader_->faults().end());
  return result;
}

BagSource::BagSource(fs::path bag) : path_(std::move(bag)) {
  find_files();
  read_all_topics();
  if (!has_metadata_file_) {
    describe_files();
  }
  const bool all_broken =
      std::all_of(files_.begin(), files_.end(), [](const File& file) { return file.is_broken; });
  if (all_broken && !faults_.empty()) {
    throw faults_.front();
  }
  set_filter({});
}

void BagSource::find_files() {
  std::error_code error;
  const fs::file_status status = fs::status(path_, error);
  if (!fs::exists(status)) {
    throw BagError(BagFault::kNotFound, path_, "there is no such file or folder");
  }
  const bool is_folder = fs::is_directory(status);
  const fs::path folder = is_folder ? path_ : fs::absolute(path_).parent_path();
  const fs::path metadata_file = folder / kMetadataFile;
  if (fs::exists(metadata_file, error)) {
    try {
      metadata_ = metadata_from_yaml(read_text(metadata_file), metadata_file);
      has_metadata_file_ = true;
    } catch (const BagError& fault) {
      if (is_folder && fault.fault() == BagFault::kUnsupported) {
        throw;
      }
      if (is_folder) {
        faults_.push_back(fault);
      }
    }
  }
  if (is_folder && has_metadata_file_) {
    for (const BagFile& each : metadata_.files) {
      File& file = files_.emplace_back();
      file.path = folder / each.path;
      // Until version 3 the folder's name stood in front.
      if (!fs::exists(file.path, error) &&
          fs::exists(folder / fs::path(each.path).filename(), error)) {
        file.path = folder / fs::path(each.path).filename();
      }
      if (each.messages > 0) {
        file.times.emplace(each.starting_time, each.starting_time + each.duration);
      }
    }
  } else if (is_folder) {
    for (fs::path& path : files_in(folder)) {
      files_.emplace_back().path = std::move(path);
    }
    if (files_.empty()) {
      throw BagError(BagFault::kNotFound, path_, "holds no metadata.yaml, no .db3 and no .mcap");
    }
  } else {
    // One file of a bag: the metadata still tells whether its messages are compressed.
    files_.emplace_back().path = path_;
    const Compression compression = metadata_.compression;
    const bool is_listed = std::any_of(
        metadata_.files.begin(), metadata_.files.end(),
        [&](const BagFile& each) { return fs::path(each.path).filename() == path_.filename(); });
    metadata_ = {};
    metadata_.compression = is_listed ? compression : Compression::kNone;
    has_metadata_file_ = false;
  }
}

void BagSource::read_all_topics() {
  if (has_metadata_file_) {
    for (const TopicCount& each : metadata_.topics) {
      index_of(each.topic);
    }
  }
  for (File& file : files_) {
    // SQLite knows no more of its topics than the metadata says; unpacking takes long.
    if (has_metadata_file_ && is_compressed(file.path) && metadata_.storage == Storage::kSqlite) {
      continue;
    }
    if (open(file) && files_.size() > kFilesKeptOpen) {
      close(file);
    }
  }
}

void BagSource::describe_files() {
  MetadataSum sum;
  for (File& file : files_) {
    if (file.is_broken || !open(file)) {
      continue;
    }
    const FileContent& content = file.opened->reader().content();
    sum.add(file.path, content);
    if (content.messages > 0) {
      file.times.emplace(content.start, content.end);
    }
    if (files_.size() > kFilesKeptOpen) {
      close(file);
    }
  }
  const Compression compression = metadata_.compression;
  metadata_ = sum.metadata();
  metadata_.compression = compression;
}

std::vector<fs::path> BagSource::files() const {
  std::vector<fs::path> paths;
  for (const File& file : files_) {
    paths.push_back(file.path);
  }
  return paths;
}

bool BagSource::open(File& file) {
  if (file.opened || file.is_broken) {
    return !file.is_broken;
  }
  try {
    file.opened = std::make_unique<OpenedFile>(file.path);
  } catch (const BagError& error) {
    faults_.push_back(error);
    file.is_broken = true;
    return false;
  }
  file.topics.clear();
  for (const BagTopic& topic : file.opened->reader().topics()) {
    file.topics.push_back(index_of(topic));
  }
  has_checksums_ = has_checksums_ && file.opened->reader().has_checksums();
  return true;
}

void BagSource::close(File& file) {
  take_faults(file);
  file.opened.reset();
  file.faults_told = 0;
}

void BagSource::take_faults(File& file) {
  const auto faults = file.opened->faults();
  for (; file.faults_told < faults.size(); ++file.faults_told) {
    const BagError& fault = faults[file.faults_told];
    const bool known = std::any_of(faults_.begin(), faults_.end(), [&](const BagError& other) {
      return std::string_view(other.what()) == fault.what();
    });
    if (!known) {
      faults_.push_back(fault);
    }
  }
}

TopicIndex BagSource::index_of(const BagTopic& topic) {
  for (std::size_t k = 0; k < topics_.size(); ++k) {
    BagTopic& known = topics_[k];
    if (known.name == topic.name && known.type == topic.type &&
        known.serialization_format == topic.serialization_format) {
      if (known.schema_text.empty()) {
        known.schema_encoding = topic.schema_encoding;
        known.schema_text = topic.schema_text;
      }
      if (known.offered_qos_profiles.empty()) {
        known.offered_qos_profiles = topic.offered_qos_profiles;
      }
      return static_cast<TopicIndex>(k);
    }
  }
  topics_.push_back(topic);
  topics_.back().offered_qos_profiles = humble_qos_profiles(topic.offered_qos_profiles);
  return static_cast<TopicIndex>(topics_.size() - 1);
}

void BagSource::set_filter(BagFilter filter) {
  filter_ = std::move(filter);
  begin(filter_.start);
}

void BagSource::seek(std::int64_t time) {
  begin(std::max(time, filter_.start));
}

void BagSource::begin(std::int64_t start) {
  start_ = start;
  active_ = {};
  last_.reset();
  pending_.clear();
  next_pending_ = 0;
  for (std::size_t k = 0; k < files_.size(); ++k) {
    const auto& times = files_[k].times;
    if (!files_[k].is_broken &&
        (!times || (times->first <= filter_.end && times->second >= start_))) {
      pending_.push_back(k);
    }
  }
  // A file of unknown times is begun with the one before it.
  std::vector<std::int64_t> starts(files_.size());
  std::int64_t last = std::numeric_limits<std::int64_t>::min();
  for (std::size_t k = 0; k < files_.size(); ++k) {
    last = files_[k].times ? files_[k].times->first : last;
    starts[k] = last;
  }
  std::stable_sort(pending_.begin(), pending_.end(),
                   [&](std::size_t a, std::size_t b) { return starts[a] < starts[b]; });
}

void BagSource::start(std::size_t index) {
  File& file = files_[index];
  if (!open(file)) {
    return;
  }
  std::vector<bool> wanted;
  for (const TopicIndex topic : file.topics) {
    wanted.push_back(!filter_.topics || std::find(filter_.topics->begin(), filter_.topics->end(),
                                                  topics_[topic].name) != filter_.topics->end());
  }
  file.opened->reader().select(wanted, start_, filter_.end);
  advance(index);
}

void BagSource::advance(std::size_t index) {
  File& file = files_[index];
  if (file.opened->reader().next(file.message)) {
    file.message.topic = file.topics[file.message.topic];
    active_.push({file.message.log_time, index});
    return;
  }
  take_faults(file);
  if (files_.size() > kFilesKeptOpen || is_compressed(file.path)) {
    close(file);
  }
}

bool BagSource::next(BagMessage& message) {
  for (;;) {
    if (last_) {
      advance(*std::exchange(last_, std::nullopt));
    }
    while (next_pending_ < pending_.size()) {
      const std::size_t file = pending_[next_pending_];
      const auto& times = files_[file].times;
      if (!active_.empty() && times && times->first > active_.top().log_time) {
        break;
      }
      ++next_pending_;
      start(file);
    }
    if (active_.empty()) {
      return false;
    }
    last_ = active_.top().file;
    active_.pop();
    message = files_[*last_].message;
    if (unpack_message(files_[*last_], message)) {
      return true;
    }
  }
}

bool BagSource::unpack_message(const File& file, BagMessage& message) {
  const bool compressed =
      is_zstd(message.data) && topics_[message.topic].serialization_format == "cdr";
  if (metadata_.compression != Compression::kMessage && (has_metadata_file_ || !compressed)) {
    return true;
  }
  if (compressed &&
      unpack(Codec::kZstd, message.data, kMaxMessageSize, unpacked_) == Unpacked::kWhole) {
    message.data = unpacked_;
    return true;
  }
  faults_.emplace_back(BagFault::kMalformed, file.path,
                       topics_[message.topic].name + " at " + std::to_string(message.log_time) +
                           " ns: the message is no zstd frame");
  return false;
}

void MetadataSum::add(const fs::path& path, const FileContent& content) {
  if (metadata_.files.empty()) {
    metadata_.storage = storage_by_name(path).value_or(Storage::kMcap);
  }
  metadata_.files.push_back({.path = path.filename().string(),
                             .starting_time = content.start,
                             .duration = content.end - content.start,
                             .messages = content.messages});
  for (std::size_t k = 0; k < content.topics.size(); ++k) {
    const auto known =
        std::find_if(metadata_.topics.begin(), metadata_.topics.end(), [&](const TopicCount& each) {
          return each.topic.name == content.topics[k].name &&
                 each.topic.type == content.topics[k].type;
        });
    if (known == metadata_.topics.end()) {
      metadata_.topics.push_back({content.topics[k], content.counts[k]});
    } else {
      known->messages += content.counts[k];
    }
  }
  if (content.messages > 0) {
    const bool first = metadata_.messages == 0;
    const std::int64_t end =
        first ? content.end : std::max(metadata_.starting_time + metadata_.duration, content.end);
    metadata_.starting_time =
        first ? content.start : std::min(metadata_.starting_time, content.start);
    metadata_.duration = end - metadata_.starting_time;
    metadata_.messages += content.messages;
  }
}

BagMetadata metadata_of_files(const std::vector<fs::path>& files, Compression compression,
                              std::vector<BagError>& faults) {
  MetadataSum sum;
  for (const fs::path& path : files) {
    try {
      const OpenedFile file(path);
      sum.add(path, file.reader().content());
      const auto found = file.faults();
      faults.insert(faults.end(), found.begin(), found.end());
    } catch (const BagError& error) {
      faults.push_back(error);
    }
  }
  BagMetadata metadata = sum.metadata();
  metadata.compression = compression;
  return metadata;
}

}  // namespace pipescout::bags
