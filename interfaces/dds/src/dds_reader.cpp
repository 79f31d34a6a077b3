// SPDX-License-Identifier: Apache-2.0
#include "dds_reader.hpp"

#include <fastdds/dds/log/Log.hpp>
#include <fastdds/dds/subscriber/SampleInfo.hpp>

#include <string>
#include <utility>

#include "contain.hpp"
#include "network_profile.hpp"
#include "rtps_conversions.hpp"
#include "wire_type.hpp"

namespace pipescout::dds {
namespace {

using eprosima::fastrtps::types::ReturnCode_t;

}  // namespace

DdsReader::DdsReader(std::shared_ptr<Participant> participant, const WireTopic& topic,
                     const QoS& qos, TransportReaderListener& listener)
    : participant_(std::move(participant)),
      topic_(*participant_, topic),
      type_(*topic.type),
      listener_(listener),
      has_lease_(qos.liveliness_lease.has_value()) {
  participant_->events().admit(this);
  fastdds::DataReaderQos dds_qos = reader_qos(qos, participant_->reader_profile(topic.name));
  apply(participant_->network(), participant_->is_found_by_server(), dds_qos);
  reader_ = participant_->subscriber().create_datareader(
      topic_.get(), dds_qos, this,
      fastdds::StatusMask::data_available()
          << fastdds::StatusMask::subscription_matched()
          << fastdds::StatusMask::liveliness_changed() << fastdds::StatusMask::sample_lost());
  if (reader_ == nullptr) {
    participant_->events().dismiss(this);
    throw TransportError("topic '" + topic.name + "': cannot create a reader with QoS " +
                         to_string(qos));
  }
  gid_ = to_gid(reader_->guid());
  participant_->discovery().add({.owner = this,
                                 .is_writer = false,
                                 .topic = topic.name,
                                 .type = std::string(topic.type->dds_name),
                                 .qos = qos,
                                 .on_incompatible = [this](QosPolicy policy) {
                                   listener_.on_incompatible_remote_writer(policy);
                                 }});
}

DdsReader::~DdsReader() {
  participant_->discovery().remove(this);
  gate_.close();
  participant_->events().dismiss(this);
  if (participant_->subscriber().delete_datareader(reader_) != ReturnCode_t::RETCODE_OK) {
    EPROSIMA_LOG_ERROR(PIPESCOUT, "the reader of '" << topic_.name() << "' could not be deleted");
  }
}

int DdsReader::matched_remote_writers() const {
  const std::lock_guard lock(mutex_);
  return static_cast<int>(writers_.size());
}

bool DdsReader::is_matched(const Gid& writer) const {
  const std::lock_guard lock(mutex_);
  return writers_.contains(writer);
}

void DdsReader::on_data_available(fastdds::DataReader* reader) {
  if (const CallGate::Pass pass(gate_); pass) {
    contain("a sample", [&] { take_all(*reader); });
  }
}

// Whether the sample that the next take returns comes from this process. Where samples of this and
// of other processes come at once, the take may return another one than was looked at.
bool DdsReader::next_is_own(fastdds::DataReader& reader) const {
  fastdds::SampleInfo info;
  return reader.get_first_untaken_info(&info) == ReturnCode_t::RETCODE_OK &&
         same_participant(to_gid(info.sample_identity.writer_guid()), participant_->gid());
}

void DdsReader::take_all(fastdds::DataReader& reader) {
  IncomingSample sample{.type = type_, .payloads = participant_->payloads()};
  fastdds::SampleInfo info;
  for (;;) {
    // The runtime has delivered our own messages already; those need no decoding. The sample that
    // was looked at is mostly, but not always, the one that is taken.
    sample.skip = own_writers_.load(std::memory_order_relaxed) > 0 && next_is_own(reader);
    if (reader.take_next_sample(&sample, &info) != ReturnCode_t::RETCODE_OK) {
      return;
    }
    const MessageInfo message_info{.source_time = to_time(info.source_timestamp),
                                   .reception_time = to_time(info.reception_timestamp),
                                   .identity = to_sample_identity(info.sample_identity),
                                   .related = to_sample_identity(info.related_sample_identity)};
    if (!info.valid_data || same_participant(message_info.identity.writer, participant_->gid())) {
      continue;
    }
    // An exception ends this call only: the samples behind it are still waiting.
    contain("a sample", [&] {
      if (sample.skip) {
        sample.read(sample.unread);
      }
      if (sample.lost) {
        listener_.on_overwritten_sample(message_info.identity);
      } else if (sample.malformed) {
        listener_.on_malformed_sample(message_info.identity);
      } else {
        listener_.on_remote_message(std::move(sample.message), message_info);
      }
    });
  }
}

void DdsReader::on_sample_lost(fastdds::DataReader*, const fastdds::SampleLostStatus& status) {
  if (const CallGate::Pass pass(gate_); pass) {
    contain("lost samples", [&] { listener_.on_samples_lost(status.total_count_change); });
  }
}

void DdsReader::on_subscription_matched(fastdds::DataReader*,
                                        const fastdds::SubscriptionMatchedStatus& status) {
  contain("a match", [&] {
    const Gid writer = to_gid(rtps::iHandle2GUID(status.last_publication_handle));
    const bool added = status.current_count_change > 0;
    if (same_participant(writer, participant_->gid())) {
      own_writers_ += added ? 1 : -1;
      return;
    }
    const std::lock_guard lock(mutex_);
    const bool changed = added ? writers_.insert(writer).second : writers_.erase(writer) > 0;
    if (!changed) {
      return;
    }
    participant_->events().post(this, [this, count = static_cast<int>(writers_.size())] {
      listener_.on_remote_writers_changed(count);
    });
    // Without a lease Fast DDS watches nobody: a writer is alive as long as it is matched. With
    // one, it tells when the writer has first shown itself, often before the match.
    if (!has_lease_ && added) {
      is_alive_[writer] = true;
      post_liveliness();
    } else if (!added && is_alive_.erase(writer) > 0) {
      post_liveliness();
    }
  });
}

void DdsReader::on_liveliness_changed(fastdds::DataReader*,
                                      const eprosima::fastrtps::LivelinessChangedStatus& status) {
  contain("a liveliness change", [&] {
    const Gid writer = to_gid(rtps::iHandle2GUID(status.last_publication_handle));
    const std::lock_guard lock(mutex_);
    total_ = {.alive = status.alive_count, .not_alive = status.not_alive_count};
    if (!same_participant(writer, participant_->gid())) {
      if (status.alive_count_change > 0) {
        is_alive_[writer] = true;
      } else if (status.not_alive_count_change > 0) {
        is_alive_[writer] = false;
      } else if (status.alive_count_change < 0 || status.not_alive_count_change < 0) {
        is_alive_.erase(writer);
      }
    }
    post_liveliness();
  });
}

// Under mutex_. Fast DDS calls from several threads and mixes the changes of events that coincide;
// only its totals are sure. They count writers of this process too, so with such writers the
// remote ones have to be counted one by one.
LivelinessChange DdsReader::remote_liveliness() const {
  if (has_lease_ && own_writers_.load() == 0) {
    return total_;
  }
  LivelinessChange now;
  for (const auto& [writer, alive] : is_alive_) {
    ++(alive ? now.alive : now.not_alive);
  }
  return now;
}

// Under mutex_.
void DdsReader::post_liveliness() {
  const LivelinessChange now = remote_liveliness();
  if (now.alive == reported_.alive && now.not_alive == reported_.not_alive) {
    return;
  }
  reported_ = now;
  participant_->events().post(this, [this, now] { listener_.on_remote_liveliness_changed(now); });
}

}  // namespace pipescout::dds
