// SPDX-License-Identifier: Apache-2.0
#include "pipescout/bag_recording/bag_recorder.hpp"

#include <algorithm>
#include <array>
#include <atomic>
#include <charconv>
#include <chrono>
#include <deque>
#include <diagnostic_msgs/msg/diagnostic_array.hpp>
#include <diagnostic_msgs/msg/diagnostic_status.hpp>
#include <diagnostic_msgs/msg/key_value.hpp>
#include <filesystem>
#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <pipescout_msgs/msg/mission_status.hpp>
#include <rosbag2_interfaces/msg/write_split_event.hpp>
#include <set>
#include <stdexcept>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "pipescout/bag_topics/bag_topic.hpp"
#include "pipescout/bag_topics/header_stamp.hpp"
#include "pipescout/bag_topics/qos_profiles.hpp"
#include "pipescout/bags/bag_error.hpp"
#include "pipescout/bags/bag_writer.hpp"
#include "pipescout/mission_tables/thinning.hpp"
#include "pipescout/runtime/conversions.hpp"
#include "pipescout/runtime/register_component.hpp"
#include "pipescout/runtime/standard_topics.hpp"
#include "pipescout/runtime/timer.hpp"
#include "recorder_settings.hpp"
#include "recording_queue.hpp"

namespace pipescout {

namespace {

using pipescout_msgs::msg::MissionStatus;
using rosbag2_interfaces::msg::WriteSplitEvent;

/// What a latched topic may have kept for us; other messages never wait in a queue of the runtime.
constexpr std::size_t kDepth = 1000;
constexpr Duration kStatisticsPeriod = std::chrono::seconds(1);
/// Silence is noticed by a quarter of itself late.
constexpr int kLooksPerSilence = 4;
/// Times settle_time after which a recording is complete although messages go on.
constexpr int kMostSettles = 10;

/// Not what nodes publish by the clock, whatever happens.
bool tells_of_progress(const std::string& topic) {
  const std::string_view name = std::string_view(topic).substr(topic.rfind('/') + 1);
  return name != "clock" && name != "rosout" && name != "diagnostics" && name != "parameter_events";
}

std::string joined(const std::set<std::string>& names) {
  std::string text;
  for (const auto& name : names) {
    text += (text.empty() ? "" : ", ") + name;
  }
  return text;
}

}  // namespace

/// One bag, from activation to deactivation. Lives in the component's default group.
class BagRecorder::Recording {
 public:
  /// Throws bags::BagError, std::invalid_argument.
  Recording(BagRecorder& recorder, const RecorderSettings& settings)
      : recorder_(recorder),
        settings_(settings),
        split_events_(
            recorder.create_publisher<WriteSplitEvent>("events/write_split", QoS::latched(1000))),
        diagnostics_(recorder.create_publisher(topics::kDiagnostics, {.managed = false})),
        folder_(settings.folder()),
        queue_(std::make_unique<bags::BagWriter>(folder_, settings.writer), settings.queue,
               {.split =
                    [this](const auto& closed, const auto& opened) {
                      post([this, closed, opened] {
                        WriteSplitEvent event;
                        event.closed_file = closed.string();
                        event.opened_file = opened.string();
                        split_events_.publish(std::move(event));
                      });
                    },
                .failed = [this](const std::string& why) { post([this, why] { fail(why); }); }}) {
    graph_changes_ = recorder.context().graph().on_changed([this] {
      if (!is_looking_.exchange(true)) {
        post([this] {
          is_looking_ = false;
          find_topics();
        });
      }
    });
    find_topics();
    statistics_timer_ = recorder.create_timer(kStatisticsPeriod, [this] { show_counts(); });
    if (!settings.source.empty()) {
      watch_source();
    }
    recorder.logger().info("the bag is " + folder_.string());
  }
  Recording(const Recording&) = delete;
  Recording& operator=(const Recording&) = delete;
  ~Recording() { finish(); }

  /// Ends all subscriptions, writes what waits and closes the bag.
  void finish() {
    graph_changes_.reset();
    statistics_timer_.reset();
    settle_timer_.reset();
    silence_timer_.reset();
    status_subscription_ = {};
    if (!subscriptions_.empty()) {
      // What this recording lost is a part of it.
      publish_diagnostics();
    }
    subscriptions_.clear();
    queue_.finish();
    show_counts();
    const auto counts = queue_.counts();
    recorder_.logger().info(
        std::to_string(counts.written) + " messages of " + std::to_string(topics_.size()) +
        " topics recorded, " + std::to_string(counts.dropped) + " dropped" +
        (counts.lost > 0 ? ", " + std::to_string(counts.lost) + " lost by the error" : "") + ": " +
        folder_.string());
    if (has_failed_) {
      return;
    }
    if (const std::string why = queue_.error(); !why.empty()) {
      report_end(why);  // met only now, in what was still to be written
    } else if (counts.written == 0 && !settings_.queue.snapshot) {
      // Without a snapshot nothing is what was asked for.
      recorder_.report_failed("no message was recorded: asked for " + settings_.asked() + "; " +
                              what_was_seen() + "; the bag is empty: " + folder_.string());
    }
  }
  [[nodiscard]] bool take_snapshot() { return queue_.take_snapshot(); }

