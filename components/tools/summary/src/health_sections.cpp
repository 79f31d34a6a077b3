// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <array>
#include <charconv>
#include <diagnostic_msgs/msg/diagnostic_array.hpp>
#include <diagnostic_msgs/msg/diagnostic_status.hpp>
#include <pipescout_msgs/msg/mission_status.hpp>
#include <set>
#include <utility>

#include "bag_sections.hpp"

namespace pipescout::summary {
namespace {

constexpr const char* kLostFigure = "inputs_lost";

/// "subscription /imu/data: dropped_queue_full", as all components write on /diagnostics, and
/// "dropped./imu/data", "not_recorded./imu/data", as BagRecorder does.
struct LossKey {
  std::string topic;
  std::string kind;
};

std::optional<LossKey> loss_of_recorder(std::string_view key) {
  constexpr std::array<std::pair<std::string_view, const char*>, 2> kCounters{{
      {"dropped.", "dropped_by_recorder"},
      {"not_recorded.", "not_recorded"},
  }};
  for (const auto& [prefix, kind] : kCounters) {
    // Counters of other components have no topic behind the dot.
    if (key.starts_with(prefix) && key.substr(prefix.size()).starts_with('/')) {
      return LossKey{std::string(key.substr(prefix.size())), kind};
    }
  }
  return std::nullopt;
}

std::optional<LossKey> loss_of(std::string_view key) {
  if (auto loss = loss_of_recorder(key)) {
    return loss;
  }
  constexpr std::string_view kPrefix = "subscription ";
  constexpr std::string_view kSeparator = ": ";
  const auto separator = key.rfind(kSeparator);
  if (!key.starts_with(kPrefix) || separator == std::string_view::npos ||
      separator <= kPrefix.size()) {
    return std::nullopt;
  }
  const auto kind = key.substr(separator + kSeparator.size());
  constexpr std::array<std::string_view, 3> kKinds{"dropped_queue_full", "lost_by_network",
                                                   "malformed"};
  if (std::find(kKinds.begin(), kKinds.end(), kind) == kKinds.end()) {
    return std::nullopt;
  }
  return LossKey{std::string(key.substr(kPrefix.size(), separator - kPrefix.size())),
                 std::string(kind)};
}

class DiagnosticsSection final : public SectionMaker {
 public:
  explicit DiagnosticsSection(const std::vector<std::string>& mission)
      : mission_(mission.begin(), mission.end()) {}

  bool takes(const bags::BagTopic& topic) const override {
    return topic.type == "diagnostic_msgs/msg/DiagnosticArray";
  }

  void add(const bags::BagTopic& /*topic*/, MessageView view) override {
    using diagnostic_msgs::msg::DiagnosticStatus;
    const auto& message = *static_cast<const diagnostic_msgs::msg::DiagnosticArray*>(view.message);
    for (const DiagnosticStatus& status : message.status) {
      nodes_.insert(status.name);
      if (status.level == DiagnosticStatus::STALE) {
        // No fault while it has not begun; at the end it is one that it never did.
        ++stale_[status.name][status.message];
      } else {
        stale_.erase(status.name);
        if (status.level != DiagnosticStatus::OK) {
          ++warnings_[{status.name, status.message}];
        }
      }
      for (const auto& value : status.values) {
        const auto loss = loss_of(value.key);
        if (!loss) {
          continue;
        }
        std::uint64_t total = 0;
        const char* const end = value.value.data() + value.value.size();
        const auto [last, error] = std::from_chars(value.value.data(), end, total);
        if (error != std::errc{} || last != end) {
          continue;
        }
        // Running totals. They begin anew when a node restarts: what was lost before stays counted.
        Total& known = losses_[{status.name, loss->topic, loss->kind}];
        known.before += total < known.last ? known.last : 0;
        known.last = total;
      }
    }
  }

  void add_to(Sections& sections) override {
    MissionSection section;
    section.title = "Inputs lost";
    section.columns = {"node", "topic", "how", "messages"};
    std::uint64_t lost = 0;
    std::uint64_t lost_elsewhere = 0;
    for (const auto& [key, total] : losses_) {
      const std::uint64_t messages = total.before + total.last;
      if (messages > 0) {
        const auto& [node, topic, kind] = key;
        section.rows.push_back({node, topic, kind, static_cast<std::int64_t>(messages)});
        (is_of_mission(node) && !is_shared(topic) ? lost : lost_elsewhere) += messages;
      }
    }
    if (nodes_.empty()) {
      section.notes.emplace_back(
          "The bag has no /diagnostics: whether inputs were lost is not known.");
      sections["inputs"] = std::move(section);
      return;
    }
    section.figures[kLostFigure] = static_cast<double>(lost);
    section.notes.push_back(lost == 0
                                ? "No input was lost, by the diagnostics of " +
                                      std::to_string(nodes_.size()) + " parts."
                                : "Results that depend on these inputs are not to be trusted.");
    if (lost_elsewhere > 0) {
      section.notes.push_back(
          std::to_string(lost_elsewhere) +
          " messages were lost by nodes that only listened, or of what all nodes of a network say "
          "of themselves: they are not of the mission.");
    }
    sections["inputs"] = std::move(section);

    for (const auto& [name, messages] : stale_) {
      for (const auto& [message, times] : messages) {
        warnings_[{name, message}] += times;
      }
    }
    if (warnings_.empty()) {
      return;
    }
    MissionSection warned;
    warned.title = "Warnings";
    warned.columns = {"node", "message", "times"};
    for (const auto& [key, times] : warnings_) {
      warned.rows.push_back({key.first, key.second, static_cast<std::int64_t>(times)});
    }
    sections["warnings"] = std::move(warned);
  }

