// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <functional>
#include <map>
#include <optional>
#include <pipescout_msgs/msg/mission_status.hpp>
#include <string>
#include <string_view>
#include <utility>

#include "bag_sections.hpp"
#include "pipescout/runtime/conversions.hpp"
#include "pipescout/runtime/time.hpp"
#include "pipescout/runtime/topic.hpp"
#include "tables/table_files.hpp"

namespace pipescout::summary {

/// Whose tables are made, and where they go.
struct Robot {
  std::string ns;      ///< its namespace, "/" or "/robot_1"
  std::string source;  ///< node whose completion ends the mission; empty: not known
  /// Mission folder for the data files; nothing: no files.
  std::optional<std::filesystem::path> folder;
};

/// Base of what makes the tables of one subject: data files line by line from the messages of one
/// robot, and a section with figures. What is stamped later than the completion of the source is
/// left out: how much of it there is depends on when the recording was stopped.
class TableMaker : public SectionMaker {
 public:
  /// `name`: of the section and of the folder of its files, below the robot's namespace.
  TableMaker(Robot robot, std::string name);

  [[nodiscard]] bool takes(const bags::BagTopic& topic) const final;
  void add(const bags::BagTopic& topic, MessageView view) final;
  /// Finishes the data files. Throws std::system_error naming what cannot be written.
  void add_to(Sections& sections) final;
  /// Why the mission failed, by these tables; empty when it did not.
  [[nodiscard]] std::string problem() const;

 protected:
  /// For constructors: calls `write` for each message of the topic. What it refuses with
  /// std::invalid_argument is counted under `what` and told in the notes.
  template <class T, class Write>
  void record(const Topic<T>& topic, const std::string& what, Write write) {
    const MessageType& type = message_type<T>();
    handlers_.insert_or_assign(
        expanded(topic.name),
        Handler{std::string(type.name), [this, what, write](const void* message) {
                  const T& typed = *static_cast<const T*>(message);
                  if (!is_after_the_end(typed)) {
                    guarded([&] { write(typed); }, what);
                  }
                }});
  }
  [[nodiscard]] TableFiles& files() noexcept { return files_; }
  [[nodiscard]] TableFile& file(std::string_view name, const std::function<std::string()>& header) {
    return files_.file(name, header);
  }
  /// Counts a fault of the messages; told in the notes.
  void fault(const std::string& text) { ++faults_[text]; }

  // A derived class overrides these:

  /// Title, table, figures and notes, without a note on the outcome.
  [[nodiscard]] virtual MissionSection section(const std::string& figure_prefix) const = 0;
  /// How much there is, as a part of a sentence.
  [[nodiscard]] virtual std::string counts() const = 0;
  /// Whether there is enough: otherwise the mission failed, although its source is complete.
  [[nodiscard]] virtual bool has_data() const = 0;
  /// Whether there is anything to tell; otherwise there is no section.
  [[nodiscard]] virtual bool has_section() const = 0;
  /// Names of the data files, for the notes.
  [[nodiscard]] virtual std::string file_names() const = 0;
  /// Before the data files are finished: what could not be written line by line.
  virtual void write_last() {}
  /// A status of the source, its completion too.
  virtual void on_source(const pipescout_msgs::msg::MissionStatus& /*status*/) {}

 private:
  struct Handler {
    std::string type;
    std::function<void(const void* message)> add;
  };
  enum class End { kNone, kComplete, kFailed };

  template <class T>
  [[nodiscard]] bool is_after_the_end(const T& message) const {
    if constexpr (requires { message.header.stamp; }) {
      return end_stamp_ && from_message(message.header.stamp) > *end_stamp_;
    } else {
      return false;
    }
  }
  [[nodiscard]] std::string expanded(std::string_view topic) const;
  void guarded(const std::function<void()>& write, const std::string& what);
  void on_status(const pipescout_msgs::msg::MissionStatus& status);
  [[nodiscard]] std::string outcome() const;

  Robot robot_;
  std::string name_;
  TableFiles files_;
  std::map<std::string, Handler> handlers_;  // by topic
  std::map<std::string, std::uint64_t> faults_;
  End end_ = End::kNone;
  std::string why_failed_;
  std::optional<Time> end_stamp_;
};

}  // namespace pipescout::summary