 private:
  struct Topic {
    Topic(std::string its_name, bags::TopicIndex its_index)
        : name(std::move(its_name)), index(its_index) {}

    const std::string name;
    const bags::TopicIndex index;
    std::atomic<bool> dropped{false};
    bool tells_of_progress = true;
    // Of a topic that is thinned; a topic may have several publishers, each on its own thread.
    bool has_header = false;
    std::mutex thinning_mutex;
    std::optional<Thinning> thinning;
  };

  /// Whether the message is to be recorded, by the period of its topic.
  [[nodiscard]] static bool is_due(Topic& topic, const SerializedMessage& message,
                                   std::int64_t log_time) {
    if (!topic.thinning) {
      return true;
    }
    const auto stamp = topic.has_header ? header_stamp(message.bytes()) : std::nullopt;
    const Time time{Duration(stamp.value_or(log_time))};
    const std::lock_guard lock(topic.thinning_mutex);
    if (!topic.thinning->due(time)) {
      return false;
    }
    topic.thinning->keep(time);
    return true;
  }

  void watch_source() {
    status_subscription_ = recorder_.create_subscription(
        topics::kMissionStatus, [this](const MissionStatus& status) { on_status(status); },
        {.managed = false});
    if (settings_.silence > Duration::zero()) {
      // Measured by the wall clock: simulated time stands still when nothing happens.
      silence_timer_.emplace(recorder_.default_group(), settings_.silence / kLooksPerSilence,
                             [this] { look_for_silence(); });
    }
  }

  void on_status(const MissionStatus& status) {
    if (status.node != settings_.source || settle_timer_ || has_ended_) {
      return;
    }
    if (status.state == MissionStatus::FAILED) {
      has_ended_ = has_failed_ = true;
      silence_timer_.reset();
      recorder_.report_failed(settings_.source + " failed: " + status.message);
    } else if (status.state == MissionStatus::COMPLETE) {
      silence_timer_.reset();
      messages_before_ = messages_;
      settle_timer_.emplace(recorder_.default_group(), settings_.settle, [this] { settle(); });
    } else if (status.total != 0) {
      recorder_.report_progress(status.done, status.total);
    }
  }

  /// Messages may still be under way when the source says that it is complete; of a robot that goes
  /// on there is no last one.
  void settle() {
    const bool is_quiet = messages_before_ == messages_;
    messages_before_ = messages_;
    if (has_ended_ || (!is_quiet && ++settles_ < kMostSettles)) {
      return;
    }
    has_ended_ = true;
    recorder_.report_complete("recorded into " + folder_.string());
  }

  void look_for_silence() {
    const std::uint64_t messages = messages_;
    if (messages == 0 || std::exchange(messages_before_, messages) != messages) {
      silent_looks_ = 0;
    } else if (++silent_looks_ == kLooksPerSilence && !has_ended_) {
      has_ended_ = has_failed_ = true;
      std::array<char, 64> seconds{};
      const auto written =
          std::to_chars(seconds.data(), seconds.data() + seconds.size(),
                        to_seconds(settings_.silence), std::chars_format::general, 6);
      recorder_.report_failed("no message has arrived for " +
                              std::string(seconds.data(), written.ptr) + " s, and '" +
                              settings_.source + "' has not reported completion");
    }
  }

  /// Runs in the default group, unless the recording has gone by then. From any thread.
  void post(std::function<void()> function) const {
    recorder_.default_group()->post(
        [alive = std::weak_ptr(alive_), function = std::move(function)] {
          if (!alive.expired()) {
            function();
          }
        });
  }

  void fail(const std::string& why) {
    has_ended_ = has_failed_ = true;
    graph_changes_.reset();
    subscriptions_.clear();
    report_end(why);
  }

  void report_end(const std::string& why) const {
    recorder_.report_failed("the recording has ended: " + why +
                            "; the bag is closed, and lacks the last second at most");
  }

