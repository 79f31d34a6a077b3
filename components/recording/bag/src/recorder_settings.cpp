// SPDX-License-Identifier: Apache-2.0
#include "recorder_settings.hpp"

#include <algorithm>
#include <array>
#include <chrono>
#include <ctime>
#include <stdexcept>
#include <utility>
#include <vector>

#include "pipescout/bag_topics/qos_profiles.hpp"

namespace pipescout {
namespace {

constexpr std::int64_t kLargest = std::int64_t{1} << 60;

/// "rosbag2_2026_11_25-17_45_12", as rosbag2 names a bag that nobody named.
std::string default_folder() {
  const std::time_t now = std::chrono::system_clock::to_time_t(std::chrono::system_clock::now());
  std::tm local{};
  localtime_r(&now, &local);
  std::array<char, 64> name{};
  std::strftime(name.data(), name.size(), "rosbag2_%Y_%m_%d-%H_%M_%S", &local);
  return name.data();
}

std::optional<std::regex> optional_regex(const Parameter<std::string>& parameter) {
  const std::string text = parameter.get();
  if (text.empty()) {
    return std::nullopt;
  }
  try {
    return std::regex(text);
  } catch (const std::regex_error& error) {
    throw std::invalid_argument(parameter.name() + " = '" + text +
                                "' is no regular expression: " + error.what());
  }
}

template <class Value>
Value one_of(const Parameter<std::string>& parameter,
             const std::vector<std::pair<std::string, Value>>& values) {
  const std::string text = parameter.get();
  std::string names;
  for (const auto& [name, value] : values) {
    if (name == text) {
      return value;
    }
    names += (names.empty() ? "" : ", ") + name;
  }
  throw std::invalid_argument(parameter.name() + " = '" + text + "' is none of " + names);
}

}  // namespace

RecorderSettings::RecorderSettings(Parameters& parameters) {
  const auto size = [](std::string description) {
    return ParameterDescriptor{.description = std::move(description),
                               .integer_range = IntegerRange{0, kLargest}};
  };
  output_ = parameters.declare<std::string>(
      "output", "",
      {.description = "folder of the bag, made anew; empty: rosbag2_<local time> where the "
                      "process runs"});
  storage_ =
      parameters.declare<std::string>("storage", "sqlite3", {.description = "sqlite3 or mcap"});
  all_ = parameters.declare<bool>(
      "all", false,
      {.description = "record all topics in the namespace of the node and in those around it"});
  topics_ = parameters.declare<std::vector<std::string>>("topics", {},
                                                         {.description = "topics to record"});
  regex_ = parameters.declare<std::string>(
      "regex", "",
      {.description = "record the topics in whose names it is found, in place of all"});
  exclude_ = parameters.declare<std::string>(
      "exclude", "", {.description = "do not record the topics in whose names it is found"});
  include_hidden_ =
      parameters.declare<bool>("include_hidden_topics", false,
                               {.description = "topics with a part that begins with '_' too"});
  max_bag_size_ = parameters.declare<std::int64_t>(
      "max_bag_size", 0, size("bytes of a file before another is begun; 0: no limit"));
  max_bag_duration_ = parameters.declare<std::int64_t>(
      "max_bag_duration", 0, size("s of a file before another is begun; 0: no limit"));
  max_cache_size_ = parameters.declare<std::int64_t>(
      "max_cache_size", 100 * 1024 * 1024,
      size("bytes of messages that wait to be written; in snapshot mode those that are kept"));
  compression_mode_ = parameters.declare<std::string>(
      "compression_mode", "none", {.description = "none, file or message, with zstd"});
  chunk_compression_ = parameters.declare<std::string>(
      "chunk_compression", "none", {.description = "of MCAP's chunks: none, lz4 or zstd"});
  qos_overrides_ = parameters.declare<std::string>(
      "qos_overrides", "",
      {.description = "file with QoS profiles by topic, in place of what goes with the "
                      "publishers"});
  snapshot_mode_ = parameters.declare<bool>(
      "snapshot_mode", false,
      {.description = "keep the last max_cache_size bytes, and write them when the service "
                      "snapshot asks for it"});
  repeatable_ = parameters.declare<bool>(
      "repeatable", false,
      {.description = "publishers wait while the cache is full, and nothing is written because "
                      "of the time: the same messages give the same bytes. For simulated "
                      "missions"});
  next_free_name_ = parameters.declare<bool>(
      "next_free_name", false,
      {.description = "when the folder output is there, record into output_2, output_3, ...: a "
                      "recorder that is restarted goes on in another bag"});
  thinned_topics_ = parameters.declare<std::vector<std::string>>(
      "thinned_topics", {}, {.description = "topics of which not all messages are recorded"});
  thinned_periods_ = parameters.declare<std::vector<double>>(
      "thinned_periods", {},
      {.description = "s, for each of thinned_topics: the least from one recorded message to the "
                      "next, by their stamps"});
  source_ = parameters.declare<std::string>(
      "source", "",
      {.description = "node whose completion on mission/status makes the recording complete, "
                      "relative to the namespace; empty: it ends with the process"});
  settle_time_ = parameters.declare<double>(
      "settle_time", 0.5,
      {.description = "s of the wall clock without a message, after the source is complete, "
                      "until the recording is",
       .floating_point_range = FloatingPointRange{0.01, 3600.0}});
  silent_after_ = parameters.declare<double>(
      "silent_after", 30.0,
      {.description = "s of the wall clock without a message after which a recording whose "
                      "source is not complete fails; 0: no limit",
       .floating_point_range = FloatingPointRange{0.0, 86400.0}});
  use_sim_time_ = parameters.handle<bool>("use_sim_time");
}

void RecorderSettings::read(const NodeName& node) {
  writer = {};
  writer.storage = one_of<bags::Storage>(
      storage_, {{"sqlite3", bags::Storage::kSqlite}, {"mcap", bags::Storage::kMcap}});
  writer.max_file_size = static_cast<std::uint64_t>(max_bag_size_.get());
  constexpr std::int64_t kLongest = Duration::max().count() / 1'000'000'000;
  writer.max_file_duration = std::chrono::seconds(std::min(max_bag_duration_.get(), kLongest));
  writer.compression =
      one_of<bags::Compression>(compression_mode_, {{"none", bags::Compression::kNone},
                                                    {"message", bags::Compression::kMessage},
                                                    {"file", bags::Compression::kFile}});
  writer.chunk_compression =
      one_of<bags::ChunkCompression>(chunk_compression_, {{"none", bags::ChunkCompression::kNone},
                                                          {"lz4", bags::ChunkCompression::kLz4},
                                                          {"zstd", bags::ChunkCompression::kZstd}});
  writer.flush_by_time = !repeatable_.get();
  queue = {.limit = static_cast<std::uint64_t>(max_cache_size_.get()),
           .snapshot = snapshot_mode_.get(),
           .repeatable = repeatable_.get()};
  selection = {.all = all_.get(),
               .ns = node.ns,
               .topics = {},
               .regex = optional_regex(regex_),
               .exclude = optional_regex(exclude_),
               .hidden = include_hidden_.get()};
  for (const auto& topic : topics_.get()) {
    selection.topics.insert(expand_topic_name(topic, node));
  }
  if (!selection.all && selection.topics.empty() && !selection.regex) {
    throw std::invalid_argument("no topic is to be recorded: set all, topics or regex");
  }
  read_thinning(node);
  const std::string name = source_.get();
  source = name.empty() ? "" : expand_topic_name(name, node);
  settle = from_seconds(settle_time_.get());
  silence = from_seconds(silent_after_.get());
  qos_overrides.clear();
  if (const auto path = qos_overrides_.get(); !path.empty()) {
    for (const auto& [topic, qos] : read_qos_overrides(path)) {
      qos_overrides[expand_topic_name(topic, node)] = qos;
    }
  }
}

std::filesystem::path RecorderSettings::folder() const {
  const std::string output = output_.get();
  const std::filesystem::path wanted = output.empty() ? default_folder() : output;
  std::filesystem::path folder = wanted;
  for (int i = 2; next_free_name_.get() && std::filesystem::exists(folder); ++i) {
    folder = wanted.string() + "_" + std::to_string(i);
  }
  return folder;
}

std::string RecorderSettings::asked() const {
  std::string text =
      selection.regex ? "topics that match '" + regex_.get() + "'"
      : selection.all
          ? "all topics" + (selection.ns == "/"
                                ? std::string()
                                : " in " + selection.ns + " and the namespaces around it")
          : "";
  for (const std::string& topic : selection.topics) {
    text += (text.empty() ? "topic " : ", ") + topic;
  }
  return selection.exclude ? text + ", without those that match '" + exclude_.get() + "'" : text;
}

void RecorderSettings::read_thinning(const NodeName& node) {
  const auto topics = thinned_topics_.get();
  const auto periods = thinned_periods_.get();
  if (topics.size() != periods.size()) {
    throw std::invalid_argument("thinned_topics has " + std::to_string(topics.size()) +
                                " names and thinned_periods " + std::to_string(periods.size()) +
                                " numbers");
  }
  thinning.clear();
  for (std::size_t i = 0; i < topics.size(); ++i) {
    constexpr double kLongest = 1e6;
    if (!(periods[i] >= 0.0 && periods[i] <= kLongest)) {
      throw std::invalid_argument("thinned_periods has " + std::to_string(periods[i]) +
                                  "; it must be in [0, 1e6] s");
    }
    thinning[expand_topic_name(topics[i], node)] = from_seconds(periods[i]);
  }
}

}  // namespace pipescout
