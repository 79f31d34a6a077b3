// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <fastdds/dds/domain/qos/DomainParticipantQos.hpp>

#include "pipescout/dds/dds_transport.hpp"
#include "rtps_conversions.hpp"
#include "warnings.hpp"

namespace pipescout::dds {

/// By which protocol and of whom the participant learns of others, unless the user's profile has
/// chosen. Hosts whose names cannot be resolved are named in `warnings` and left out.
void choose_discovery(const DdsOptions& options, Warnings& warnings,
                      fastdds::DomainParticipantQos& qos);

/// Whether it is an IPv4 address of an interface of this machine.
[[nodiscard]] bool is_of_this_machine(const rtps::Locator_t& locator);

}  // namespace pipescout::dds
