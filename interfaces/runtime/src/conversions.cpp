// SPDX-License-Identifier: Apache-2.0
#include "pipescout/runtime/conversions.hpp"

#include <algorithm>
#include <limits>
#include <stdexcept>
#include <string>
#include <type_traits>
#include <utility>

namespace pipescout {

namespace {

// Writes a span as the `sec` and `nanosec` that both wire types have.
template <class Message>
Message split(Duration span) {
  constexpr std::int64_t kMin = std::numeric_limits<std::int32_t>::min();
  constexpr std::int64_t kMax = std::numeric_limits<std::int32_t>::max();
  constexpr std::uint32_t kLastNanosecond = 999'999'999;
  const auto seconds = std::chrono::floor<std::chrono::seconds>(span);
  const std::int64_t count = seconds.count();
  Message message;
  if (count < kMin) {
    message.sec = static_cast<std::int32_t>(kMin);
    message.nanosec = 0;
  } else if (count > kMax) {
    message.sec = static_cast<std::int32_t>(kMax);
    message.nanosec = kLastNanosecond;
  } else {
    message.sec = static_cast<std::int32_t>(count);
    message.nanosec = static_cast<std::uint32_t>((span - seconds).count());
  }
  return message;
}

template <class Message>
Duration join(const Message& message) {
  return std::chrono::seconds(message.sec) + std::chrono::nanoseconds(message.nanosec);
}

ParameterType parameter_type(std::uint8_t number) {
  if (number > static_cast<std::uint8_t>(ParameterType::kStringArray)) {
    throw std::invalid_argument("parameter type " + std::to_string(number) +
                                " is not one of the types 0 to 9 of rcl_interfaces/ParameterType");
  }
  return static_cast<ParameterType>(number);
}

}  // namespace

builtin_interfaces::msg::Time to_message(Time time) {
  return split<builtin_interfaces::msg::Time>(time.time_since_epoch());
}

builtin_interfaces::msg::Duration to_message(Duration duration) {
  return split<builtin_interfaces::msg::Duration>(duration);
}

Time from_message(const builtin_interfaces::msg::Time& message) {
  return Time(join(message));
}

Duration from_message(const builtin_interfaces::msg::Duration& message) {
  return join(message);
}

rmw_dds_common::msg::Gid to_message(const Gid& gid) {
  rmw_dds_common::msg::Gid message;
  std::copy(gid.bytes.begin(), gid.bytes.end(), message.data.begin());
  return message;
}

Gid from_message(const rmw_dds_common::msg::Gid& message) {
  Gid gid;
  std::copy_n(message.data.begin(), gid.bytes.size(), gid.bytes.begin());
  return gid;
}

rcl_interfaces::msg::ParameterValue to_message(const ParameterValue& value) {
  rcl_interfaces::msg::ParameterValue message;
  message.type = static_cast<std::uint8_t>(value.type());
  value.visit([&message](const auto& content) {
    using Content = std::decay_t<decltype(content)>;
    if constexpr (std::is_same_v<Content, bool>) {
      message.bool_value = content;
    } else if constexpr (std::is_same_v<Content, std::int64_t>) {
      message.integer_value = content;
    } else if constexpr (std::is_same_v<Content, double>) {
      message.double_value = content;
    } else if constexpr (std::is_same_v<Content, std::string>) {
      message.string_value = content;
    } else if constexpr (std::is_same_v<Content, std::vector<std::uint8_t>>) {
      message.byte_array_value = content;
    } else if constexpr (std::is_same_v<Content, std::vector<bool>>) {
      message.bool_array_value = content;
    } else if constexpr (std::is_same_v<Content, std::vector<std::int64_t>>) {
      message.integer_array_value = content;
    } else if constexpr (std::is_same_v<Content, std::vector<double>>) {
      message.double_array_value = content;
    } else if constexpr (std::is_same_v<Content, std::vector<std::string>>) {
      message.string_array_value = content;
    } else {
      static_assert(std::is_same_v<Content, std::monostate>);
    }
  });
  return message;
}

ParameterValue from_message(const rcl_interfaces::msg::ParameterValue& message) {
  switch (parameter_type(message.type)) {
    case ParameterType::kNotSet:
      break;
    case ParameterType::kBool:
      return message.bool_value;
    case ParameterType::kInteger:
      return message.integer_value;
    case ParameterType::kDouble:
      return message.double_value;
    case ParameterType::kString:
      return message.string_value;
    case ParameterType::kByteArray:
      return message.byte_array_value;
    case ParameterType::kBoolArray:
      return message.bool_array_value;
    case ParameterType::kIntegerArray:
      return message.integer_array_value;
    case ParameterType::kDoubleArray:
      return message.double_array_value;
    case ParameterType::kStringArray:
      return message.string_array_value;
  }
  return {};
}

rcl_interfaces::msg::Parameter to_message(const NamedParameter& parameter) {
  rcl_interfaces::msg::Parameter message;
  message.name = parameter.name;
  message.value = to_message(parameter.value);
  return message;
}

std::vector<rcl_interfaces::msg::Parameter> to_message(
    const std::vector<NamedParameter>& parameters) {
  std::vector<rcl_interfaces::msg::Parameter> messages;
  messages.reserve(parameters.size());
  for (const NamedParameter& parameter : parameters) {
    messages.push_back(to_message(parameter));
  }
  return messages;
}

NamedParameter from_message(const rcl_interfaces::msg::Parameter& message) {
  try {
    return {message.name, from_message(message.value)};
  } catch (const std::invalid_argument& error) {
    throw std::invalid_argument("parameter '" + message.name + "': " + error.what());
  }
}

rcl_interfaces::msg::ParameterDescriptor to_message(const ParameterDescriptor& descriptor) {
  rcl_interfaces::msg::ParameterDescriptor message;
  message.name = descriptor.name;
  message.type = static_cast<std::uint8_t>(descriptor.type);
  message.description = descriptor.description;
  message.additional_constraints = descriptor.additional_constraints;
  message.read_only = descriptor.read_only;
  message.dynamic_typing = descriptor.dynamic_typing;
  if (descriptor.floating_point_range) {
    rcl_interfaces::msg::FloatingPointRange range;
    range.from_value = descriptor.floating_point_range->from;
    range.to_value = descriptor.floating_point_range->to;
    range.step = descriptor.floating_point_range->step;
    message.floating_point_range.push_back(range);
  }
  if (descriptor.integer_range) {
    rcl_interfaces::msg::IntegerRange range;
    range.from_value = descriptor.integer_range->from;
    range.to_value = descriptor.integer_range->to;
    range.step = descriptor.integer_range->step;
    message.integer_range.push_back(range);
  }
  return message;
}

ParameterDescriptor from_message(const rcl_interfaces::msg::ParameterDescriptor& message) {
  ParameterDescriptor descriptor;
  descriptor.name = message.name;
  descriptor.type = parameter_type(message.type);
  descriptor.description = message.description;
  descriptor.additional_constraints = message.additional_constraints;
  descriptor.read_only = message.read_only;
  descriptor.dynamic_typing = message.dynamic_typing;
  if (!message.floating_point_range.empty()) {
    const auto& range = message.floating_point_range.front();
    descriptor.floating_point_range = {range.from_value, range.to_value, range.step};
  }
  if (!message.integer_range.empty()) {
    const auto& range = message.integer_range.front();
    descriptor.integer_range = {range.from_value, range.to_value, range.step};
  }
  return descriptor;
}

rcl_interfaces::msg::SetParametersResult to_message(const SetResult& result) {
  rcl_interfaces::msg::SetParametersResult message;
  message.successful = result.successful;
  message.reason = result.reason;
  return message;
}

SetResult from_message(const rcl_interfaces::msg::SetParametersResult& message) {
  return {message.successful, message.reason};
}

rcl_interfaces::msg::ListParametersResult to_message(const ParameterList& list) {
  rcl_interfaces::msg::ListParametersResult message;
  message.names = list.names;
  message.prefixes = list.prefixes;
  return message;
}

ParameterList from_message(const rcl_interfaces::msg::ListParametersResult& message) {
  return {message.names, message.prefixes};
}

}  // namespace pipescout
