// SPDX-License-Identifier: Apache-2.0
#include "diagnostics_publisher.hpp"

#include <algorithm>
#include <array>
#include <diagnostic_msgs/msg/diagnostic_array.hpp>
#include <map>
#include <mutex>
#include <string>
#include <utility>
#include <vector>

#include "endpoint_name.hpp"
#include "input_watch.hpp"
#include "pipescout/runtime/conversions.hpp"
#include "pipescout/runtime/severity.hpp"
#include "pipescout/runtime/standard_topics.hpp"

namespace pipescout {

namespace {

constexpr Duration kPeriod = std::chrono::seconds(1);
/// A message names this many losses; the values have them all.
constexpr std::size_t kNamedLosses = 3;

/// A total that an endpoint keeps. Those that are no fault (the component was not active, the
/// publisher let its messages expire) are shown, but warn of nothing.
template <class Statistics>
struct Total {
  std::string_view name;
  std::uint64_t Statistics::*member;
  bool is_fault;
};

constexpr std::array kPublisherTotals{
    Total<PublisherStatistics>{"send_failures", &PublisherStatistics::send_failures, true},
    Total<PublisherStatistics>{"deadlines_missed", &PublisherStatistics::deadlines_missed, true},
    Total<PublisherStatistics>{"liveliness_lost", &PublisherStatistics::liveliness_lost, true},
    Total<PublisherStatistics>{"incompatible_qos", &PublisherStatistics::incompatible_qos, true},
    Total<PublisherStatistics>{"suppressed", &PublisherStatistics::suppressed, false},
};

constexpr std::array kSubscriptionTotals{
    Total<SubscriptionStatistics>{"dropped_queue_full", &SubscriptionStatistics::dropped_queue_full,
                                  true},
    Total<SubscriptionStatistics>{"lost_by_network", &SubscriptionStatistics::lost_by_network,
                                  true},
    Total<SubscriptionStatistics>{"malformed", &SubscriptionStatistics::malformed, true},
    Total<SubscriptionStatistics>{"deadlines_missed", &SubscriptionStatistics::deadlines_missed,
                                  true},
    Total<SubscriptionStatistics>{"incompatible_qos", &SubscriptionStatistics::incompatible_qos,
                                  true},
    Total<SubscriptionStatistics>{"expired", &SubscriptionStatistics::expired, false},
    Total<SubscriptionStatistics>{"dropped_inactive", &SubscriptionStatistics::dropped_inactive,
                                  false},
};

constexpr std::array kServiceTotals{
    Total<ServiceStatistics>{"responses_dropped", &ServiceStatistics::responses_dropped, true},
};

/// What a server rejects is the client's affair, or the operator's.
constexpr std::array kActionTotals{
    Total<ActionServerStatistics>{"dropped", &ActionServerStatistics::dropped, true},
    Total<ActionServerStatistics>{"results_lost", &ActionServerStatistics::results_lost, true},
    Total<ActionServerStatistics>{"rejected", &ActionServerStatistics::rejected, false},
};

/// A late reply is no fault: a call that timed out has been counted, and of several servers all but
/// the first are late.
constexpr std::array kClientTotals{
    Total<ClientStatistics>{"without_server", &ClientStatistics::without_server, true},
    Total<ClientStatistics>{"server_gone", &ClientStatistics::server_gone, true},
    Total<ClientStatistics>{"timed_out", &ClientStatistics::timed_out, true},
    Total<ClientStatistics>{"refused", &ClientStatistics::refused, true},
    Total<ClientStatistics>{"late_replies", &ClientStatistics::late_replies, false},
};

std::string ros_name(const UntypedActionServer& server) {
  return server.name();
}

diagnostic_msgs::msg::KeyValue key_value(const std::string& key, const std::string& value) {
  diagnostic_msgs::msg::KeyValue pair;
  pair.key = key;
  pair.value = value;
  return pair;
}

}  // namespace

class DiagnosticsPublisher::Impl {
 public:
  explicit Impl(Component& component) : component_(component), inputs_(component) {
    publisher_ = component.create_publisher(topics::kDiagnostics, {.managed = false});
    timer_ = component.create_timer(kPeriod, [this] { publish(); }, {.managed = false});
  }

  void configure() {
    const std::lock_guard lock(mutex_);
    inputs_.configure();
  }

