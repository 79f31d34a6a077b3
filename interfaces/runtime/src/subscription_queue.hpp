// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <deque>
#include <memory>
#include <mutex>
#include <optional>

#include "endpoint_events.hpp"
#include "pipescout/runtime/context.hpp"
#include "pipescout/runtime/subscription.hpp"

namespace pipescout {

/// The receiving half of a subscription: its bounded queue and its events. Shared by the handle,
/// the publishers that deliver into it and the executor, so that any of them may go first.
class SubscriptionQueue final : public Waitable,
                                public TransportReaderListener,
                                public std::enable_shared_from_this<SubscriptionQueue> {
 public:
  explicit SubscriptionQueue(SubscriptionOptions options);

  /// Second part of construction: needs shared_from_this.
  void start();
  /// No callback begins any more. Without a callback group the caller has made sure that no
  /// publisher and no transport delivers any more.
  void close();

  /// `expiry`: when the message becomes too old to deliver.
  void receive(std::shared_ptr<const void> message, const MessageInfo& info,
               std::optional<SteadyTime> expiry);
  void set_enabled(bool enabled);

  void local_publisher_matched(bool alive);
  void local_publisher_unmatched(bool alive);
  void local_publisher_liveliness(bool alive);
  void incompatible(QosPolicy policy);

  [[nodiscard]] std::size_t publisher_count() const;
  [[nodiscard]] int remote_publisher_count() const;
  [[nodiscard]] int local_publisher_count() const;
  [[nodiscard]] LivelinessChange liveliness() const;
  [[nodiscard]] SubscriptionStatistics statistics() const;
  [[nodiscard]] const SubscriptionOptions& options() const noexcept { return options_; }

  void execute() override;

  void on_remote_message(std::shared_ptr<const void> message, const MessageInfo& info) override;
  void on_malformed_sample(const SampleIdentity& sample) override;
  void on_overwritten_sample(const SampleIdentity& sample) override;
  void on_samples_lost(int count) override;
  void on_remote_writers_changed(int matched) override;
  void on_incompatible_remote_writer(QosPolicy policy) override;
  void on_remote_liveliness_changed(LivelinessChange now) override;

 private:
  struct Item {
    std::shared_ptr<const void> message;
    MessageInfo info;
    std::optional<SteadyTime> expiry;
  };

  /// Counts a message that came. Under mutex_.
  void count(const void* message);
  void deliver_at_once(const std::shared_ptr<const void>& message, const MessageInfo& info);

  // Under mutex_.
  [[nodiscard]] LivelinessChange total_liveliness() const;
  [[nodiscard]] std::size_t matched_publishers() const;
  [[nodiscard]] bool is_expired(const Item& item) const;

  const SubscriptionOptions options_;
  const std::optional<std::size_t> stamp_offset_;  // of a builtin_interfaces/Time in the message
  std::shared_ptr<CountedEvent> lost_;
  std::shared_ptr<CountedEvent> malformed_;
  std::shared_ptr<CountedEvent> deadline_missed_;
  std::shared_ptr<LatestEvent<LivelinessChange>> liveliness_changed_;
  std::optional<IncompatibleQosEvent> incompatible_qos_;
  std::shared_ptr<LatestEvent<std::size_t>> matched_;
  std::shared_ptr<Watchdog> deadline_;

  mutable std::mutex mutex_;
  std::deque<Item> queue_;
  bool enabled_;
  bool closed_ = false;
  bool scheduled_ = false;
  LivelinessChange local_liveliness_;
  LivelinessChange remote_liveliness_;
  int remote_publishers_ = 0;
  SubscriptionStatistics statistics_;
};

}  // namespace pipescout