  /// The component does so within a second: too late for this bag.
  void publish_diagnostics() {
    show_counts();
    diagnostic_msgs::msg::DiagnosticStatus status;
    auto snapshot = recorder_.diagnostics().take();
    status.level = static_cast<std::uint8_t>(snapshot.level);
    status.name = recorder_.node_name().fully_qualified().substr(1) + ": status";
    status.hardware_id = "none";
    status.message = std::move(snapshot.message);
    for (const auto& [key, value] : snapshot.values) {
      diagnostic_msgs::msg::KeyValue pair;
      pair.key = key;
      pair.value = value;
      status.values.push_back(std::move(pair));
    }
    diagnostic_msgs::msg::DiagnosticArray array;
    array.header.stamp = to_message(recorder_.now());
    array.status.push_back(std::move(status));
    diagnostics_.publish(std::move(array));
  }

  void show_counts() const {
    const auto counts = queue_.counts();
    auto& diagnostics = recorder_.diagnostics();
    diagnostics.set_value("recorded.topics", std::to_string(topics_.size()));
    diagnostics.set_value("recorded.messages", std::to_string(counts.written));
    diagnostics.set_value("recorded.bytes", std::to_string(counts.bytes));
  }

  /// Of the topics that others publish.
  [[nodiscard]] std::string what_was_seen() const {
    std::set<std::string> recorded;
    for (const Topic& topic : topics_) {
      recorded.insert(topic.name);
    }
    std::set<std::string> others = seen_;
    std::erase_if(others, [&](const std::string& name) { return recorded.contains(name); });
    if (recorded.empty() && others.empty()) {
      return "no topic was published by any other node";
    }
    return (recorded.empty() ? "no such topic was published"
                             : "no message came on " + joined(recorded)) +
           (others.empty() ? "" : "; published were " + joined(others));
  }

  void find_topics() {
    if (!graph_changes_) {
      return;  // the recording has ended
    }
    struct Found {
      std::set<std::string> types;
      std::vector<QoS> offered;
    };
    std::map<std::string, Found> found;
    for (const auto& endpoint : recorder_.context().graph().endpoints()) {
      const auto topic = demangle_topic_name(endpoint.wire_topic);
      const auto type = demangle_type_name(endpoint.wire_type);
      if (!endpoint.is_publisher || !topic || topic->kind != DdsTopicKind::kTopic || !type ||
          endpoint.node == recorder_.node_name()) {
        continue;
      }
      seen_.insert(topic->name);
      if (!settings_.selection.selects(topic->name)) {
        continue;
      }
      found[topic->name].types.insert(*type);
      found[topic->name].offered.push_back(endpoint.qos);
    }
    for (const auto& [name, topic] : found) {
      const auto known = subscriptions_.find(name);
      if (known != subscriptions_.end()) {
        warn_of_incompatible(name, topic.offered, known->second.untyped()->qos());
      } else if (topic.types.size() > 1) {
        warn_once(name, "topic '" + name + "' has several types, " + joined(topic.types) +
                            ", and is not recorded");
      } else {
        subscribe(name, *topic.types.begin(), topic.offered);
      }
    }
  }

  void subscribe(const std::string& name, const std::string& type,
                 const std::vector<QoS>& offered) {
    const auto override = settings_.qos_overrides.find(name);
    const QoS qos =
        override != settings_.qos_overrides.end() ? override->second : request_for(offered, kDepth);
    const auto known = std::find_if(topics_.begin(), topics_.end(),
                                    [&](const Topic& topic) { return topic.name == name; });
    if (known != topics_.end()) {
      return;  // its subscription could not be made
    }
    auto& topic = topics_.emplace_back(name, queue_.add_topic(make_bag_topic(name, type, offered)));
    topic.tells_of_progress = tells_of_progress(name);
    if (const auto thinned = settings_.thinning.find(name); thinned != settings_.thinning.end()) {
      topic.has_header = begins_with_header(find_message_type(type));
      topic.thinning.emplace(thinned->second);
    }
    try {
      subscriptions_.emplace(
          name, recorder_.create_generic_subscription(
                    name, type, qos,
                    [this, &topic](const std::shared_ptr<const SerializedMessage>& message,
                                   const MessageInfo& info) { take(topic, message, info); },
                    // Unmanaged: what latched topics have kept comes at once, while the component
                    // is still being activated.
                    {.managed = false, .at_once = true}));
      recorder_.logger().info("recording '" + name + "' [" + type + "]");
      warn_of_incompatible(name, offered, qos);
    } catch (const std::runtime_error& error) {
      warn_once(name, "topic '" + name + "' is not recorded: " + error.what());
    }
  }

