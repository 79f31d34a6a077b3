// SPDX-License-Identifier: Apache-2.0
#include "dds_writer.hpp"

#include <fastdds/rtps/common/WriteParams.h>
#include <fastdds/dds/log/Log.hpp>

#include <chrono>
#include <span>
#include <string>
#include <utility>

#include "contain.hpp"
#include "network_profile.hpp"
#include "rtps_conversions.hpp"
#include "wire_type.hpp"

namespace pipescout::dds {
namespace {

using eprosima::fastrtps::types::ReturnCode_t;

// What fits into one datagram goes as fast by itself.
constexpr std::size_t kLeastStoredBytes = 60'000;

// How long the end of a writer waits for readers that are about to take a message.
constexpr std::chrono::milliseconds kLongestFarewell{200};

}  // namespace

DdsWriter::DdsWriter(std::shared_ptr<Participant> participant, const WireTopic& topic,
                     const QoS& qos, TransportWriterListener& listener)
    : participant_(std::move(participant)),
      topic_(*participant_, topic),
      type_(*topic.type),
      listener_(listener) {
  // What is kept for readers that may come must be readable by all of them.
  if (participant_->payload_folder() && qos.durability == Durability::kVolatile) {
    payloads_ = std::make_unique<PayloadWriter>(participant_->payload_folder(), qos.depth);
  }
  participant_->events().admit(this);
  fastdds::DataWriterQos dds_qos = writer_qos(qos, participant_->writer_profile(topic.name));
  apply(participant_->network(), topic.type->dds_name, dds_qos);
  writer_ = participant_->publisher(topic.name)
                .create_datawriter(topic_.get(), dds_qos, this,
                                   fastdds::StatusMask::publication_matched());
  if (writer_ == nullptr) {
    participant_->events().dismiss(this);
    throw TransportError("topic '" + topic.name + "': cannot create a writer with QoS " +
                         to_string(qos));
  }
  gid_ = to_gid(writer_->guid());
  participant_->discovery().add({.owner = this,
                                 .is_writer = true,
                                 .topic = topic.name,
                                 .type = std::string(topic.type->dds_name),
                                 .qos = qos,
                                 .on_incompatible = [this](QosPolicy policy) {
                                   listener_.on_incompatible_remote_reader(policy);
                                 }});
}

DdsWriter::~DdsWriter() {
  if (payloads_ && matched_remote_readers() > 0) {
    payloads_->await_readers(kLongestFarewell);
  }
  participant_->discovery().remove(this);
  participant_->events().dismiss(this);
  if (participant_->publisher(topic_.name()).delete_datawriter(writer_) !=
      ReturnCode_t::RETCODE_OK) {
    EPROSIMA_LOG_ERROR(PIPESCOUT, "the writer of '" << topic_.name() << "' could not be deleted");
  }
}

SampleIdentity DdsWriter::write(const void* message, const SampleIdentity& related) {
  rtps::WriteParams params;
  if (related.writer != Gid{}) {
    params.related_sample_identity(to_rtps(related));
  }
  bool written = false;
  contain("a write", [&] {
    OutgoingSample sample{.type = type_, .message = message, .reference = store(message)};
    written = writer_->write(&sample, params);
  });
  if (!written) {
    return {gid_, 0};
  }
  return to_sample_identity(params.sample_identity());
}

std::optional<PayloadReference> DdsWriter::store(const void* message) {
  if (!payloads_) {
    return std::nullopt;
  }
  const std::size_t size = type_.serialized_size(message);
  if (size < kLeastStoredBytes) {
    return std::nullopt;
  }
  std::size_t readers = 0;
  {
    const std::lock_guard lock(mutex_);
    readers = readers_.size();
    if (readers == 0 || !participant_->discovery().take_payloads(readers_)) {
      return std::nullopt;
    }
  }
  return payloads_->store(size, readers, [&](std::span<std::byte> bytes) {
    return type_.serialize(message, bytes) == bytes.size();
  });
}

int DdsWriter::matched_remote_readers() const {
  const std::lock_guard lock(mutex_);
  return static_cast<int>(readers_.size());
}

bool DdsWriter::is_matched(const Gid& reader) const {
  const std::lock_guard lock(mutex_);
  return readers_.contains(reader);
}

std::vector<Gid> DdsWriter::matched_participants() const {
  std::vector<Gid> participants;
  const std::lock_guard lock(mutex_);
  for (const Gid& reader : readers_) {  // those of one participant follow each other
    const Gid participant = participant_of(reader);
    if (participants.empty() || participants.back() != participant) {
      participants.push_back(participant);
    }
  }
  return participants;
}

void DdsWriter::assert_liveliness() {
  // Fast DDS 2.9.1 fails to assert, and tells no reader, when the lease expires in that very
  // moment; the next attempt meets an expired lease, which is no trouble.
  constexpr int kAttempts = 3;
  for (int attempt = 0; attempt < kAttempts; ++attempt) {
    if (writer_->assert_liveliness() == ReturnCode_t::RETCODE_OK) {
      return;
    }
  }
}

void DdsWriter::on_publication_matched(fastdds::DataWriter*,
                                       const fastdds::PublicationMatchedStatus& status) {
  contain("a match", [&] {
    const Gid reader = to_gid(rtps::iHandle2GUID(status.last_subscription_handle));
    if (same_participant(reader, participant_->gid())) {
      return;
    }
    const std::lock_guard lock(mutex_);
    const bool changed = status.current_count_change > 0 ? readers_.insert(reader).second
                                                         : readers_.erase(reader) > 0;
    if (changed) {
      participant_->events().post(this, [this, count = static_cast<int>(readers_.size())] {
        listener_.on_remote_readers_changed(count, matched_participants());
      });
    }
  });
}

}  // namespace pipescout::dds