  void publish() {
    // Outlives the lock: this may become the last owner of a client, whose end calls back.
    const auto clients = component_.clients();
    const std::lock_guard lock(mutex_);
    Diagnostics::Snapshot snapshot = component_.diagnostics().take();
    add_endpoints(snapshot, clients);
    add_transforms(snapshot);
    add_inputs(snapshot);

    diagnostic_msgs::msg::DiagnosticStatus status;
    status.level = static_cast<std::uint8_t>(snapshot.level);
    status.name = component_.node_name().fully_qualified().substr(1) + ": status";
    status.hardware_id = "none";
    status.message = snapshot.message;
    status.values.push_back(
        key_value("lifecycle_state", std::string(to_string(component_.state()))));
    for (const auto& [key, value] : snapshot.values) {
      status.values.push_back(key_value(key, value));
    }
    diagnostic_msgs::msg::DiagnosticArray array;
    array.header.stamp = to_message(component_.now());
    array.status.push_back(std::move(status));
    add_transport(array);
    publisher_.publish(std::move(array));
  }

 private:
  /// What the transport of the process cannot do as it was meant to.
  void add_transport(diagnostic_msgs::msg::DiagnosticArray& array) const {
    const Transport* transport = component_.context().transport();
    if (transport == nullptr) {
      return;
    }
    std::string message;
    for (const std::string& warning : transport->warnings()) {
      message += (message.empty() ? "" : "; ") + warning;
    }
    if (message.empty()) {
      return;
    }
    diagnostic_msgs::msg::DiagnosticStatus status;
    status.level = static_cast<std::uint8_t>(DiagnosticLevel::kWarn);
    status.name = component_.node_name().fully_qualified().substr(1) + ": transport";
    status.hardware_id = "none";
    status.message = std::move(message);
    array.status.push_back(std::move(status));
  }

  /// Endpoint and total. Each endpoint counts for itself: a new one on the same topic starts at
  /// zero again, also where an old one was in memory.
  struct TotalKey {
    std::weak_ptr<const void> endpoint;
    std::string_view total;
    bool operator<(const TotalKey& other) const {
      const bool before = endpoint.owner_before(other.endpoint);
      return before || (!other.endpoint.owner_before(endpoint) && total < other.total);
    }
  };

  struct Losses {
    std::map<std::string, std::uint64_t> totals;  // all that are not zero, by the key to publish
    std::map<std::string, std::uint64_t> growth;  // of the faults
    std::map<TotalKey, std::uint64_t> seen;
  };

  /// `endpoint`: whose identity and name the totals go under.
  template <class Endpoint, class Statistics, class Totals>
  void add_totals(const std::shared_ptr<Endpoint>& endpoint, const Statistics& statistics,
                  std::string_view kind, const Totals& kinds, Losses& losses) const {
    for (const auto& kind_of_total : kinds) {
      const std::uint64_t total = statistics.*kind_of_total.member;
      if (total == 0) {
        continue;
      }
      const std::string key =
          std::string(kind) + " " + ros_name(*endpoint) + ": " + std::string(kind_of_total.name);
      losses.totals[key] += total;
      const TotalKey total_key{endpoint, kind_of_total.name};
      losses.seen[total_key] = total;
      const auto before = seen_.find(total_key);
      const std::uint64_t growth = total - (before == seen_.end() ? 0 : before->second);
      if (kind_of_total.is_fault && growth > 0) {
        losses.growth[key] += growth;
      }
    }
  }

  void add_endpoint(const std::shared_ptr<UntypedPublisher>& publisher, std::string_view kind,
                    Losses& losses) const {
    add_totals(publisher, publisher->statistics(), kind, kPublisherTotals, losses);
  }
  void add_endpoint(const std::shared_ptr<UntypedSubscription>& subscription, std::string_view kind,
                    Losses& losses) const {
    add_totals(subscription, subscription->statistics(), kind, kSubscriptionTotals, losses);
  }

