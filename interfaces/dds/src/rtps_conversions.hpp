// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <fastdds/rtps/builtin/data/ReaderProxyData.h>
#include <fastdds/rtps/builtin/data/WriterProxyData.h>
#include <fastdds/rtps/common/Guid.h>
#include <fastdds/rtps/common/SampleIdentity.h>
#include <fastdds/rtps/common/Time_t.h>
#include <fastdds/dds/publisher/qos/DataWriterQos.hpp>
#include <fastdds/dds/subscriber/qos/DataReaderQos.hpp>

#include "pipescout/runtime/qos.hpp"
#include "pipescout/runtime/transport.hpp"
#include "shared_payloads.hpp"

/// The values of the transport contract in the terms of Fast DDS, and back.
namespace pipescout::dds {

namespace fastdds = eprosima::fastdds::dds;
namespace rtps = eprosima::fastrtps::rtps;

[[nodiscard]] Gid to_gid(const rtps::GUID_t& guid) noexcept;
[[nodiscard]] GuidPrefix prefix_of(const Gid& gid) noexcept;

/// An unknown sequence number is 0 on our side.
[[nodiscard]] SampleIdentity to_sample_identity(const rtps::SampleIdentity& identity) noexcept;
[[nodiscard]] rtps::SampleIdentity to_rtps(const SampleIdentity& identity) noexcept;

[[nodiscard]] Time to_time(const rtps::Time_t& time) noexcept;

/// QoS as rmw_fastrtps maps it, without data sharing. `base` carries what a profile file of the
/// user may have set besides: the publish mode (synchronous by default), its flow controller, ...
[[nodiscard]] fastdds::DataWriterQos writer_qos(const QoS& qos, fastdds::DataWriterQos base);
[[nodiscard]] fastdds::DataReaderQos reader_qos(const QoS& qos, fastdds::DataReaderQos base);

/// QoS of a remote endpoint. A policy that the runtime does not have becomes the nearest one that
/// promises no more (writers) or asks for no less (readers).
[[nodiscard]] QoS announced_qos(const rtps::WriterProxyData& writer);
[[nodiscard]] QoS announced_qos(const rtps::ReaderProxyData& reader);

}  // namespace pipescout::dds