  /// On whatever thread publishes or receives.
  void take(Topic& topic, const std::shared_ptr<const SerializedMessage>& message,
            const MessageInfo& info) {
    std::int64_t log_time = info.reception_time.time_since_epoch().count();
    std::int64_t publish_time = info.source_time.time_since_epoch().count();
    if (settings_.simulated_time()) {
      // The time of publication is this machine's: it would only make two equal missions differ.
      log_time = recorder_.now().time_since_epoch().count();
      publish_time = log_time;
    }
    if (topic.tells_of_progress) {
      ++messages_;
    }
    if (!is_due(topic, *message, log_time) ||
        queue_.push(topic.index, log_time, publish_time, message)) {
      return;
    }
    recorder_.diagnostics().count("dropped." + topic.name);
    if (!topic.dropped.exchange(true)) {
      // Not here: what is logged is published too, and this may be the recording of that.
      post([this, name = topic.name] {
        recorder_.logger().warn("messages of topic '" + name +
                                "' are dropped: the disk is slower than the publishers, and the "
                                "cache of max_cache_size is full");
      });
    }
  }

  void warn_of_incompatible(const std::string& name, const std::vector<QoS>& offered,
                            const QoS& requested) {
    for (const QoS& offer : offered) {
      if (const auto policy = incompatibility(offer, requested)) {
        warn_once(name, "topic '" + name +
                            "': a publisher offers a QoS that does not go with what " +
                            "the recording asks for (" + to_string(*policy) +
                            "); its messages are not recorded");
        return;
      }
    }
  }

  void warn_once(const std::string& name, const std::string& text) {
    if (warned_.insert(name).second) {
      recorder_.diagnostics().count("not_recorded." + name);
      recorder_.logger().warn(text);
    }
  }

  BagRecorder& recorder_;
  const RecorderSettings& settings_;
  const std::shared_ptr<bool> alive_ = std::make_shared<bool>(true);
  std::atomic<bool> is_looking_{false};
  std::deque<Topic> topics_;  // addresses are kept by callbacks
  std::set<std::string> warned_;
  std::set<std::string> seen_;              // topics that others have published
  std::atomic<std::uint64_t> messages_{0};  // that tell of progress
  std::uint64_t messages_before_ = 0;       // when it was last looked at
  int silent_looks_ = 0;
  int settles_ = 0;
  bool has_ended_ = false;   // complete or failed, as far as the source is concerned
  bool has_failed_ = false;  // and that was reported
  Publisher<WriteSplitEvent> split_events_;
  Publisher<diagnostic_msgs::msg::DiagnosticArray> diagnostics_;
  const std::filesystem::path folder_;
  RecordingQueue queue_;
  std::map<std::string, GenericSubscription> subscriptions_;  // before the queue ends
  std::shared_ptr<Timer> statistics_timer_;
  Subscription<MissionStatus> status_subscription_;
  std::optional<Timer> settle_timer_;
  std::optional<Timer> silence_timer_;
  std::shared_ptr<void> graph_changes_;
};

BagRecorder::BagRecorder(ComponentOptions options)
    : Component(std::move(options)), settings_(std::make_unique<RecorderSettings>(parameters())) {
  snapshot_service_ = create_service<Snapshot>(
      "~/snapshot", [this](const Snapshot::Request&, Snapshot::Response& response) {
        response.success = recording_ != nullptr && recording_->take_snapshot();
      });
}

BagRecorder::~BagRecorder() = default;

CallbackReturn BagRecorder::on_configure() {
  try {
    settings_->read(node_name());
  } catch (const std::exception& error) {
    diagnostics().set_status(DiagnosticLevel::kError, error.what());
    return CallbackReturn::kFailure;
  }
  return CallbackReturn::kSuccess;
}

CallbackReturn BagRecorder::on_activate() {
  try {
    recording_ = std::make_unique<Recording>(*this, *settings_);
  } catch (const std::exception& error) {
    diagnostics().set_status(DiagnosticLevel::kError, error.what());
    return CallbackReturn::kFailure;
  }
  return CallbackReturn::kSuccess;
}

CallbackReturn BagRecorder::on_deactivate() {
  recording_.reset();
  return CallbackReturn::kSuccess;
}

CallbackReturn BagRecorder::on_cleanup() {
  recording_.reset();
  return CallbackReturn::kSuccess;
}

CallbackReturn BagRecorder::on_shutdown() {
  recording_.reset();
  return CallbackReturn::kSuccess;
}

}  // namespace pipescout

PIPESCOUT_REGISTER_COMPONENT(pipescout::BagRecorder)
