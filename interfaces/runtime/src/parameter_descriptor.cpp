// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>

#include "pipescout/runtime/parameters.hpp"

namespace pipescout {
namespace {

// What one range says of one value; `to` always belongs to the range, as in rclcpp.
bool contains(const IntegerRange& range, std::int64_t value) {
  if (value < range.from || value > range.to) {
    return false;
  }
  const std::uint64_t offset =
      static_cast<std::uint64_t>(value) - static_cast<std::uint64_t>(range.from);
  return range.step == 0 || value == range.to || offset % range.step == 0;
}

bool contains(const FloatingPointRange& range, double value) {
  // Written so that NaN fails.
  if (!(value >= range.from && value <= range.to)) {
    return false;
  }
  if (range.step == 0.0 || value == range.to) {
    return true;
  }
  // Rounding errors of from + k step; 100 as in rclcpp.
  constexpr double kUlps = 100.0;
  const double nearest = range.from + std::round((value - range.from) / range.step) * range.step;
  const double scale = std::max({std::abs(value), std::abs(range.from), range.step});
  return std::abs(value - nearest) <= kUlps * std::numeric_limits<double>::epsilon() * scale;
}

template <class Range, class T>
std::optional<std::string> out_of_range(const Range& range, const T& value) {
  if (contains(range, value)) {
    return std::nullopt;
  }
  return "value " + to_yaml(value) + " is out of range, expected " + to_string(range);
}

template <class Range, class T>
std::optional<std::string> out_of_range(const Range& range, const std::vector<T>& values) {
  for (std::size_t i = 0; i < values.size(); ++i) {
    if (const auto objection = out_of_range(range, values[i])) {
      return "element " + std::to_string(i + 1) + ": " + *objection;
    }
  }
  return std::nullopt;
}

// What to write to get the expected type, where that is a slip that everyone makes once.
std::string advice(ParameterType expected, const ParameterValue& value) {
  if (const auto* integer = value.get_if<std::int64_t>();
      integer != nullptr && expected == ParameterType::kDouble) {
    return "; write " + std::to_string(*integer) + ".0";
  }
  if (value.type() == ParameterType::kIntegerArray && expected == ParameterType::kDoubleArray) {
    return "; write every number with a '.'";
  }
  if (expected == ParameterType::kString && !is_array(value.type())) {
    return "; put it in quotes";
  }
  return "";
}

std::string step_text(const std::string& step) {
  return " in steps of " + step;
}

}  // namespace

std::string to_string(const IntegerRange& range) {
  const bool from_open = range.from == std::numeric_limits<std::int64_t>::min();
  const bool to_open = range.to == std::numeric_limits<std::int64_t>::max();
  std::string text = "[" + std::to_string(range.from) + ", " + std::to_string(range.to) + "]";
  if (from_open && !to_open) {
    text = "at most " + std::to_string(range.to);
  } else if (to_open && !from_open) {
    text = "at least " + std::to_string(range.from);
  }
  return range.step == 0 ? text : text + step_text(std::to_string(range.step));
}

std::string to_string(const FloatingPointRange& range) {
  std::string text = "[" + to_yaml(range.from) + ", " + to_yaml(range.to) + "]";
  if (std::isinf(range.from) && !std::isinf(range.to)) {
    text = "at most " + to_yaml(range.to);
  } else if (std::isinf(range.to) && !std::isinf(range.from)) {
    text = "at least " + to_yaml(range.from);
  }
  return range.step == 0.0 ? text : text + step_text(to_yaml(range.step));
}

void ParameterDescriptor::validate() const {
  const auto refuse = [this](const std::string& reason) {
    throw ParameterError(name, "parameter '" + name + "': " + reason);
  };
  if (name.empty() || name.front() == '.' || name.back() == '.' ||
      name.find("..") != std::string::npos) {
    refuse("the name or a part of it is empty");
  }
  if (std::any_of(name.begin(), name.end(), [](char c) {
        const auto byte = static_cast<unsigned char>(c);
        return byte <= 0x20 || byte == 0x7f;
      })) {
    refuse("the name has a space or control character");
  }
  if (integer_range && floating_point_range) {
    refuse("it has two ranges");
  }
  const auto is_one_of = [this](ParameterType scalar, ParameterType array) {
    return dynamic_typing || type == scalar || type == array;
  };
  if (integer_range) {
    if (!is_one_of(ParameterType::kInteger, ParameterType::kIntegerArray)) {
      refuse(std::string("an integer range is not allowed for type ") + to_string(type));
    }
    if (integer_range->from > integer_range->to) {
      refuse("the range " + to_string(*integer_range) + " is empty");
    }
  }
  if (floating_point_range) {
    const FloatingPointRange& range = *floating_point_range;
    if (!is_one_of(ParameterType::kDouble, ParameterType::kDoubleArray)) {
      refuse(std::string("a floating point range is not allowed for type ") + to_string(type));
    }
    if (!(range.from <= range.to)) {
      refuse("the range " + to_string(range) + " is empty");
    }
    if (!(range.step >= 0.0) || std::isinf(range.step)) {
      refuse("the step " + to_yaml(range.step) + " of its range must be finite and at least 0");
    }
    if (range.step > 0.0 && std::isinf(range.from)) {
      refuse("a range with a step must begin at a finite value");
    }
  }
}

std::optional<std::string> ParameterDescriptor::objection(const ParameterValue& value) const {
  if (!dynamic_typing && value.type() != type) {
    if (!value.is_set()) {
      return "it is statically typed (" + std::string(to_string(type)) + ") and cannot be unset";
    }
    return "value " + to_yaml(value) + " is of type " + to_string(value.type()) + ", expected " +
           to_string(type) + advice(type, value);
  }
  if (integer_range) {
    if (const auto* scalar = value.get_if<std::int64_t>()) {
      return out_of_range(*integer_range, *scalar);
    }
    if (const auto* array = value.get_if<std::vector<std::int64_t>>()) {
      return out_of_range(*integer_range, *array);
    }
  }
  if (floating_point_range) {
    if (const auto* scalar = value.get_if<double>()) {
      return out_of_range(*floating_point_range, *scalar);
    }
    if (const auto* array = value.get_if<std::vector<double>>()) {
      return out_of_range(*floating_point_range, *array);
    }
  }
  return std::nullopt;
}

}  // namespace pipescout
