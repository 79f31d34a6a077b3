// SPDX-License-Identifier: Apache-2.0
#include "dds_writer.hpp"

#include <fastdds/rtps/common/WriteParams.h>
#include <fastdds/dds/log/Log.hpp>

#include <string>
#include <utility>

#include "contain.hpp"
#include "rtps_conversions.hpp"

namespace pipescout::dds {
namespace {

using eprosima::fastrtps::types::ReturnCode_t;

}  // namespace

DdsWriter::DdsWriter(std::shared_ptr<Participant> participant, const WireTopic& topic,
                     const QoS& qos, TransportWriterListener& listener)
    : participant_(std::move(participant)), topic_(*participant_, topic), listener_(listener) {
  participant_->events().admit(this);
  writer_ = participant_->publisher().create_datawriter(
      topic_.get(), writer_qos(qos, participant_->writer_profile(topic.name)), this,
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
  participant_->discovery().remove(this);
  participant_->events().dismiss(this);
  if (participant_->publisher().delete_datawriter(writer_) != ReturnCode_t::RETCODE_OK) {
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
    // Fast DDS hands the pointer to WireType, which only reads.
    written = writer_->write(const_cast<void*>(message), params);
  });
  if (!written) {
    return {gid_, 0};
  }
  return to_sample_identity(params.sample_identity());
}

int DdsWriter::matched_remote_readers() const {
  const std::lock_guard lock(mutex_);
  return static_cast<int>(readers_.size());
}

bool DdsWriter::is_matched(const Gid& reader) const {
  const std::lock_guard lock(mutex_);
  return readers_.contains(reader);
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
        listener_.on_remote_readers_changed(count);
      });
    }
  });
}

}  // namespace pipescout::dds
