// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <fastdds/rtps/transport/UDPv4TransportDescriptor.h>
#include <cstdint>
#include <fastdds/dds/domain/qos/DomainParticipantQos.hpp>
#include <fastdds/dds/publisher/qos/DataWriterQos.hpp>
#include <fastdds/dds/subscriber/qos/DataReaderQos.hpp>
#include <string_view>

#include "pipescout/dds/network_options.hpp"
#include "rtps_conversions.hpp"

/// What a profile of the network means for Fast DDS.
namespace pipescout::dds {

/// `handshake_bytes` must fit one datagram.
void apply(const NetworkProfile& profile, std::uint32_t handshake_bytes,
           eprosima::fastdds::rtps::UDPv4TransportDescriptor& transport);
void apply(const NetworkProfile& profile, std::uint32_t handshake_bytes,
           fastdds::DomainParticipantQos& qos);
/// A discovery server tells each robot of all others: at once that is more than a radio channel
/// carries, and what is lost is told again. All that it sends has the rate of `profile`.
void apply_to_server(const NetworkProfile& profile, fastdds::DomainParticipantQos& qos);
/// `type` is the DDS name, `qos` has its reliability already.
void apply(const NetworkProfile& profile, std::string_view type, fastdds::DataWriterQos& qos);
/// `by_server`: endpoints are found by a discovery server.
void apply(const NetworkProfile& profile, bool by_server, fastdds::DataReaderQos& qos);

}  // namespace pipescout::dds
