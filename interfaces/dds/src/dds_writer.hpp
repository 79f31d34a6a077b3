// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <fastdds/dds/publisher/DataWriter.hpp>
#include <fastdds/dds/publisher/DataWriterListener.hpp>
#include <memory>
#include <mutex>
#include <optional>
#include <set>
#include <vector>

#include "participant.hpp"
#include "pipescout/runtime/transport.hpp"
#include "shared_payloads.hpp"

namespace pipescout::dds {

class DdsWriter : public TransportWriter, private fastdds::DataWriterListener {
 public:
  /// Throws TransportError naming the topic.
  DdsWriter(std::shared_ptr<Participant> participant, const WireTopic& topic, const QoS& qos,
            TransportWriterListener& listener);
  DdsWriter(const DdsWriter&) = delete;
  DdsWriter& operator=(const DdsWriter&) = delete;
  ~DdsWriter() override;

  SampleIdentity write(const void* message, const SampleIdentity& related) override;
  [[nodiscard]] int matched_remote_readers() const override;
  [[nodiscard]] bool is_matched(const Gid& reader) const override;
  [[nodiscard]] std::vector<Gid> matched_participants() const override;
  void assert_liveliness() override;
  [[nodiscard]] Gid gid() const override { return gid_; }

 private:
  void on_publication_matched(fastdds::DataWriter* writer,
                              const fastdds::PublicationMatchedStatus& status) override;

  /// Stores the message in shared memory, if it is large and all its readers can take it there.
  [[nodiscard]] std::optional<PayloadReference> store(const void* message);

  const std::shared_ptr<Participant> participant_;
  const TopicUse topic_;
  const MessageType& type_;
  TransportWriterListener& listener_;
  std::unique_ptr<PayloadWriter> payloads_;  // null: never
  mutable std::mutex mutex_;
  std::set<Gid> readers_;  // remote and matched
  fastdds::DataWriter* writer_ = nullptr;
  Gid gid_;
};

}  // namespace pipescout::dds
