// SPDX-License-Identifier: Apache-2.0
#include "shared_reader.hpp"

#include <exception>
#include <utility>

#include "lossless_reader.hpp"
#include "pipescout/runtime/serialized_message.hpp"

namespace pipescout {

SharedReader::SharedReader(Transport& transport, const WireTopic& topic, const QoS& qos,
                           std::shared_ptr<StepTraffic> traffic,
                           std::shared_ptr<TransportReaderListener> first)
    : topic_(topic.name),
      type_(topic.type),
      qos_(qos),
      traffic_(std::move(traffic)),
      subscriptions_{std::move(first)} {
  if (qos.reliability == Reliability::kBestEffort && qos.durability == Durability::kVolatile &&
      traffic_->is_enabled()) {
    TransportReaderListener& self = *this;
    reader_ = std::make_unique<LosslessReader>(transport, topic, qos, self);
  } else {
    reader_ = transport.create_reader(topic, qos, *this);
  }
  gid_ = reader_->gid();
}

bool SharedReader::serves(const WireTopic& topic, const QoS& qos) const {
  return topic_ == topic.name && type_->dds_name == topic.type->dds_name &&
         is_serialized(*type_) == is_serialized(*topic.type) && qos_ == qos;
}

bool SharedReader::join(const std::shared_ptr<TransportReaderListener>& subscription) {
  const std::lock_guard lock(mutex_);
  if (qos_.durability == Durability::kTransientLocal && has_received_) {
    return false;
  }
  if (matched_writers_ > 0) {
    subscription->on_remote_writers_changed(matched_writers_);
  }
  if (liveliness_.alive > 0 || liveliness_.not_alive > 0) {
    subscription->on_remote_liveliness_changed(liveliness_);
  }
  for (const auto& [policy, count] : incompatible_writers_) {
    for (std::uint64_t i = 0; i < count; ++i) {
      subscription->on_incompatible_remote_writer(policy);
    }
  }
  subscriptions_.push_back(subscription);
  return true;
}

void SharedReader::leave(const TransportReaderListener& subscription) {
  const std::lock_guard lock(mutex_);
  std::erase_if(subscriptions_, [&](const auto& member) { return member.get() == &subscription; });
}

template <class Call>
void SharedReader::tell_all(Call call) {
  std::exception_ptr thrown;
  for (const auto& subscription : subscriptions_) {
    try {
      call(*subscription);
    } catch (...) {
      if (!thrown) {
        thrown = std::current_exception();
      }
    }
  }
  if (thrown) {
    std::rethrow_exception(thrown);
  }
}

void SharedReader::on_remote_message(std::shared_ptr<const void> message, const MessageInfo& info) {
  {
    const std::lock_guard lock(mutex_);
    has_received_ = true;
    tell_all([&](TransportReaderListener& told) { told.on_remote_message(message, info); });
  }
  count(info.identity);
}

void SharedReader::count(const SampleIdentity& sample) {
  if (traffic_->is_enabled()) {
    traffic_->received(sample);
  }
}

void SharedReader::on_malformed_sample(const SampleIdentity& sample) {
  {
    const std::lock_guard lock(mutex_);
    tell_all([&](TransportReaderListener& told) { told.on_malformed_sample(sample); });
  }
  count(sample);
}

void SharedReader::on_overwritten_sample(const SampleIdentity& sample) {
  {
    const std::lock_guard lock(mutex_);
    tell_all([&](TransportReaderListener& told) { told.on_overwritten_sample(sample); });
  }
  count(sample);
}

void SharedReader::on_samples_lost(int count) {
  const std::lock_guard lock(mutex_);
  tell_all([count](TransportReaderListener& told) { told.on_samples_lost(count); });
}

void SharedReader::on_remote_writers_changed(int matched) {
  const std::lock_guard lock(mutex_);
  matched_writers_ = matched;
  tell_all([matched](TransportReaderListener& told) { told.on_remote_writers_changed(matched); });
}

void SharedReader::on_incompatible_remote_writer(QosPolicy policy) {
  const std::lock_guard lock(mutex_);
  ++incompatible_writers_[policy];
  tell_all([policy](TransportReaderListener& told) { told.on_incompatible_remote_writer(policy); });
}

void SharedReader::on_remote_liveliness_changed(LivelinessChange now) {
  const std::lock_guard lock(mutex_);
  liveliness_ = now;
  tell_all([now](TransportReaderListener& told) { told.on_remote_liveliness_changed(now); });
}

}  // namespace pipescout
