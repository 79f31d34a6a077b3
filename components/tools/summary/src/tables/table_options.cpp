// SPDX-License-Identifier: Apache-2.0
#include "tables/table_options.hpp"

#include <cmath>
#include <cstdint>
#include <functional>
#include <map>
#include <stdexcept>

namespace pipescout::summary {
namespace {

using Read = std::function<void(const ParameterOverride& option)>;

[[noreturn]] void refuse(const ParameterOverride& option, const std::string& why) {
  throw std::invalid_argument(option.source + ": summary." + option.name + " " + why);
}

template <class T>
const T& value_of(const ParameterOverride& option, const char* kind) {
  const T* const value = option.value.get_if<T>();
  if (value == nullptr) {
    refuse(option, std::string("must be ") + kind);
  }
  return *value;
}

Read into(bool& target) {
  return [&target](const auto& option) { target = value_of<bool>(option, "true or false"); };
}

Read into(std::size_t& target) {
  return [&target](const auto& option) {
    constexpr std::int64_t kMost = 1'000'000;
    const auto value = value_of<std::int64_t>(option, "a whole number");
    if (value < 0 || value > kMost) {
      refuse(option, "must be in [0, 1000000]");
    }
    target = static_cast<std::size_t>(value);
  };
}

/// s
Read into(double& target) {
  return [&target](const auto& option) {
    constexpr double kLongest = 1e6;
    const auto value = value_of<double>(option, "a number with a decimal point");
    if (!(value >= 0.0 && value <= kLongest)) {
      refuse(option, "must be in [0, 1e6] s");
    }
    target = value;
  };
}

Read into(std::filesystem::path& target) {
  return [&target](const auto& option) { target = value_of<std::string>(option, "a path"); };
}

template <class T>
Read into(std::vector<T>& target, const char* kind) {
  return [&target, kind](const auto& option) {
    // An empty list has no type of its elements.
    if (const auto* texts = option.value.template get_if<std::vector<std::string>>();
        texts != nullptr && texts->empty()) {
      target.clear();
      return;
    }
    target = value_of<std::vector<T>>(option, kind);
  };
}

}  // namespace

TableOptions read_table_options(std::span<const ParameterOverride> options) {
  TableOptions result;
  const std::map<std::string, Read> known{
      {"crawler.signal", into(result.crawler.signal)},
      {"crawler.table_rows", into(result.crawler.table_rows)},
      {"rack.image_period", into(result.rack.image_period)},
      {"rack.maximum_images", into(result.rack.maximum_images)},
      {"rack.rack", into(result.rack.rack)},
      {"odometry.reference_file", into(result.odometry.reference_file)},
      {"odometry.reference_columns", into(result.odometry.reference_columns, "a list of names")},
      {"odometry.table_rows", into(result.odometry.table_rows)},
      {"odometry.notes", into(result.odometry.notes, "a list of texts")},
      {"tracking.picture_interval", into(result.tracking.picture_interval)},
      {"tracking.maximum_pictures", into(result.tracking.maximum_pictures)},
      {"estimator.period", into(result.estimator.period)},
      {"estimator.datum", into(result.estimator.datum, "a list of three numbers")},
  };
  for (const ParameterOverride& option : options) {
    const auto read = known.find(option.name);
    if (read == known.end()) {
      std::string names;
      for (const auto& [name, reader] : known) {
        names += (names.empty() ? "" : ", ") + name;
      }
      refuse(option, "is not known; there are " + names);
    }
    read->second(option);
  }
  return result;
}

}  // namespace pipescout::summary
