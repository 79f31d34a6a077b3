// SPDX-License-Identifier: Apache-2.0
#include "rtps_conversions.hpp"

#include <algorithm>
#include <chrono>
#include <cstdint>
#include <limits>
#include <utility>

namespace pipescout::dds {
namespace {

using DdsDuration = eprosima::fastrtps::Duration_t;

// A reader hands its samples over as they arrive, so its history holds only samples that wait for a
// fragment or for an earlier sample. With the depth of a QoS of 1, the fragments of two writers
// would push each other out.
constexpr std::size_t kReassemblyDepth = 16;

// Cache entries made in advance; more are made when needed.
constexpr std::int32_t kPreallocatedSamples = 4;

DdsDuration to_dds(Duration duration) noexcept {
  const auto seconds = std::chrono::duration_cast<std::chrono::seconds>(duration);
  if (seconds.count() >= std::numeric_limits<std::int32_t>::max()) {
    return eprosima::fastrtps::c_TimeInfinite;
  }
  return {static_cast<std::int32_t>(seconds.count()),
          static_cast<std::uint32_t>((duration - seconds).count())};
}

std::optional<Duration> from_dds(const DdsDuration& duration) noexcept {
  if (duration == eprosima::fastrtps::c_TimeInfinite ||
      duration.seconds == std::numeric_limits<std::int32_t>::max()) {
    return std::nullopt;
  }
  return std::chrono::seconds(duration.seconds) + std::chrono::nanoseconds(duration.nanosec);
}

std::int32_t history_depth(std::size_t depth) noexcept {
  constexpr std::size_t most = std::numeric_limits<std::int32_t>::max();
  return static_cast<std::int32_t>(std::min(depth, most));
}

template <class EndpointQos>
void fill_common(const QoS& qos, EndpointQos& out) {
  out.reliability().kind = qos.reliability == Reliability::kReliable
                               ? fastdds::RELIABLE_RELIABILITY_QOS
                               : fastdds::BEST_EFFORT_RELIABILITY_QOS;
  out.durability().kind = qos.durability == Durability::kTransientLocal
                              ? fastdds::TRANSIENT_LOCAL_DURABILITY_QOS
                              : fastdds::VOLATILE_DURABILITY_QOS;
  out.deadline().period = qos.deadline ? to_dds(*qos.deadline) : eprosima::fastrtps::c_TimeInfinite;
  out.lifespan().duration =
      qos.lifespan ? to_dds(*qos.lifespan) : eprosima::fastrtps::c_TimeInfinite;
  out.liveliness().kind = qos.liveliness == Liveliness::kManualByTopic
                              ? fastdds::MANUAL_BY_TOPIC_LIVELINESS_QOS
                              : fastdds::AUTOMATIC_LIVELINESS_QOS;
  if (qos.liveliness_lease) {
    out.liveliness().lease_duration = to_dds(*qos.liveliness_lease);
    // Two thirds of the lease, as rmw_fastrtps has it: one late announcement is not a lost writer.
    out.liveliness().announcement_period = to_dds(*qos.liveliness_lease * 2 / 3);
  } else {
    out.liveliness().lease_duration = eprosima::fastrtps::c_TimeInfinite;
    out.liveliness().announcement_period = eprosima::fastrtps::c_TimeInfinite;
  }
  out.history().kind = fastdds::KEEP_LAST_HISTORY_QOS;
  out.resource_limits().allocated_samples = kPreallocatedSamples;
  out.endpoint().history_memory_policy = rtps::DYNAMIC_REUSABLE_MEMORY_MODE;
  // Every ROS 2 type may be unbounded, and data sharing needs a bound.
  out.data_sharing().off();
}

template <class ProxyQos>
QoS announced_common(const ProxyQos& announced) {
  QoS qos;
  qos.depth = 0;
  qos.reliability = announced.m_reliability.kind == fastdds::RELIABLE_RELIABILITY_QOS
                        ? Reliability::kReliable
                        : Reliability::kBestEffort;
  qos.durability = announced.m_durability.kind == fastdds::VOLATILE_DURABILITY_QOS
                       ? Durability::kVolatile
                       : Durability::kTransientLocal;
  qos.deadline = from_dds(announced.m_deadline.period);
  qos.liveliness_lease = from_dds(announced.m_liveliness.lease_duration);
  return qos;
}

}  // namespace

Gid to_gid(const rtps::GUID_t& guid) noexcept {
  Gid gid;
  const auto entity =
      std::copy_n(guid.guidPrefix.value, rtps::GuidPrefix_t::size, gid.bytes.begin());
  std::copy_n(guid.entityId.value, rtps::EntityId_t::size, entity);
  return gid;
}

GuidPrefix prefix_of(const Gid& gid) noexcept {
  GuidPrefix prefix;
  std::copy_n(gid.bytes.begin(), prefix.size(), prefix.begin());
  return prefix;
}

SampleIdentity to_sample_identity(const rtps::SampleIdentity& identity) noexcept {
  SampleIdentity result{.writer = to_gid(identity.writer_guid())};
  if (identity.sequence_number() != rtps::SequenceNumber_t::unknown()) {
    result.sequence_number = static_cast<std::int64_t>(identity.sequence_number().to64long());
  }
  return result;
}

rtps::SampleIdentity to_rtps(const SampleIdentity& identity) noexcept {
  rtps::GUID_t guid;
  const auto* bytes = identity.writer.bytes.data();
  std::copy_n(bytes, rtps::GuidPrefix_t::size, guid.guidPrefix.value);
  std::copy_n(bytes + rtps::GuidPrefix_t::size, rtps::EntityId_t::size, guid.entityId.value);
  rtps::SampleIdentity result;
  result.writer_guid(guid);
  result.sequence_number(
      identity.sequence_number == 0
          ? rtps::SequenceNumber_t::unknown()
          : rtps::SequenceNumber_t(static_cast<std::int32_t>(identity.sequence_number >> 32),
                                   static_cast<std::uint32_t>(identity.sequence_number)));
  return result;
}

Time to_time(const rtps::Time_t& time) noexcept {
  return Time(std::chrono::nanoseconds(time.to_ns()));
}

fastdds::DataWriterQos writer_qos(const QoS& qos, fastdds::DataWriterQos base) {
  fill_common(qos, base);
  base.history().depth = history_depth(qos.depth);
  return base;
}

fastdds::DataReaderQos reader_qos(const QoS& qos, fastdds::DataReaderQos base) {
  fill_common(qos, base);
  base.history().depth = history_depth(std::max(qos.depth, kReassemblyDepth));
  return base;
}

QoS announced_qos(const rtps::WriterProxyData& writer) {
  QoS qos = announced_common(writer.m_qos);
  qos.liveliness = writer.m_qos.m_liveliness.kind == fastdds::MANUAL_BY_TOPIC_LIVELINESS_QOS
                       ? Liveliness::kManualByTopic
                       : Liveliness::kAutomatic;
  qos.lifespan = from_dds(writer.m_qos.m_lifespan.duration);
  return qos;
}

QoS announced_qos(const rtps::ReaderProxyData& reader) {
  QoS qos = announced_common(reader.m_qos);
  qos.liveliness = reader.m_qos.m_liveliness.kind == fastdds::AUTOMATIC_LIVELINESS_QOS
                       ? Liveliness::kAutomatic
                       : Liveliness::kManualByTopic;
  qos.lifespan = from_dds(reader.m_qos.m_lifespan.duration);
  return qos;
}

}  // namespace pipescout::dds
