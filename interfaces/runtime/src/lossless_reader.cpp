// SPDX-License-Identifier: Apache-2.0
#include "lossless_reader.hpp"

#include <algorithm>
#include <utility>

namespace pipescout {

class LosslessReader::Reliable final : private TransportReaderListener {
 public:
  explicit Reliable(LosslessReader& owner) : owner_(owner) {
    QoS qos = owner.qos_;
    qos.reliability = Reliability::kReliable;
    reader_ = owner.transport_.create_reader(owner.topic_, qos, *this);
  }
  [[nodiscard]] bool is_matched(const Gid& writer) const { return reader_->is_matched(writer); }
  [[nodiscard]] bool has_writers() const { return reader_->matched_remote_writers() > 0; }

 private:
  void on_remote_message(std::shared_ptr<const void> message, const MessageInfo& info) override {
    if (owner_.is_new(info.identity)) {
      owner_.listener_.on_remote_message(std::move(message), info);
    }
  }
  void on_malformed_sample(const SampleIdentity& sample) override {
    if (owner_.is_new(sample)) {
      owner_.listener_.on_malformed_sample(sample);
    }
  }
  void on_overwritten_sample(const SampleIdentity& sample) override {
    if (owner_.is_new(sample)) {
      owner_.listener_.on_overwritten_sample(sample);
    }
  }
  void on_samples_lost(int count) override { owner_.listener_.on_samples_lost(count); }
  // The best-effort reader matches all writers that this one does.
  void on_remote_writers_changed(int) override {}
  void on_incompatible_remote_writer(QosPolicy) override {}
  void on_remote_liveliness_changed(LivelinessChange) override {}

  LosslessReader& owner_;
  std::unique_ptr<TransportReader> reader_;
};

LosslessReader::LosslessReader(Transport& transport, const WireTopic& topic, const QoS& qos,
                               TransportReaderListener& listener)
    : transport_(transport), topic_(topic), qos_(qos), listener_(listener) {
  best_effort_ = transport.create_reader(topic, qos, *this);
}

LosslessReader::~LosslessReader() = default;

int LosslessReader::matched_remote_writers() const {
  return best_effort_->matched_remote_writers();
}

bool LosslessReader::is_matched(const Gid& writer) const {
  return best_effort_->is_matched(writer);
}

Gid LosslessReader::gid() const {
  return best_effort_->gid();
}

bool LosslessReader::comes_reliably(const Gid& writer) const {
  const Reliable* const reliable = reliable_.load();
  return reliable != nullptr && reliable->is_matched(writer);
}

bool LosslessReader::is_new(const SampleIdentity& sample) {
  const std::lock_guard lock(mutex_);
  std::int64_t& last = last_[sample.writer];
  return std::exchange(last, std::max(last, sample.sequence_number)) < sample.sequence_number;
}

void LosslessReader::on_remote_message(std::shared_ptr<const void> message,
                                       const MessageInfo& info) {
  if (!comes_reliably(info.identity.writer) && is_new(info.identity)) {
    listener_.on_remote_message(std::move(message), info);
  }
}

void LosslessReader::on_malformed_sample(const SampleIdentity& sample) {
  if (!comes_reliably(sample.writer) && is_new(sample)) {
    listener_.on_malformed_sample(sample);
  }
}

void LosslessReader::on_overwritten_sample(const SampleIdentity& sample) {
  if (!comes_reliably(sample.writer) && is_new(sample)) {
    listener_.on_overwritten_sample(sample);
  }
}

void LosslessReader::on_samples_lost(int count) {
  const Reliable* const reliable = reliable_.load();
  if (reliable == nullptr || !reliable->has_writers()) {
    listener_.on_samples_lost(count);
  }
}

// On the thread of such events, which holds no lock of the transport. Not made in advance: writers
// that do not offer reliability would report that it was asked for.
void LosslessReader::on_remote_writers_changed(int matched) {
  if (!owned_reliable_) {
    const auto endpoints = transport_.remote_endpoints();
    if (std::any_of(endpoints.begin(), endpoints.end(), [this](const DiscoveredEndpoint& endpoint) {
          return endpoint.is_writer && endpoint.topic == topic_.name &&
                 endpoint.qos.reliability == Reliability::kReliable;
        })) {
      owned_reliable_ = std::make_unique<Reliable>(*this);
      reliable_ = owned_reliable_.get();
    }
  }
  listener_.on_remote_writers_changed(matched);
}

void LosslessReader::on_incompatible_remote_writer(QosPolicy policy) {
  listener_.on_incompatible_remote_writer(policy);
}

void LosslessReader::on_remote_liveliness_changed(LivelinessChange now) {
  listener_.on_remote_liveliness_changed(now);
}

}  // namespace pipescout
