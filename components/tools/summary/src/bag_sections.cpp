// SPDX-License-Identifier: Apache-2.0
#include "bag_sections.hpp"

#include <algorithm>
#include <array>
#include <chrono>
#include <deque>
#include <optional>
#include <set>
#include <utility>

#include "pipescout/bags/bag_reader.hpp"
#include "pipescout/catalogue/topics.hpp"
#include "pipescout/files/utc_text.hpp"
#include "pipescout/idl/message_type.hpp"
#include "tables/makers.hpp"
#include "topic_times.hpp"

namespace pipescout::summary {
namespace {

namespace fs = std::filesystem;

constexpr std::uint64_t kMessagesPerReport = 10'000;

struct Topic {
  TopicTimes times;
  const MessageType* type = nullptr;
  std::shared_ptr<void> message;  // decoded into, again and again
  std::vector<SectionMaker*> makers;
  std::uint64_t undecoded = 0;
};

std::string utc_text_of(std::int64_t nanoseconds) {
  return utc_text(
      std::chrono::floor<std::chrono::milliseconds>(
          std::chrono::sys_time<std::chrono::nanoseconds>(std::chrono::nanoseconds(nanoseconds))),
      UtcForm::kReadable);
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
      const bags::BagTopic& of = topic.times.topic();
      unknown.push_back(of.serialization_format == "cdr"
                            ? of.type
                            : of.type + " in the encoding " + of.serialization_format);
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
    section.notes.push_back("From " + utc_text_of(first) + ".");
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

/// The namespaces in which there is something to make tables of.
std::set<std::string> namespaces(const std::vector<bags::BagTopic>& topics) {
  constexpr std::array<std::string_view, 6> kSubjects{
      topics::kOdometerReadings.name, topics::kPipePosition.name, topics::kRackState.name,
      topics::kLeakDetections.name,   topics::kPipeTrack.name,    topics::kOdometryFiltered.name};
  std::set<std::string> found;
  for (const bags::BagTopic& topic : topics) {
    for (const std::string_view subject : kSubjects) {
      const std::string end = "/" + std::string(subject);
      if (topic.name.ends_with(end)) {
        const auto length = topic.name.size() - end.size();
        found.insert(length == 0 ? "/" : topic.name.substr(0, length));
      }
    }
  }
  return found;
}

/// Reads bags one after the other, as if they were one.
class Summary {
 public:
  Summary(const std::vector<fs::path>& bags, const Mission& mission) {
    std::vector<bags::BagTopic> all;
    for (const fs::path& bag : bags) {
      readers_.push_back(std::make_unique<bags::BagReader>(bag));
      expected_ += static_cast<double>(readers_.back()->metadata().messages);
      all.insert(all.end(), readers_.back()->topics().begin(), readers_.back()->topics().end());
    }
    makers_.push_back(mission_section(mission.info.complete_when));
    makers_.push_back(diagnostics_section(mission.info.nodes));
    makers_.push_back(odometry_section());
    makers_.push_back(imu_section());
    makers_.push_back(gps_section());
    add_table_makers(all, mission);
    for (const bags::BagTopic& topic : all) {
      add_topic(topic);
    }
  }

  BagSections read(const std::function<void(double)>& progress) {
    BagSections result;
    for (const auto& reader : readers_) {
      try {
        read(*reader, progress);
      } catch (const bags::BagError& error) {
        result.problems.emplace_back(error.what());
      }
    }
    for (const Topic& topic : topics_) {
      if (topic.undecoded > 0) {
        result.problems.push_back(topic.times.topic().name + ": " +
                                  std::to_string(topic.undecoded) + " messages are no " +
                                  topic.times.topic().type);
      }
    }
    result.sections["topics"] = topics_section(topics_, first_, last_);
    // Diagnostics before the mission, which is judged by them.
    for (auto maker = makers_.rbegin(); maker != makers_.rend(); ++maker) {
      (*maker)->add_to(result.sections);
    }
    for (const auto& maker : table_makers_) {
      maker->add_to(result.tables);
      if (!maker->problem().empty()) {
        result.problems.push_back(maker->problem());
      }
    }
    return result;
  }

 private:
  void add_table_makers(const std::vector<bags::BagTopic>& topics, const Mission& mission) {
    const TableOptions& options = mission.info.options;
    for (const std::string& ns : namespaces(topics)) {
      const Robot robot{.ns = ns, .source = mission.info.source, .folder = mission.folder};
      table_makers_.push_back(crawler_tables(robot, options.crawler));
      const auto offsets = mission.info.odometer_offsets.find(ns);
      table_makers_.push_back(odometry_tables(robot, options.odometry,
                                              offsets == mission.info.odometer_offsets.end()
                                                  ? std::nullopt
                                                  : std::optional(offsets->second)));
      table_makers_.push_back(rack_tables(robot, options.rack));
      table_makers_.push_back(leak_tables(robot));
      table_makers_.push_back(tracking_tables(robot, options.tracking));
      table_makers_.push_back(estimator_tables(robot, options.estimator));
      table_makers_.push_back(navigation_tables(robot));
    }
  }

  void add_topic(const bags::BagTopic& topic) {
    if (topic_of_.contains(topic.name)) {
      return;  // in another bag already
    }
    const MessageType* type =
        topic.serialization_format == "cdr" ? find_message_type(topic.type) : nullptr;
    Topic each{.times = TopicTimes(topic, type), .type = type};
    if (type != nullptr) {
      for (const auto& maker : makers_) {
        if (maker->takes(topic)) {
          each.makers.push_back(maker.get());
        }
      }
      for (const auto& maker : table_makers_) {
        if (maker->takes(topic)) {
          each.makers.push_back(maker.get());
        }
      }
    }
    if (!each.makers.empty()) {
      each.message = type->create();
    }
    topics_.push_back(std::move(each));
    topic_of_[topic.name] = &topics_.back();
  }

  void read(bags::BagReader& reader, const std::function<void(double)>& progress) {
    std::vector<Topic*> by_index;
    for (const bags::BagTopic& topic : reader.topics()) {
      by_index.push_back(topic_of_.at(topic.name));
    }
    while (const auto message = reader.next()) {
      Topic& topic = *by_index.at(message->topic);
      topic.times.add(*message);
      first_ = read_ == 0 ? message->log_time : first_;
      last_ = message->log_time;
      if (++read_ % kMessagesPerReport == 0 && expected_ > 0) {
        progress(std::min(1.0, static_cast<double>(read_) / expected_));
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
  }

  std::vector<std::unique_ptr<bags::BagReader>> readers_;
  double expected_ = 0.0;  // messages
  std::vector<std::unique_ptr<SectionMaker>> makers_;
  std::vector<std::unique_ptr<TableMaker>> table_makers_;
  std::deque<Topic> topics_;
  std::map<std::string, Topic*> topic_of_;
  std::uint64_t read_ = 0;
  std::int64_t first_ = 0;
  std::int64_t last_ = 0;
};

}  // namespace

BagSections summarise(const std::vector<fs::path>& bags, const Mission& mission,
                      const std::function<void(double)>& progress) {
  return Summary(bags, mission).read(progress);
}

}  // namespace pipescout::summary
