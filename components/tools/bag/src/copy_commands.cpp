// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <functional>
#include <iostream>
#include <limits>
#include <memory>
#include <optional>
#include <queue>
#include <string>
#include <utility>
#include <vector>

#include "offline_commands.hpp"
#include "pipescout/bag_topics/bag_topic.hpp"
#include "pipescout/bags/bag_error.hpp"
#include "pipescout/bags/bag_reader.hpp"
#include "pipescout/bags/bag_writer.hpp"
#include "pipescout/idl/message_type.hpp"
#include "storage_options.hpp"

namespace pipescout::bag_command {
namespace {

using bags::BagMessage;
using bags::BagReader;
using bags::BagWriter;
using bags::TopicIndex;
using command_line::Action;
using command_line::CommandError;

struct CopyOptions {
  std::vector<std::string> bags;
  StorageOptions storage;
  TopicOptions topics;
  double start = 0.0;                                    ///< s after the bag's first message
  double end = std::numeric_limits<double>::infinity();  ///< the same
};

/// A bag that is copied, with the message that comes next.
struct Source {
  std::unique_ptr<BagReader> reader;
  std::vector<std::optional<TopicIndex>> topics;  ///< in the new bag
  std::optional<BagMessage> message;
};

/// SQLite bags of Humble do not keep definitions; MCAP asks for them.
bags::BagTopic with_schema(bags::BagTopic topic) {
  const MessageType* type = find_message_type(topic.type);
  if (topic.schema_text.empty() && type != nullptr && topic.serialization_format == "cdr") {
    topic.schema_encoding = "ros2msg";
    topic.schema_text = ros2msg_schema(*type);
  }
  return topic;
}

std::int64_t time_after(std::int64_t start, double seconds) {
  const double time = static_cast<double>(start) + std::round(seconds * 1e9);
  constexpr double kLast = 9.2e18;
  return time >= kLast ? std::numeric_limits<std::int64_t>::max()
                       : start + static_cast<std::int64_t>(std::llround(seconds * 1e9));
}

void advance(Source& source, std::vector<std::string>& faults) {
  try {
    source.message = source.reader->next();
  } catch (const bags::BagError& error) {
    faults.emplace_back(error.what());
    source.message.reset();
  }
}

Source open(const std::string& bag, const CopyOptions& options) {
  Source source{.reader = std::make_unique<BagReader>(bag)};
  const auto& topics = source.reader->topics();
  source.topics.resize(topics.size());
  const std::int64_t first = source.reader->metadata().starting_time;
  source.reader->set_filter({.topics = chosen_topics(options.topics, topics),
                             .start = options.start > 0.0
                                          ? time_after(first, options.start)
                                          : std::numeric_limits<std::int64_t>::min(),
                             .end = time_after(first, options.end)});
  return source;
}

TopicIndex topic_of(Source& source, TopicIndex topic, BagWriter& writer) {
  source.topics.resize(source.reader->topics().size());
  auto& known = source.topics[topic];
  if (!known) {
    known = writer.add_topic(with_schema(source.reader->topics()[topic]));
  }
  return *known;
}

/// Topics without messages are kept too.
void add_topics(Source& source, const CopyOptions& options, BagWriter& writer) {
  const auto chosen = chosen_topics(options.topics, source.reader->topics());
  for (TopicIndex topic = 0; topic < source.reader->topics().size(); ++topic) {
    const std::string& name = source.reader->topics()[topic].name;
    if (!chosen || std::find(chosen->begin(), chosen->end(), name) != chosen->end()) {
      (void)topic_of(source, topic, writer);
    }
  }
}

int copy(const CopyOptions& options) {
  std::vector<Source> sources;
  for (const std::string& bag : options.bags) {
    sources.push_back(open(bag, options));
  }
  BagWriter writer(options.storage.output,
                   writer_options(options.storage, sources.front().reader->metadata().storage));
  std::vector<std::string> faults;
  // By log time; messages of equal times in the order of the bags.
  using Head = std::pair<std::int64_t, std::size_t>;
  std::priority_queue<Head, std::vector<Head>, std::greater<>> next;
  const auto queue = [&](std::size_t k) {
    advance(sources[k], faults);
    if (sources[k].message) {
      next.emplace(sources[k].message->log_time, k);
    }
  };
  for (std::size_t k = 0; k < sources.size(); ++k) {
    add_topics(sources[k], options, writer);
    queue(k);
  }
  while (!next.empty()) {
    const std::size_t k = next.top().second;
    next.pop();
    BagMessage message = *sources[k].message;
    message.topic = topic_of(sources[k], message.topic, writer);
    writer.write(message);
    queue(k);
  }
  writer.close();
  std::cout << options.storage.output << ": " << writer.metadata().messages << " messages on "
            << writer.metadata().topics.size() << " topics\n";
  for (const std::string& fault : faults) {
    std::cerr << "error: not everything could be read: " << fault << '\n';
  }
  return faults.empty() ? command_line::kExitOk : command_line::kExitError;
}

}  // namespace

void add_copy_commands(CLI::App& app, Action& action) {
  auto options = std::make_shared<CopyOptions>();
  const auto add = [&](const char* name, const char* description, bool several) {
    auto* command = app.add_subcommand(name, description);
    auto* bags = command->add_option("bag", options->bags,
                                     "Folder of a bag, or one .db3, .mcap or .bag file");
    bags->required();
    if (!several) {
      bags->expected(1);
    }
    add_storage_options(*command, options->storage);
    command->callback([options, &action] { action = [options] { return copy(*options); }; });
    return command;
  };
  add("convert", "Write a bag to a new one, stored in another way; reads bags of ROS 1 too", false);
  add_topic_options(
      *add("merge", "Write several bags to a new one, by the time of their messages", true),
      options->topics);
  auto* filter = add("filter", "Write some topics or some time of a bag to a new one", false);
  add_topic_options(*filter, options->topics);
  filter->add_option("--start", options->start, "From so many seconds after the first message on")
      ->check(CLI::Range(0.0, 1e9));
  filter->add_option("--end", options->end, "Up to so many seconds after the first message")
      ->check(CLI::Range(0.0, 1e9));
}

}  // namespace pipescout::bag_command
