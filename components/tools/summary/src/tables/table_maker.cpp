// SPDX-License-Identifier: Apache-2.0
#include "tables/table_maker.hpp"

#include <stdexcept>

#include "pipescout/mission_folder/mission_section.hpp"
#include "pipescout/runtime/standard_topics.hpp"

namespace pipescout::summary {
namespace {

using pipescout_msgs::msg::MissionStatus;

std::optional<std::filesystem::path> folder_of(const Robot& robot, const std::string& name) {
  if (!robot.folder) {
    return std::nullopt;
  }
  return *robot.folder / robot.ns.substr(1) / name;
}

}  // namespace

TableMaker::TableMaker(Robot robot, std::string name)
    : robot_(std::move(robot)), name_(std::move(name)), files_(folder_of(robot_, name_)) {
  if (!robot_.source.empty()) {
    handlers_.emplace(
        expanded(topics::kMissionStatus.name),
        Handler{std::string(message_type<MissionStatus>().name), [this](const void* message) {
                  on_status(*static_cast<const MissionStatus*>(message));
                }});
  }
}

std::string TableMaker::expanded(std::string_view topic) const {
  return (robot_.ns == "/" ? "/" : robot_.ns + "/") + std::string(topic);
}

bool TableMaker::takes(const bags::BagTopic& topic) const {
  const auto handler = handlers_.find(topic.name);
  return handler != handlers_.end() && handler->second.type == topic.type;
}

void TableMaker::add(const bags::BagTopic& topic, MessageView view) {
  handlers_.at(topic.name).add(view.message);
}

void TableMaker::guarded(const std::function<void()>& write, const std::string& what) {
  try {
    write();
  } catch (const std::invalid_argument& error) {
    fault(what + ": " + error.what());
  }
}

void TableMaker::on_status(const MissionStatus& status) {
  if (status.node != robot_.source || end_ != End::kNone) {
    return;
  }
  if (status.state == MissionStatus::FAILED) {
    end_ = End::kFailed;
    why_failed_ = robot_.source + " failed: " + status.message;
    return;
  }
  guarded([&] { on_source(status); }, "mission/status");
  if (status.state == MissionStatus::COMPLETE) {
    end_ = End::kComplete;
    if (const Time stamp = from_message(status.header.stamp); stamp > Time{}) {
      end_stamp_ = stamp;
    }
  }
}

std::string TableMaker::outcome() const {
  if (end_ == End::kFailed) {
    return "Failed: " + why_failed_;
  }
  if (end_ == End::kComplete) {
    return (has_data() ? "Complete: " : "Failed: ") + counts();
  }
  // Of a bag alone nobody knows when it is complete.
  return (robot_.source.empty() ? "Found: " : "Not complete: ") + counts();
}

std::string TableMaker::problem() const {
  const bool failed = end_ == End::kFailed || (end_ == End::kComplete && !has_data());
  return has_section() && failed ? name_ + ": " + outcome() : "";
}

void TableMaker::add_to(Sections& sections) {
  if (!has_section()) {
    return;
  }
  write_last();
  files_.finish();
  const std::string name = mission_section_name((robot_.ns == "/" ? "/" : robot_.ns + "/") + name_);
  MissionSection made = section(name.substr(0, name.rfind('.') + 1));
  made.notes.insert(made.notes.begin(), outcome() + ".");
  if (robot_.folder) {
    made.notes.push_back("Data: " + (robot_.ns == "/" ? "" : robot_.ns.substr(1) + "/") + name_ +
                         "/" + file_names() + ".");
  }
  for (const auto& [text, times] : faults_) {
    made.notes.push_back("Left out, " + std::to_string(times) + " times: " + text + ".");
  }
  sections[name] = std::move(made);
}

}  // namespace pipescout::summary
