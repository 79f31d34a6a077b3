// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <builtin_interfaces/msg/duration.hpp>
#include <builtin_interfaces/msg/time.hpp>
#include <rcl_interfaces/msg/list_parameters_result.hpp>
#include <rcl_interfaces/msg/parameter.hpp>
#include <rcl_interfaces/msg/parameter_descriptor.hpp>
#include <rcl_interfaces/msg/parameter_value.hpp>
#include <rcl_interfaces/msg/set_parameters_result.hpp>
#include <rmw_dds_common/msg/gid.hpp>
#include <vector>

#include "pipescout/runtime/parameters.hpp"
#include "pipescout/runtime/time.hpp"
#include "pipescout/runtime/transport.hpp"

/// Conversions between wire types and the types of the runtime. All functions are pure and
/// thread-safe.
namespace pipescout {

/// Seconds are rounded down, so that `nanosec` is in [0, 1e9). Values outside the 32 bits of `sec`
/// (1901 to 2038, or 68 years) saturate.
[[nodiscard]] builtin_interfaces::msg::Time to_message(Time time);
[[nodiscard]] builtin_interfaces::msg::Duration to_message(Duration duration);
/// Accepts any content: a `nanosec` of 1e9 or more is added as it is.
[[nodiscard]] Time from_message(const builtin_interfaces::msg::Time& message);
[[nodiscard]] Duration from_message(const builtin_interfaces::msg::Duration& message);

/// The message has 24 bytes; those beyond a Gid are zero, and are not read.
[[nodiscard]] rmw_dds_common::msg::Gid to_message(const Gid& gid);
[[nodiscard]] Gid from_message(const rmw_dds_common::msg::Gid& message);

[[nodiscard]] rcl_interfaces::msg::ParameterValue to_message(const ParameterValue& value);
/// Throws std::invalid_argument when `type` is not a constant of ParameterType.
[[nodiscard]] ParameterValue from_message(const rcl_interfaces::msg::ParameterValue& message);

[[nodiscard]] rcl_interfaces::msg::Parameter to_message(const NamedParameter& parameter);
[[nodiscard]] std::vector<rcl_interfaces::msg::Parameter> to_message(
    const std::vector<NamedParameter>& parameters);
/// Throws std::invalid_argument naming the parameter.
[[nodiscard]] NamedParameter from_message(const rcl_interfaces::msg::Parameter& message);

[[nodiscard]] rcl_interfaces::msg::ParameterDescriptor to_message(
    const ParameterDescriptor& descriptor);
/// Throws std::invalid_argument when `type` is not a constant of ParameterType.
[[nodiscard]] ParameterDescriptor from_message(
    const rcl_interfaces::msg::ParameterDescriptor& message);

[[nodiscard]] rcl_interfaces::msg::SetParametersResult to_message(const SetResult& result);
[[nodiscard]] SetResult from_message(const rcl_interfaces::msg::SetParametersResult& message);

[[nodiscard]] rcl_interfaces::msg::ListParametersResult to_message(const ParameterList& list);
[[nodiscard]] ParameterList from_message(const rcl_interfaces::msg::ListParametersResult& message);

}  // namespace pipescout
