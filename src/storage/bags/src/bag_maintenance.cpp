// SPDX-License-Identifier: Apache-2.0
#include "pipescout/bags/bag_maintenance.hpp"

#include <algorithm>
#include <limits>
#include <set>
#include <system_error>
#include <utility>

#include "bag_source.hpp"
#include "file_access.hpp"
#include "pipescout/bags/bag_error.hpp"
#include "pipescout/bags/bag_metadata.hpp"
#include "pipescout/bags/topic_choice.hpp"
#include "pipescout/files/whole_file.hpp"

namespace pipescout::bags {
namespace {

namespace fs = std::filesystem;

/// What reading all of a bag gave.
struct Census {
  std::vector<std::uint64_t> counts;
  std::uint64_t messages = 0;
  std::int64_t start = std::numeric_limits<std::int64_t>::max();
  std::int64_t end = 0;
  std::uint64_t zero_times = 0;
};

Census read_all(BagSource& source) {
  Census census;
  BagMessage message;
  while (source.next(message)) {
    census.counts.resize(source.topics().size(), 0);
    ++census.counts[message.topic];
    ++census.messages;
    census.start = std::min(census.start, message.log_time);
    census.end = std::max(census.end, message.log_time);
    census.zero_times += message.log_time == 0 ? 1U : 0U;
  }
  census.counts.resize(source.topics().size(), 0);
  return census;
}

void compare_topics(const BagSource& source, const Census& census, BagReport& report) {
  const BagMetadata& metadata = source.metadata();
  const auto& topics = source.topics();
  for (std::size_t k = 0; k < topics.size(); ++k) {
    const auto said =
        std::find_if(metadata.topics.begin(), metadata.topics.end(), [&](const TopicCount& each) {
          return each.topic.name == topics[k].name && each.topic.type == topics[k].type;
        });
    const std::string name = source.path().string() + ": " + topics[k].name;
    if (said == metadata.topics.end()) {
      const auto other =
          std::find_if(metadata.topics.begin(), metadata.topics.end(),
                       [&](const TopicCount& each) { return each.topic.name == topics[k].name; });
      if (other != metadata.topics.end()) {
        report.faults.push_back(name + ": the files say " + topics[k].type + ", the metadata " +
                                other->topic.type);
      } else if (census.counts[k] > 0) {
        report.faults.push_back(name + ": is not in the metadata");
      }
    } else if (said->messages != census.counts[k]) {
      report.faults.push_back(name + ": " + std::to_string(said->messages) +
                              " messages by the metadata, " + std::to_string(census.counts[k]) +
                              " can be read");
    }
  }
}

void compare_with_metadata(const BagSource& source, const Census& census, BagReport& report) {
  const BagMetadata& metadata = source.metadata();
  const std::string name = source.path().string();
  compare_topics(source, census, report);
  if (metadata.messages != census.messages) {
    report.faults.push_back(name + ": " + std::to_string(metadata.messages) +
                            " messages by the metadata, " + std::to_string(census.messages) +
                            " can be read");
  } else if (census.messages > 0 && (metadata.starting_time != census.start ||
                                     metadata.duration != census.end - census.start)) {
    report.faults.push_back(name +
                            ": start or duration in the metadata are not those of the files");
  }
  const auto listed = source.files();
  for (const fs::path& file : files_in(source.path())) {
    const bool known = std::any_of(listed.begin(), listed.end(), [&](const fs::path& each) {
      return each.filename() == file.filename();
    });
    if (!known) {
      report.faults.push_back(file.string() + ": is not in the metadata");
    }
  }
}

/// What each file says of itself, against what was read of all.
void compare_with_files(const BagSource& source, const Census& census, BagReport& report) {
  std::uint64_t said = 0;
  std::vector<BagError> faults;
  for (const fs::path& path : source.files()) {
    try {
      said += OpenedFile(path).reader().content().messages;
    } catch (const BagError&) {
      return;  // told already
    }
  }
  if (said != census.messages) {
    report.faults.push_back(source.path().string() + ": " + std::to_string(said) +
                            " messages by the files' own counts, " +
                            std::to_string(census.messages) + " can be read");
  }
}

}  // namespace

BagReport check_bag(const fs::path& bag) {
  BagReport report;
  try {
    BagSource source(bag);
    const Census census = read_all(source);
    report.messages = census.messages;
    for (const BagError& fault : source.faults()) {
      report.faults.emplace_back(fault.what());
    }
    if (source.has_metadata_file()) {
      compare_with_metadata(source, census, report);
    } else if (fs::is_directory(bag)) {
      report.notes.push_back(bag.string() + ": has no metadata.yaml; `reindex` writes it");
    }
    if (report.faults.empty()) {
      compare_with_files(source, census, report);
    }
    if (!source.has_checksums()) {
      report.notes.push_back(bag.string() +
                             ": has no checksums: changed bytes within messages are not seen");
    }
    if (census.zero_times > 0) {
      report.notes.push_back(bag.string() + ": " + std::to_string(census.zero_times) +
                             " messages have the log time 0");
    }
  } catch (const BagError& error) {
    report.faults.emplace_back(error.what());
  }
  return report;
}

BagMetadata reindex_bag(const fs::path& folder) {
  const auto files = files_in(folder);
  if (files.empty()) {
    throw BagError(BagFault::kNotFound, folder, "holds no .db3 and no .mcap");
  }
  std::set<Storage> storages;
  Compression compression = Compression::kNone;
  for (const fs::path& file : files) {
    storages.insert(storage_by_name(file).value_or(Storage::kMcap));
    if (file.extension() == ".zstd") {
      compression = Compression::kFile;
    }
  }
  if (storages.size() > 1) {
    throw BagError(BagFault::kUnsupported, folder, "holds .db3 and .mcap, a bag has one of them");
  }
  for (const fs::path& path : files) {
    // No CDR begins as zstd does.
    const OpenedFile file(path);
    file.reader().select(std::vector<bool>(file.reader().topics().size(), true),
                         std::numeric_limits<std::int64_t>::min(),
                         std::numeric_limits<std::int64_t>::max());
    BagMessage message;
    if (file.reader().next(message)) {
      if (is_zstd(message.data)) {
        compression = Compression::kMessage;
      }
      break;
    }
  }
  std::vector<BagError> faults;
  BagMetadata metadata = metadata_of_files(files, compression, faults);
  if (!faults.empty()) {
    throw faults.front();
  }
  const fs::path path = folder / kMetadataFile;
  try {
    replace_file(path, metadata_to_yaml(metadata));
  } catch (const std::system_error& error) {
    throw_system_error(error.code().value(), path, "cannot be written");
  }
  return metadata;
}

BagReport recover_bag(const fs::path& bag, const fs::path& new_folder,
                      const BagWriterOptions& options) {
  BagReport report;
  BagSource source(bag);
  BagWriter writer(new_folder, options);
  std::vector<std::optional<TopicIndex>> topics;
  const auto index_of = [&](TopicIndex topic) {
    topics.resize(source.topics().size());
    if (!topics[topic]) {
      topics[topic] = writer.add_topic(source.topics()[topic]);
    }
    return *topics[topic];
  };
  for (TopicIndex topic = 0; topic < source.topics().size(); ++topic) {
    try {
      (void)index_of(topic);
    } catch (const BagError& error) {
      report.faults.emplace_back(error.what());  // no name, or of two types
    }
  }
  BagMessage message;
  std::uint64_t refused = 0;
  while (source.next(message)) {
    topics.resize(source.topics().size());
    if (!topics[message.topic] || message.log_time < 0) {
      ++refused;
      continue;
    }
    message.topic = *topics[message.topic];
    message.publish_time = std::max<std::int64_t>(message.publish_time, 0);
    writer.write(message);
  }
  writer.close();
  report.messages = writer.metadata().messages;
  if (refused > 0) {
    report.faults.push_back(bag.string() + ": " + std::to_string(refused) +
                            " messages of times before 1970 or of topics that no bag can hold");
  }
  for (const BagError& fault : source.faults()) {
    report.faults.emplace_back(fault.what());
  }
  return report;
}

}  // namespace pipescout::bags
