// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <concepts>
#include <string_view>

#include "pipescout/idl/message_type.hpp"

namespace pipescout {

/// The parts of a service. `S` is the tag that the service's generated header declares, such as
/// `std_srvs::srv::Trigger` in <std_srvs/srv/trigger.hpp>; each such header specialises this with
///   using Request, using Response     the generated message classes
///   static constexpr std::string_view service_name     "std_srvs/srv/Trigger"
template <class S>
struct ServiceType;

/// The tag of a service, whose header is included.
template <class S>
concept ServiceTag = requires {
  requires Message<typename ServiceType<S>::Request>;
  requires Message<typename ServiceType<S>::Response>;
  { ServiceType<S>::service_name } -> std::convertible_to<std::string_view>;
};

}  // namespace pipescout