 private:
  struct Total {
    std::uint64_t before = 0;
    std::uint64_t last = 0;
  };
  /// `status`: "NODE: SUBJECT", NODE with or without its namespace.
  [[nodiscard]] bool is_of_mission(const std::string& status) const {
    const std::string node = status.substr(0, status.find(':'));
    if (mission_.empty() || mission_.contains(node.starts_with('/') ? node : "/" + node)) {
      return true;
    }
    // Two robots have nodes of one name in two namespaces.
    return node.find('/') == std::string::npos &&
           std::any_of(mission_.begin(), mission_.end(), [&](const std::string& name) {
             return name.substr(name.rfind('/') + 1) == node;
           });
  }
  /// Topics of all nodes of a network, other robots' too. What is lost of them is no input;
  /// counters on /diagnostics are totals, which the next message has again.
  [[nodiscard]] static bool is_shared(const std::string& topic) {
    return topic == "/diagnostics" || topic == "/rosout" || topic == "/parameter_events";
  }

  std::set<std::string> mission_;  // its nodes, fully qualified; empty: all are
  std::set<std::string> nodes_;
  std::map<std::tuple<std::string, std::string, std::string>, Total> losses_;
  std::map<std::pair<std::string, std::string>, std::uint64_t> warnings_;
  std::map<std::string, std::map<std::string, std::uint64_t>> stale_;  // that still are
};

class MissionsSection final : public SectionMaker {
 public:
  explicit MissionsSection(const std::vector<std::string>& complete_when)
      : complete_when_(complete_when.begin(), complete_when.end()) {}

  bool takes(const bags::BagTopic& topic) const override {
    return topic.type == "pipescout_msgs/msg/MissionStatus";
  }

  void add(const bags::BagTopic& /*topic*/, MessageView view) override {
    const auto& message = *static_cast<const pipescout_msgs::msg::MissionStatus*>(view.message);
    reports_[message.node] = message;
  }

  void add_to(Sections& sections) override {
    if (reports_.empty()) {
      return;
    }
    using pipescout_msgs::msg::MissionStatus;
    MissionSection section;
    section.title = "Mission";
    section.columns = {"node", "state", "done", "of", "message"};
    std::string unfinished;
    for (const auto& [node, report] : reports_) {
      if (report.state != MissionStatus::COMPLETE && is_awaited(node)) {
        unfinished += (unfinished.empty() ? "" : ", ") + node;
      }
    }
    for (const std::string& node : complete_when_) {
      if (!reports_.contains(node)) {
        unfinished += (unfinished.empty() ? "" : ", ") + node;
      }
    }
    for (const auto& [node, report] : reports_) {
      // Once all that it waits for are complete, a mission stops the others.
      const char* const state = report.state == MissionStatus::COMPLETE ? "complete"
                                : report.state == MissionStatus::FAILED ? "failed"
                                : unfinished.empty()                    ? "stopped"
                                                                        : "running";
      section.rows.push_back({node, state, static_cast<std::int64_t>(report.done),
                              static_cast<std::int64_t>(report.total), report.message});
    }
    const auto lost = inputs_lost(sections);
    if (lost.value_or(0) > 0) {
      section.notes.emplace_back("Not complete: inputs were lost, see there.");
    } else if (!unfinished.empty()) {
      section.notes.push_back("Not complete: " + unfinished + ".");
    } else if (!lost) {
      section.notes.emplace_back(
          "All nodes are complete; whether inputs were lost is not known, since the bag has no "
          "/diagnostics.");
    } else {
      section.notes.emplace_back("Complete.");
    }
    sections["mission"] = std::move(section);
  }

 private:
  [[nodiscard]] bool is_awaited(const std::string& node) const {
    return complete_when_.empty() || complete_when_.contains(node);
  }

  std::set<std::string> complete_when_;
  std::map<std::string, pipescout_msgs::msg::MissionStatus> reports_;  // the last of each node
};

}  // namespace

std::optional<std::uint64_t> inputs_lost(const Sections& sections) {
  const auto inputs = sections.find("inputs");
  if (inputs == sections.end() || !inputs->second.figures.contains(kLostFigure)) {
    return std::nullopt;
  }
  return static_cast<std::uint64_t>(inputs->second.figures.at(kLostFigure));
}

std::unique_ptr<SectionMaker> diagnostics_section(const std::vector<std::string>& mission) {
  return std::make_unique<DiagnosticsSection>(mission);
}

std::unique_ptr<SectionMaker> mission_section(const std::vector<std::string>& complete_when) {
  return std::make_unique<MissionsSection>(complete_when);
}

}  // namespace pipescout::summary
