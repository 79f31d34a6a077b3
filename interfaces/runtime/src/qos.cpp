// SPDX-License-Identifier: Apache-2.0
#include "pipescout/runtime/qos.hpp"

#include <algorithm>
#include <locale>
#include <sstream>
#include <stdexcept>

namespace pipescout {

namespace {

void require_positive(const std::optional<Duration>& duration, const char* field) {
  if (duration && *duration <= Duration::zero()) {
    throw std::invalid_argument(std::string("QoS: ") + field + " = " +
                                std::to_string(duration->count()) + " ns is not positive");
  }
}

// A longer promise than was asked for, "unlimited" being the longest.
bool exceeds(const std::optional<Duration>& offered, const std::optional<Duration>& requested) {
  return requested && (!offered || *offered > *requested);
}

}  // namespace

void QoS::validate() const {
  constexpr std::size_t kMaxDepth = 100000;
  if (depth < 1 || depth > kMaxDepth) {
    throw std::invalid_argument("QoS: depth = " + std::to_string(depth) + " is not in [1, " +
                                std::to_string(kMaxDepth) + "]");
  }
  require_positive(deadline, "deadline");
  require_positive(liveliness_lease, "liveliness_lease");
  require_positive(lifespan, "lifespan");
}

const char* to_string(QosPolicy policy) noexcept {
  switch (policy) {
    case QosPolicy::kReliability:
      return "reliability";
    case QosPolicy::kDurability:
      return "durability";
    case QosPolicy::kDeadline:
      return "deadline";
    case QosPolicy::kLiveliness:
      return "liveliness";
  }
  return "unknown";
}

std::string to_string(const QoS& qos) {
  std::ostringstream text;
  text.imbue(std::locale::classic());
  text << (qos.reliability == Reliability::kReliable ? "reliable" : "best effort") << ", "
       << (qos.durability == Durability::kTransientLocal ? "transient local" : "volatile")
       << ", depth " << qos.depth;
  if (qos.deadline) {
    text << ", deadline " << to_seconds(*qos.deadline) << " s";
  }
  if (qos.liveliness == Liveliness::kManualByTopic) {
    text << ", manual liveliness";
  }
  if (qos.liveliness_lease) {
    text << ", lease " << to_seconds(*qos.liveliness_lease) << " s";
  }
  if (qos.lifespan) {
    text << ", lifespan " << to_seconds(*qos.lifespan) << " s";
  }
  return text.str();
}

std::optional<QosPolicy> incompatibility(const QoS& offered, const QoS& requested) {
  if (offered.reliability < requested.reliability) {
    return QosPolicy::kReliability;
  }
  if (offered.durability < requested.durability) {
    return QosPolicy::kDurability;
  }
  if (exceeds(offered.deadline, requested.deadline)) {
    return QosPolicy::kDeadline;
  }
  if (offered.liveliness < requested.liveliness ||
      exceeds(offered.liveliness_lease, requested.liveliness_lease)) {
    return QosPolicy::kLiveliness;
  }
  return std::nullopt;
}

QoS request_for(std::span<const QoS> offered, std::size_t depth) {
  QoS request = QoS::reliable(depth);
  if (offered.empty()) {
    return request;
  }
  const auto all = [&](auto offers) { return std::all_of(offered.begin(), offered.end(), offers); };
  if (!all([](const QoS& qos) { return qos.reliability == Reliability::kReliable; })) {
    request.reliability = Reliability::kBestEffort;
  }
  if (all([](const QoS& qos) { return qos.durability == Durability::kTransientLocal; })) {
    request.durability = Durability::kTransientLocal;
  }
  return request;
}

}  // namespace pipescout
