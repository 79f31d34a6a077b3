// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <atomic>
#include <fastdds/dds/subscriber/DataReader.hpp>
#include <fastdds/dds/subscriber/DataReaderListener.hpp>
#include <map>
#include <memory>
#include <mutex>
#include <set>

#include "call_gate.hpp"
#include "participant.hpp"
#include "pipescout/runtime/transport.hpp"

namespace pipescout::dds {

class DdsReader : public TransportReader, private fastdds::DataReaderListener {
 public:
  /// Throws TransportError naming the topic.
  DdsReader(std::shared_ptr<Participant> participant, const WireTopic& topic, const QoS& qos,
            TransportReaderListener& listener);
  DdsReader(const DdsReader&) = delete;
  DdsReader& operator=(const DdsReader&) = delete;
  ~DdsReader() override;

  [[nodiscard]] int matched_remote_writers() const override;
  [[nodiscard]] bool is_matched(const Gid& writer) const override;
  [[nodiscard]] Gid gid() const override { return gid_; }

 private:
  void on_data_available(fastdds::DataReader* reader) override;
  void on_subscription_matched(fastdds::DataReader* reader,
                               const fastdds::SubscriptionMatchedStatus& status) override;
  void on_liveliness_changed(fastdds::DataReader* reader,
                             const eprosima::fastrtps::LivelinessChangedStatus& status) override;
  void on_sample_lost(fastdds::DataReader* reader,
                      const fastdds::SampleLostStatus& status) override;

  [[nodiscard]] bool next_is_own(fastdds::DataReader& reader) const;
  void take_all(fastdds::DataReader& reader);
  [[nodiscard]] LivelinessChange remote_liveliness() const;
  void post_liveliness();

  const std::shared_ptr<Participant> participant_;
  const TopicUse topic_;
  const MessageType& type_;
  TransportReaderListener& listener_;
  const bool has_lease_;

  CallGate gate_;  // of the calls that do not go through the event thread: samples
  std::atomic<int> own_writers_{0};

  mutable std::mutex mutex_;
  std::set<Gid> writers_;  // remote and matched
  // Liveliness of the writers: of all as Fast DDS counts them, and of each remote one.
  LivelinessChange total_;
  LivelinessChange reported_;
  std::map<Gid, bool> is_alive_;

  fastdds::DataReader* reader_ = nullptr;
  Gid gid_;
};

}  // namespace pipescout::dds
