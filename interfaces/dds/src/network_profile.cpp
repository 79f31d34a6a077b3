// SPDX-License-Identifier: Apache-2.0
#include "network_profile.hpp"

#include <fastdds/rtps/attributes/WriterAttributes.h>
#include <fastdds/rtps/flowcontrol/FlowControllerDescriptor.hpp>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <memory>
#include <utility>

namespace pipescout::dds {
namespace {

using eprosima::fastdds::rtps::FlowControllerDescriptor;
using eprosima::fastdds::rtps::FlowControllerSchedulerPolicy;

// With the headers of UDP and IP less than the 1280 bytes that every path of IPv6 carries: also
// through tunnels, and where an interface claims a larger MTU than the path has. An image that
// loses one fragment is lost, but no router splits, and no kernel reassembles, what is sent.
constexpr std::uint32_t kWifiDatagramBytes = 1200;
// With security the limit has to let the handshake pass, of which Fast DDS makes no fragments.
std::uint32_t datagram_bytes(std::uint32_t handshake_bytes) {
  return std::max(kWifiDatagramBytes, handshake_bytes);
}

// Who comes to twenty other processes is told of some thousand endpoints at once. What does not fit
// the socket is lost, and asked for again. The kernel gives as much of it as it may (rmem_max).
constexpr std::uint32_t kReceiveBufferBytes = 4 * 1024 * 1024;

// Best effort topics wait here for their turn, reliable ones do not.
constexpr const char* kBulkFlow = "pipescout bulk";
constexpr std::uint32_t kPeriodMilliseconds = 20;
constexpr double kMillisecondsPerSecond = 1000.0;
constexpr double kBytesPerMegabit = 1e6 / 8.0;
// A datagram that is larger than what may be sent in a period is never sent.
constexpr double kLeastDatagramsPerPeriod = 2.0;

// Of Fast DDS's scheduler, between -10 (first) and 10 (last): between two periods the small
// messages overtake the rest of a large one.
constexpr const char* kPriorityProperty = "fastdds.sfc.priority";
constexpr const char* kLastPriority = "10";
constexpr std::array<std::string_view, 3> kLargeTypes{"sensor_msgs::msg::dds_::Image_",
                                                      "sensor_msgs::msg::dds_::CompressedImage_",
                                                      "sensor_msgs::msg::dds_::PointCloud2_"};

// How soon a reliable writer that has nothing new to say notices what was lost: 3 s with Fast DDS,
// in which a late comer that lost the one datagram with all that was kept for it has nothing. While
// all have acknowledged, there are no heartbeats.
const eprosima::fastrtps::Duration_t kSoonHeartbeat{0, 500'000'000};
// How often a reader asks a writer that it has heard nothing of, which with a discovery server may
// not know the reader for some seconds. 70 ms by default, for each pair of reader and writer.
const eprosima::fastrtps::Duration_t kSparingFirstRequest{1, 0};
// Of each participant for all others. A heartbeat with each message, which all have to answer,
// costs as much as the message; here nobody waits for what was lost. Nor is it sent again upon a
// request that may be older than the last answer.
constexpr std::string_view kGraphType = "rmw_dds_common::msg::dds_::ParticipantEntitiesInfo_";
const eprosima::fastrtps::Duration_t kGraphNackSuppression{0, 200'000'000};

/// What may be sent within a period.
struct Budget {
  std::uint32_t bytes = 0;
  std::uint32_t milliseconds = 0;
};

Budget budget_of(const NetworkProfile& profile, std::uint32_t handshake_bytes) {
  const double bytes_per_millisecond = profile.rate * kBytesPerMegabit / kMillisecondsPerSecond;
  const double least_bytes_per_period = kLeastDatagramsPerPeriod * datagram_bytes(handshake_bytes);
  const auto milliseconds = std::max(
      kPeriodMilliseconds,
      static_cast<std::uint32_t>(std::ceil(least_bytes_per_period / bytes_per_millisecond)));
  return {static_cast<std::uint32_t>(bytes_per_millisecond * milliseconds), milliseconds};
}

}  // namespace

void apply(const NetworkProfile& profile, std::uint32_t handshake_bytes,
           eprosima::fastdds::rtps::UDPv4TransportDescriptor& transport) {
  if (transport.receiveBufferSize == 0) {  // the user's profile has not chosen
    transport.receiveBufferSize = kReceiveBufferBytes;
  }
  if (profile.kind == NetworkProfile::Kind::kWifi) {
    transport.maxMessageSize = datagram_bytes(handshake_bytes);
  }
}

void apply(const NetworkProfile& profile, std::uint32_t handshake_bytes,
           fastdds::DomainParticipantQos& qos) {
  if (profile.kind != NetworkProfile::Kind::kWifi) {
    return;
  }
  auto bulk = std::make_shared<FlowControllerDescriptor>();
  bulk->name = kBulkFlow;
  bulk->scheduler = FlowControllerSchedulerPolicy::HIGH_PRIORITY;
  const Budget budget = budget_of(profile, handshake_bytes);
  bulk->period_ms = budget.milliseconds;
  bulk->max_bytes_per_period = static_cast<std::int32_t>(budget.bytes);
  qos.flow_controllers().push_back(std::move(bulk));
}

void apply_to_server(const NetworkProfile& profile, fastdds::DomainParticipantQos& qos) {
  if (profile.kind == NetworkProfile::Kind::kWifi) {
    const Budget budget = budget_of(profile, 0);
    qos.wire_protocol().throughput_controller = {budget.bytes, budget.milliseconds};
  }
}

void apply(const NetworkProfile& profile, std::string_view type, fastdds::DataWriterQos& qos) {
  auto& reliable = qos.reliable_writer_qos();
  if (type == kGraphType) {
    reliable.times.heartbeatPeriod = kSoonHeartbeat;
    reliable.times.nackSupressionDuration = kGraphNackSuppression;
    reliable.disable_heartbeat_piggyback = true;
  }
  const bool is_reliable = qos.reliability().kind == fastdds::RELIABLE_RELIABILITY_QOS;
  // Unless the user's profile of the topic has chosen.
  if (is_reliable && reliable.times.heartbeatPeriod == rtps::WriterTimes().heartbeatPeriod) {
    reliable.times.heartbeatPeriod = kSoonHeartbeat;
  }
  if (profile.kind != NetworkProfile::Kind::kWifi) {
    return;
  }
  qos.publish_mode().kind = fastdds::ASYNCHRONOUS_PUBLISH_MODE;
  if (!is_reliable) {
    qos.publish_mode().flow_controller_name = kBulkFlow;
    if (std::find(kLargeTypes.begin(), kLargeTypes.end(), type) != kLargeTypes.end()) {
      qos.properties().properties().emplace_back(kPriorityProperty, kLastPriority);
    }
  }
}

void apply(const NetworkProfile& profile, bool by_server, fastdds::DataReaderQos& qos) {
  if (profile.kind == NetworkProfile::Kind::kWifi || by_server) {
    qos.reliable_reader_qos().times.initialAcknackDelay = kSparingFirstRequest;
  }
}

}  // namespace pipescout::dds
