// SPDX-License-Identifier: Apache-2.0
#include "pipescout/bag_topics/qos_profiles.hpp"

#include <yaml-cpp/yaml.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <optional>
#include <string_view>
#include <utility>

namespace pipescout {
namespace {

/// rmw_time_t that means "for ever": 2^63 - 1 ns.
constexpr std::int64_t kForeverSeconds = 9223372036;
constexpr std::int64_t kForeverNanoseconds = 854775807;
constexpr std::int64_t kNanosecondsInSecond = 1'000'000'000;

/// A policy by its number and its name; `value` none: as if it were not said.
template <class Value>
struct Spelling {
  int number;
  std::string_view name;
  std::optional<Value> value;
};

enum class History { kKeepLast, kKeepAll, kUnknown };

constexpr std::array kHistory{
    Spelling<History>{0, "system_default", std::nullopt},
    Spelling<History>{1, "keep_last", History::kKeepLast},
    Spelling<History>{2, "keep_all", History::kKeepAll},
    Spelling<History>{3, "unknown", History::kUnknown},
};
constexpr std::array kReliability{
    Spelling<Reliability>{0, "system_default", std::nullopt},
    Spelling<Reliability>{1, "reliable", Reliability::kReliable},
    Spelling<Reliability>{2, "best_effort", Reliability::kBestEffort},
    Spelling<Reliability>{3, "unknown", std::nullopt},
};
constexpr std::array kDurability{
    Spelling<Durability>{0, "system_default", std::nullopt},
    Spelling<Durability>{1, "transient_local", Durability::kTransientLocal},
    Spelling<Durability>{2, "volatile", Durability::kVolatile},
    Spelling<Durability>{3, "unknown", std::nullopt},
};
constexpr std::array kLiveliness{
    Spelling<Liveliness>{0, "system_default", std::nullopt},
    Spelling<Liveliness>{1, "automatic", Liveliness::kAutomatic},
    // 2 was "manual by node", which ROS 2 does not have any more.
    Spelling<Liveliness>{3, "manual_by_topic", Liveliness::kManualByTopic},
    Spelling<Liveliness>{4, "unknown", std::nullopt},
};

[[noreturn]] void fail(const YAML::Node& node, const std::string& message) {
  const auto mark = node.Mark();
  throw QosProfileError((mark.is_null() ? ""
                                        : std::to_string(mark.line + 1) + ":" +
                                              std::to_string(mark.column + 1) + ": ") +
                        message);
}

template <class Value, std::size_t N>
int number_of(const std::array<Spelling<Value>, N>& spellings, Value value) {
  return std::find_if(spellings.begin(), spellings.end(),
                      [&](const auto& spelling) { return spelling.value == value; })
      ->number;
}

/// None: not there, or not said.
template <class Value, std::size_t N>
std::optional<Value> policy(const YAML::Node& profile, const char* key,
                            const std::array<Spelling<Value>, N>& spellings) {
  const auto node = profile[key];
  if (!node) {
    return std::nullopt;
  }
  const std::string text = node.IsScalar() ? node.Scalar() : "";
  for (const auto& spelling : spellings) {
    if (text == spelling.name || text == std::to_string(spelling.number)) {
      return spelling.value;
    }
  }
  fail(node, std::string(key) + " = '" + text + "' is no such policy");
}

template <class Value>
Value scalar(const YAML::Node& node, const char* key, Value otherwise) {
  if (!node[key]) {
    return otherwise;
  }
  Value value{};
  if (!YAML::convert<Value>::decode(node[key], value)) {
    fail(node[key], std::string(key) + " is no number in range");
  }
  return value;
}

/// None: for ever, or not said (zero).
std::optional<Duration> duration(const YAML::Node& profile, const char* key) {
  const auto node = profile[key];
  if (!node) {
    return std::nullopt;
  }
  if (node.IsScalar() && (node.Scalar() == "infinite" || node.Scalar() == ".inf")) {
    return std::nullopt;
  }
  if (!node.IsMap()) {
    fail(node, std::string(key) + " is no map with sec and nsec");
  }
  const auto seconds = scalar<std::int64_t>(node, "sec", 0);
  const auto nanoseconds = scalar<std::int64_t>(node, "nsec", 0);
  if (seconds < 0 || nanoseconds < 0) {
    fail(node, std::string(key) + " is negative");
  }
  // Some middlewares write their own for ever, above ours.
  if ((seconds == 0 && nanoseconds == 0) || seconds >= kForeverSeconds ||
      nanoseconds >= kNanosecondsInSecond) {
    return std::nullopt;
  }
  return Duration(seconds * kNanosecondsInSecond + nanoseconds);
}

QoS read_profile(const YAML::Node& profile) {
  if (!profile.IsMap()) {
    fail(profile, "a QoS profile is a map");
  }
  QoS qos;
  const auto history = policy(profile, "history", kHistory);
  const auto depth = scalar<std::int64_t>(profile, "depth", 0);
  if (depth < 0) {
    fail(profile["depth"], "depth is negative");
  }
  constexpr std::size_t kDepthOfKeepAll = 1000;
  if (history == History::kKeepAll) {
    qos.depth = kDepthOfKeepAll;  // every queue is bounded here
  } else if (depth > 0) {
    qos.depth = static_cast<std::size_t>(depth);
  }
  qos.reliability = policy(profile, "reliability", kReliability).value_or(qos.reliability);
  qos.durability = policy(profile, "durability", kDurability).value_or(qos.durability);
  qos.liveliness = policy(profile, "liveliness", kLiveliness).value_or(qos.liveliness);
  qos.deadline = duration(profile, "deadline");
  qos.lifespan = duration(profile, "lifespan");
  qos.liveliness_lease = duration(profile, "liveliness_lease_duration");
  return qos;
}

/// As text: yaml-cpp would group its digits by the global locale.
template <class Integer>
void write_integer(YAML::Emitter& out, const char* key, Integer value) {
  out << YAML::Key << key << YAML::Value << std::to_string(value);
}

void write_duration(YAML::Emitter& out, const char* key, const std::optional<Duration>& duration) {
  const auto ns = duration ? duration->count() : 0;
  out << YAML::Key << key << YAML::Value << YAML::BeginMap;
  write_integer(out, "sec", duration ? ns / kNanosecondsInSecond : kForeverSeconds);
  write_integer(out, "nsec", duration ? ns % kNanosecondsInSecond : kForeverNanoseconds);
  out << YAML::EndMap;
}

bool same_but_for_history(QoS a, const QoS& b) {
  a.depth = b.depth;
  return a == b;
}

}  // namespace

std::string qos_profiles_to_yaml(std::span<const QoS> profiles) {
  if (profiles.empty()) {
    return "";
  }
  YAML::Emitter out;
  out << YAML::BeginSeq;
  for (const QoS& qos : profiles) {
    const auto history = qos.depth == 0 ? History::kUnknown : History::kKeepLast;
    out << YAML::BeginMap;
    write_integer(out, "history", number_of(kHistory, history));
    write_integer(out, "depth", qos.depth);
    write_integer(out, "reliability", number_of(kReliability, qos.reliability));
    write_integer(out, "durability", number_of(kDurability, qos.durability));
    write_duration(out, "deadline", qos.deadline);
    write_duration(out, "lifespan", qos.lifespan);
    write_integer(out, "liveliness", number_of(kLiveliness, qos.liveliness));
    write_duration(out, "liveliness_lease_duration", qos.liveliness_lease);
    out << YAML::Key << "avoid_ros_namespace_conventions" << YAML::Value << false << YAML::EndMap;
  }
  out << YAML::EndSeq;
  return out.c_str();
}

std::vector<QoS> qos_profiles_from_yaml(const std::string& text) {
  std::vector<QoS> profiles;
  try {
    const auto node = YAML::Load(text);
    if (node.IsNull()) {
      return profiles;
    }
    if (!node.IsSequence()) {
      fail(node, "QoS profiles are a sequence");
    }
    for (const auto& profile : node) {
      profiles.push_back(read_profile(profile));
    }
  } catch (const YAML::Exception& error) {
    throw QosProfileError(error.what());
  }
  return profiles;
}

std::map<std::string, QoS> read_qos_overrides(const std::string& path) {
  std::map<std::string, QoS> overrides;
  try {
    const auto node = YAML::LoadFile(path);
    if (!node.IsNull() && !node.IsMap()) {
      fail(node, "QoS overrides are a map from topics to profiles");
    }
    for (const auto& entry : node) {
      const QoS qos = read_profile(entry.second);
      try {
        qos.validate();
      } catch (const std::invalid_argument& error) {
        fail(entry.second, error.what());
      }
      overrides[entry.first.Scalar()] = qos;
    }
  } catch (const YAML::BadFile&) {
    throw QosProfileError(path + ": cannot be read");
  } catch (const YAML::Exception& error) {
    throw QosProfileError(path + ":" + std::to_string(error.mark.line + 1) + ":" +
                          std::to_string(error.mark.column + 1) + ": " + error.msg);
  } catch (const QosProfileError& error) {
    throw QosProfileError(path + ":" + error.what());
  }
  return overrides;
}

QoS offer_for(std::span<const QoS> recorded) {
  QoS offer;
  if (recorded.empty()) {
    return offer;
  }
  if (std::all_of(recorded.begin(), recorded.end(),
                  [&](const QoS& qos) { return same_but_for_history(qos, recorded.front()); })) {
    const std::size_t least = offer.depth;
    offer = recorded.front();
    offer.depth = least;
  }
  for (const QoS& qos : recorded) {
    offer.depth = std::max(offer.depth, qos.depth);
  }
  return offer;
}

}  // namespace pipescout
