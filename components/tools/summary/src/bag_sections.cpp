// SPDX-License-Identifier: Apache-2.0
#include "bag_sections.hpp"

#include <algorithm>
#include <ctime>
#include <deque>
#include <iomanip>
#include <locale>
#include <optional>
#include <sstream>
#include <utility>

#include "pipescout/bags/bag_reader.hpp"
#include "pipescout/idl/message_type.hpp"
#include "topic_times.hpp"

namespace pipescout::summary {
namespace {

constexpr std::uint64_t kMessagesPerReport = 10'000;

struct Topic {
  TopicTimes times;
  const MessageType* type = nullptr;
  std::shared_ptr<void> message;  // decoded into, again and again
  std::vector<SectionMaker*> makers;
  std::uint64_t undecoded = 0;
};

std::string utc_text(std::int64_t nanoseconds) {
  const auto time = static_cast<std::time_t>(nanoseconds / 1'000'000'000);
  std::tm parts{};
  gmtime_r(&time, &parts);
  std::ostringstream text;
  text.imbue(std::locale::classic());
  text << std::put_time(&parts, "%Y-%m-%d %H:%M:%S UTC");
  return text.str();
}

MissionSection topics_section(const std::deque<Topic>& topics, std::int64_t first,
                              std::int64_t last) {
  MissionSection section;
  section.title = "Topics";
  section.columns = {"topic",           "type",      "messages", "rate [Hz]",
                     "longest gap [s]", "delay [s]", "size [MB]"};
  std::uint64_t messages = 0;
  std::uint64_t with_messages = 0;
  std::vector<std::string> unknown;
  std::vector<std::string> remarks;
  for (const Topic& topic : topics) {
    section.rows.push_back(topic.times.row());
    messages += topic.times.messages();
    with_messages += topic.times.messages() > 0 ? 1 : 0;
    if (topic.type == nullptr) {
      unknown.push_back(topic.times.topic().type);
    }
    for (std::string& remark : topic.times.remarks()) {
      remarks.push_back(std::move(remark));
    }
  }
  const double duration = messages == 0 ? 0.0 : static_cast<double>(last - first) / 1e9;
  section.figures = {{"bag_topics", static_cast<double>(with_messages)},
                     {"bag_messages", static_cast<double>(messages)},
                     {"bag_duration_s", duration}};
  if (messages > 0) {
    section.notes.push_back("From " + utc_text(first) + ".");
    section.notes.push_back(
        "Delay: from the stamp of a message to its recording, the mean. Gap: between two messages, "
        "as recorded.");
  }
  section.notes.insert(section.notes.end(), remarks.begin(), remarks.end());
  for (const std::string& type : unknown) {
    section.notes.push_back("Type " + type +
                            " is not known here: its messages are counted, not looked into.");
  }
  return section;
}

}  // namespace

BagSections summarise(const std::filesystem::path& bag,
                      const std::function<void(double)>& progress) {
  std::vector<std::unique_ptr<SectionMaker>> makers;
  makers.push_back(mission_section());
  makers.push_back(diagnostics_section());
  makers.push_back(odometry_section());
  makers.push_back(imu_section());
  makers.push_back(gps_section());

  bags::BagReader reader(bag);
  std::deque<Topic> topics;
  for (const bags::BagTopic& topic : reader.topics()) {
    const MessageType* type =
        topic.serialization_format == "cdr" ? find_message_type(topic.type) : nullptr;
    Topic each{.times = TopicTimes(topic, type), .type = type};
    for (const auto& maker : makers) {
      if (type != nullptr && maker->takes(topic.type)) {
        each.makers.push_back(maker.get());
      }
    }
    if (!each.makers.empty()) {
      each.message = type->create();
    }
    topics.push_back(std::move(each));
  }

  BagSections result;
  const double expected = static_cast<double>(reader.metadata().messages);
  std::uint64_t read = 0;
  std::int64_t first = 0;
  std::int64_t last = 0;
  try {
    while (const auto message = reader.next()) {
      Topic& topic = topics.at(message->topic);
      topic.times.add(*message);
      first = read == 0 ? message->log_time : first;
      last = message->log_time;
      if (++read % kMessagesPerReport == 0 && expected > 0) {
        progress(std::min(1.0, static_cast<double>(read) / expected));
      }
      if (topic.makers.empty()) {
        continue;
      }
      if (!topic.type->deserialize(message->data, topic.message.get())) {
        ++topic.undecoded;
        continue;
      }
      for (SectionMaker* maker : topic.makers) {
        maker->add(topic.times.topic(), MessageView{topic.type, topic.message.get()});
      }
    }
  } catch (const bags::BagError& error) {
    result.problems.emplace_back(error.what());
  }
  for (const Topic& topic : topics) {
    if (topic.undecoded > 0) {
      result.problems.push_back(topic.times.topic().name + ": " + std::to_string(topic.undecoded) +
                                " messages are no " + topic.times.topic().type);
    }
  }
  result.sections["topics"] = topics_section(topics, first, last);
  // Diagnostics before the mission, which is judged by them.
  for (auto maker = makers.rbegin(); maker != makers.rend(); ++maker) {
    (*maker)->add_to(result.sections);
  }
  return result;
}

}  // namespace pipescout::summary