  void add_endpoints(Diagnostics::Snapshot& snapshot,
                     const std::vector<std::shared_ptr<UntypedClient>>& clients) {
    Losses losses;
    for (const auto& publisher : component_.publishers()) {
      add_endpoint(publisher, "publisher", losses);
    }
    for (const auto& subscription : component_.subscriptions()) {
      add_endpoint(subscription, "subscription", losses);
    }
    for (const auto& service : component_.services()) {
      add_endpoint(service->reply_publisher(), "service", losses);
      add_endpoint(service->request_subscription(), "service", losses);
      add_totals(service->request_subscription(), service->statistics(), "service", kServiceTotals,
                 losses);
    }
    for (const auto& server : component_.action_servers()) {
      add_totals(server, server->statistics(), "action", kActionTotals, losses);
    }
    for (const auto& client : clients) {
      add_endpoint(client->request_publisher(), "client", losses);
      add_endpoint(client->reply_subscription(), "client", losses);
      add_totals(client->request_publisher(), client->statistics(), "client", kClientTotals,
                 losses);
    }
    for (const auto& [key, total] : losses.totals) {
      snapshot.values.insert_or_assign(key, std::to_string(total));
    }
    seen_ = std::move(losses.seen);
    if (losses.growth.empty()) {
      return;
    }
    std::string message;
    std::size_t named = 0;
    for (const auto& [key, growth] : losses.growth) {
      if (named == kNamedLosses) {
        message += ", and " + std::to_string(losses.growth.size() - named) + " more";
        break;
      }
      message += (named == 0 ? "" : ", ") + key + " +" + std::to_string(growth);
      ++named;
    }
    if (snapshot.level == DiagnosticLevel::kOk || snapshot.message.empty()) {
      snapshot.message = std::move(message);
    } else {
      snapshot.message += "; " + message;
    }
    snapshot.level = worse(snapshot.level, DiagnosticLevel::kWarn);
  }

  /// The transforms that were refused; a warning while one is.
  void add_transforms(Diagnostics::Snapshot& snapshot) {
    const Transforms* const transforms = component_.transforms_in_use();
    if (transforms == nullptr) {
      return;
    }
    const TransformStatistics statistics = transforms->statistics();
    std::uint64_t refused = 0;
    for (const auto& [fault, total] : statistics.refused) {
      refused += total;
      snapshot.values.insert_or_assign("tf.refused." + std::string(to_string(fault)),
                                       std::to_string(total));
    }
    if (const std::uint64_t growth = refused - std::exchange(transforms_refused_, refused);
        growth > 0) {
      snapshot.message += (snapshot.message.empty() ? "tf.refused +" : "; tf.refused +") +
                          std::to_string(growth) + ": " + statistics.last_refused;
      snapshot.level = worse(snapshot.level, DiagnosticLevel::kWarn);
    }
  }

  /// Rate and age of the inputs that are watched, and what is wrong with them.
  void add_inputs(Diagnostics::Snapshot& snapshot) {
    for (const InputReport& report : inputs_.look()) {
      for (const auto& [name, value] : report.values) {
        snapshot.values.insert_or_assign("input " + report.topic + ": " + name, value);
      }
      if (report.level == DiagnosticLevel::kOk) {
        continue;
      }
      const std::string message = "input " + report.topic + " " + report.message;
      if (snapshot.level == DiagnosticLevel::kOk || snapshot.message.empty()) {
        snapshot.message = message;
      } else {
        snapshot.message += "; " + message;
      }
      snapshot.level = worse(snapshot.level, report.level);
    }
  }

  Component& component_;
  InputWatch inputs_;
  Publisher<diagnostic_msgs::msg::DiagnosticArray> publisher_;
  std::mutex mutex_;  // publishing is in the order of taking
  std::map<TotalKey, std::uint64_t> seen_;
  std::uint64_t transforms_refused_ = 0;
  std::shared_ptr<Timer> timer_;
};

DiagnosticsPublisher::DiagnosticsPublisher(Component& component)
    : impl_(std::make_shared<Impl>(component)) {
  // Through the executor: whoever changes the level may hold locks of its own.
  component.diagnostics().on_level_changed(
      [impl = std::weak_ptr(impl_), group = std::weak_ptr(component.default_group())] {
        if (const auto open = group.lock()) {
          open->post([impl] {
            if (const auto alive = impl.lock()) {
              alive->publish();
            }
          });
        }
      });
}

DiagnosticsPublisher::~DiagnosticsPublisher() = default;

void DiagnosticsPublisher::configure() {
  impl_->configure();
}

void DiagnosticsPublisher::publish_now() {
  impl_->publish();
}

}  // namespace pipescout
