// SPDX-License-Identifier: Apache-2.0
#include "subscription_queue.hpp"

#include <builtin_interfaces/msg/time.hpp>
#include <stdexcept>
#include <string_view>
#include <utility>

#include "pipescout/idl/field_access.hpp"
#include "pipescout/runtime/conversions.hpp"

namespace pipescout {

namespace {

/// Where the single message field of that name is, when it has one.
const MessageField* message_field(const MessageType& type, std::string_view name) {
  const MessageField* const field = find_field(type, name);
  return field != nullptr && field->kind == FieldKind::kMessage &&
                 field->shape == FieldShape::kSingle
             ? field
             : nullptr;
}

/// Of `header.stamp`, or of `stamp`.
std::optional<std::size_t> stamp_offset(const MessageType& type) {
  const MessageField* const header = message_field(type, "header");
  const MessageField* const stamp =
      message_field(header != nullptr ? header->message() : type, "stamp");
  if (stamp == nullptr || &stamp->message() != &message_type<builtin_interfaces::msg::Time>()) {
    return std::nullopt;
  }
  return (header != nullptr ? header->offset : 0) + stamp->offset;
}

}  // namespace

SubscriptionQueue::SubscriptionQueue(SubscriptionOptions options)
    : options_(std::move(options)),
      stamp_offset_(options_.topic.type != nullptr ? stamp_offset(*options_.topic.type)
                                                   : std::nullopt),
      enabled_(options_.enabled) {}

void SubscriptionQueue::start() {
  const auto& events = options_.events;
  const auto& group = options_.group;
  if (!group && (events.deadline_missed || events.liveliness_changed || events.incompatible_qos ||
                 events.message_lost || events.message_malformed || events.matched)) {
    throw std::invalid_argument("subscription of " + options_.topic.name +
                                ": events need a callback group");
  }
  lost_ = std::make_shared<CountedEvent>(group, events.message_lost);
  malformed_ = std::make_shared<CountedEvent>(group, events.message_malformed);
  deadline_missed_ = std::make_shared<CountedEvent>(group, events.deadline_missed);
  liveliness_changed_ =
      std::make_shared<LatestEvent<LivelinessChange>>(group, events.liveliness_changed);
  incompatible_qos_.emplace(group, events.incompatible_qos);
  matched_ = std::make_shared<LatestEvent<std::size_t>>(group, events.matched);
  if (options_.qos.deadline && group) {
    deadline_ = std::make_shared<Watchdog>(
        group, *options_.qos.deadline, Watchdog::Lapse::kEachPeriod,
        [missed = deadline_missed_](std::uint64_t periods) { missed->add(periods); });
  }
}

void SubscriptionQueue::close() {
  std::deque<Item> dropped;
  {
    const std::lock_guard lock(mutex_);
    closed_ = true;
    dropped.swap(queue_);
    if (deadline_) {
      deadline_->stop();
    }
  }
  lost_->close();
  malformed_->close();
  deadline_missed_->close();
  liveliness_changed_->close();
  incompatible_qos_->close();
  matched_->close();
}

void SubscriptionQueue::receive(std::shared_ptr<const void> message, const MessageInfo& info,
                                std::optional<SteadyTime> expiry) {
  if (!options_.group) {
    deliver_at_once(message, info);
    return;
  }
  Item evicted;  // destroyed after the lock is released
  bool lost = false;
  bool schedule = false;
  {
    const std::lock_guard lock(mutex_);
    if (closed_) {
      return;
    }
    count(message.get());
    if (!enabled_ && options_.while_inactive == WhileInactive::kDrop) {
      ++statistics_.dropped_inactive;
      return;
    }
    if (queue_.size() >= options_.qos.depth) {
      evicted = std::move(queue_.front());
      queue_.pop_front();
      lost = enabled_;
      ++(enabled_ ? statistics_.dropped_queue_full : statistics_.dropped_inactive);
    }
    queue_.push_back({std::move(message), info, expiry});
    schedule = enabled_ && !std::exchange(scheduled_, true);
    if (deadline_ && enabled_) {
      deadline_->touch();
    }
  }
  if (lost) {
    lost_->add();
  }
  if (schedule) {
    options_.group->schedule(shared_from_this());
  }
}

void SubscriptionQueue::count(const void* message) {
  ++statistics_.received;
  if (stamp_offset_) {
    statistics_.last_stamp = from_message(*reinterpret_cast<const builtin_interfaces::msg::Time*>(
        static_cast<const std::byte*>(message) + *stamp_offset_));
  }
}

void SubscriptionQueue::deliver_at_once(const std::shared_ptr<const void>& message,
                                        const MessageInfo& info) {
  {
    const std::lock_guard lock(mutex_);
    if (closed_) {
      return;
    }
    count(message.get());
    if (!enabled_) {
      ++statistics_.dropped_inactive;
      return;
    }
    ++statistics_.delivered;
  }
  options_.callback(message, info);
}

bool SubscriptionQueue::is_expired(const Item& item) const {
  return item.expiry && steady_now() > *item.expiry;
}

void SubscriptionQueue::execute() {
  Item item;
  bool more = false;
  {
    const std::lock_guard lock(mutex_);
    if (!enabled_ || closed_ || queue_.empty()) {
      scheduled_ = false;
      return;
    }
    item = std::move(queue_.front());
    queue_.pop_front();
    more = !queue_.empty();
    scheduled_ = more;
    if (is_expired(item)) {
      ++statistics_.expired;
      item.message.reset();
    } else {
      ++statistics_.delivered;
    }
  }
  if (more) {
    // Behind the other work of the group: a busy topic does not starve a quiet one.
    options_.group->schedule(shared_from_this());
  }
  if (item.message) {
    options_.callback(item.message, item.info);
  }
}

void SubscriptionQueue::set_enabled(bool enabled) {
  std::deque<Item> dropped;  // destroyed after the lock is released
  bool schedule = false;
  {
    const std::lock_guard lock(mutex_);
    enabled_ = enabled;
    if (!enabled && options_.while_inactive == WhileInactive::kDrop) {
      dropped.swap(queue_);
      statistics_.dropped_inactive += dropped.size();
    }
    schedule = enabled_ && !closed_ && !queue_.empty() && !std::exchange(scheduled_, true);
    if (!enabled && deadline_) {
      deadline_->stop();
    }
  }
  if (schedule) {
    options_.group->schedule(shared_from_this());
  }
}

LivelinessChange SubscriptionQueue::total_liveliness() const {
  return {local_liveliness_.alive + remote_liveliness_.alive,
          local_liveliness_.not_alive + remote_liveliness_.not_alive};
}

std::size_t SubscriptionQueue::matched_publishers() const {
  return static_cast<std::size_t>(local_liveliness_.alive + local_liveliness_.not_alive +
                                  remote_publishers_);
}

void SubscriptionQueue::local_publisher_matched(bool alive) {
  const std::lock_guard lock(mutex_);
  ++(alive ? local_liveliness_.alive : local_liveliness_.not_alive);
  liveliness_changed_->set(total_liveliness());
  matched_->set(matched_publishers());
}

void SubscriptionQueue::local_publisher_unmatched(bool alive) {
  const std::lock_guard lock(mutex_);
  --(alive ? local_liveliness_.alive : local_liveliness_.not_alive);
  liveliness_changed_->set(total_liveliness());
  matched_->set(matched_publishers());
}

void SubscriptionQueue::local_publisher_liveliness(bool alive) {
  const std::lock_guard lock(mutex_);
  local_liveliness_.alive += alive ? 1 : -1;
  local_liveliness_.not_alive += alive ? -1 : 1;
  liveliness_changed_->set(total_liveliness());
}

void SubscriptionQueue::incompatible(QosPolicy policy) {
  incompatible_qos_->add(policy);
}

std::size_t SubscriptionQueue::publisher_count() const {
  const std::lock_guard lock(mutex_);
  return matched_publishers();
}

int SubscriptionQueue::local_publisher_count() const {
  const std::lock_guard lock(mutex_);
  return local_liveliness_.alive + local_liveliness_.not_alive;
}

int SubscriptionQueue::remote_publisher_count() const {
  const std::lock_guard lock(mutex_);
  return remote_publishers_;
}

LivelinessChange SubscriptionQueue::liveliness() const {
  const std::lock_guard lock(mutex_);
  return total_liveliness();
}

SubscriptionStatistics SubscriptionQueue::statistics() const {
  const std::lock_guard lock(mutex_);
  SubscriptionStatistics statistics = statistics_;
  statistics.deadlines_missed = deadline_missed_->total();
  statistics.incompatible_qos = incompatible_qos_->total();
  return statistics;
}

void SubscriptionQueue::on_remote_message(std::shared_ptr<const void> message,
                                          const MessageInfo& info) {
  // The transport itself drops what is past its lifespan.
  receive(std::move(message), info, std::nullopt);
}

void SubscriptionQueue::on_malformed_sample(const SampleIdentity&) {
  {
    const std::lock_guard lock(mutex_);
    ++statistics_.malformed;
  }
  malformed_->add();
}

void SubscriptionQueue::on_overwritten_sample(const SampleIdentity&) {
  on_samples_lost(1);
}

void SubscriptionQueue::on_samples_lost(int count) {
  if (count <= 0) {
    return;
  }
  {
    const std::lock_guard lock(mutex_);
    statistics_.lost_by_network += static_cast<std::uint64_t>(count);
  }
  lost_->add(static_cast<std::uint64_t>(count));
}

void SubscriptionQueue::on_remote_writers_changed(int matched) {
  const std::lock_guard lock(mutex_);
  remote_publishers_ = matched;
  matched_->set(matched_publishers());
}

void SubscriptionQueue::on_incompatible_remote_writer(QosPolicy policy) {
  incompatible(policy);
}

void SubscriptionQueue::on_remote_liveliness_changed(LivelinessChange now) {
  const std::lock_guard lock(mutex_);
  remote_liveliness_ = now;
  liveliness_changed_->set(total_liveliness());
}

}  // namespace pipescout
