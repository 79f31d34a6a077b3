// SPDX-License-Identifier: Apache-2.0
#include "run/export_relay.hpp"

#include <atomic>
#include <optional>
#include <utility>

#include "core/image_shrink.hpp"
#include "pipescout/runtime/diagnostics.hpp"

namespace pipescout::host {
namespace {

constexpr const char* kImageType = "sensor_msgs/msg/Image";

/// What is exported reduced is for people: only the newest counts.
constexpr QoS kReducedQos = QoS::sensor_data(1);

struct Publishers {
  std::string type;
  std::vector<QoS> offered;
};

std::map<std::string, Publishers> publishers_by_topic(const Graph& graph) {
  std::map<std::string, Publishers> result;
  for (const auto& endpoint : graph.endpoints()) {
    const auto topic = demangle_topic_name(endpoint.wire_topic);
    if (!endpoint.is_publisher || !topic || topic->kind != DdsTopicKind::kTopic) {
      continue;
    }
    auto& publishers = result[topic->name];
    publishers.type = demangle_type_name(endpoint.wire_type).value_or(endpoint.wire_type);
    publishers.offered.push_back(endpoint.qos);
  }
  return result;
}

}  // namespace

/// One topic, at a lower rate or with smaller images.
class ExportRelay::Reduced {
 public:
  Reduced(Node& node, const std::shared_ptr<CallbackGroup>& group, const ExportEntry& entry,
          const Publishers& publishers)
      : entry_(entry) {
    const auto requested = request_for(publishers.offered, 1);
    NodePublisherOptions publisher;
    publisher.group = group;
    NodeSubscriptionOptions subscription;
    subscription.group = group;
    if (entry.shrink > 1) {
      images_ = node.create_publisher<sensor_msgs::msg::Image>(entry.as, kReducedQos, publisher);
      image_subscription_ = node.create_subscription<sensor_msgs::msg::Image>(
          entry.topic, requested, [this](const sensor_msgs::msg::Image& image) { take(image); },
          subscription);
    } else {
      messages_ = node.create_generic_publisher(entry.as, publishers.type, kReducedQos, publisher);
      subscription_ = node.create_generic_subscription(
          entry.topic, publishers.type, requested,
          [this](const std::shared_ptr<const SerializedMessage>& message) {
            if (is_due()) {
              messages_.publish(message);
            }
          },
          subscription);
    }
  }

  /// Of an image that cannot be shrunk.
  [[nodiscard]] bool has_failed() const { return has_failed_; }

 private:
  void take(const sensor_msgs::msg::Image& image) {
    if (!is_due()) {
      return;
    }
    auto smaller = shrink(image, entry_.shrink);
    has_failed_ = !smaller;
    if (smaller) {
      images_.publish(std::move(*smaller));
    }
  }

  bool is_due() {
    if (!entry_.rate) {
      return true;
    }
    const SteadyTime now = steady_now();
    const Duration period = from_seconds(1.0 / *entry_.rate);
    if (next_ && now < *next_) {
      return false;
    }
    // Keeps the mean rate where messages come at another one, without a burst after a pause.
    next_ = next_ && now - *next_ < period ? *next_ + period : now + period;
    return true;
  }

  const ExportEntry entry_;
  std::optional<SteadyTime> next_;
  std::atomic<bool> has_failed_{false};
  Publisher<sensor_msgs::msg::Image> images_;
  Subscription<sensor_msgs::msg::Image> image_subscription_;
  GenericPublisher messages_;
  GenericSubscription subscription_;
};

ExportRelay::ExportRelay(Node& node, std::vector<ExportEntry> exports)
    : node_(node),
      exports_(std::move(exports)),
      group_(node.create_callback_group(CallbackGroupType::kMutuallyExclusive)) {}

ExportRelay::~ExportRelay() = default;

void ExportRelay::look() {
  const auto published = publishers_by_topic(node_.context().graph());
  silent_.clear();
  for (const auto& entry : exports_) {
    const auto found = published.find(entry.topic);
    if (found == published.end()) {
      silent_.push_back("nobody publishes " + entry.topic + " (" + entry.location + ")");
      continue;
    }
    if (entry.as.empty() || reduced_.contains(entry.as)) {
      continue;
    }
    if (entry.shrink > 1 && found->second.type != kImageType) {
      silent_.push_back(entry.topic + " (" + entry.location + ") is of type " + found->second.type +
                        ", which cannot be shrunk: only " + kImageType);
      continue;
    }
    try {
      reduced_.emplace(entry.as, std::make_unique<Reduced>(node_, group_, entry, found->second));
    } catch (const std::exception& error) {
      silent_.push_back(entry.topic + " (" + entry.location + "): " + error.what());
    }
  }
}

diagnostic_msgs::msg::DiagnosticStatus ExportRelay::status() const {
  diagnostic_msgs::msg::DiagnosticStatus status;
  status.name = node_.node_name().fully_qualified().substr(1) + ": export";
  status.hardware_id = "none";
  auto sentences = silent_;
  for (const auto& [name, reduced] : reduced_) {
    if (reduced->has_failed()) {
      sentences.push_back("the images of " + name +
                          " cannot be shrunk: their encoding or size does not allow it");
    }
  }
  for (const auto& sentence : sentences) {
    status.message += (status.message.empty() ? "" : "; ") + sentence;
  }
  status.level =
      static_cast<std::uint8_t>(sentences.empty() ? DiagnosticLevel::kOk : DiagnosticLevel::kWarn);
  return status;
}

}  // namespace pipescout::host
