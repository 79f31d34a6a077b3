// SPDX-License-Identifier: Apache-2.0
#include "step_traffic.hpp"

#include <algorithm>
#include <array>

namespace pipescout {

bool is_step_traffic(std::string_view dds_topic) {
  constexpr std::array<std::string_view, 4> kReports{"rt/rosout", "rt/diagnostics",
                                                     "rt/parameter_events", "ros_discovery_info"};
  constexpr std::string_view kHiddenReport = "/_steps";
  return !dds_topic.ends_with(kHiddenReport) &&
         std::find(kReports.begin(), kReports.end(), dds_topic) == kReports.end();
}

void StepTraffic::sent(const Gid& writer, const std::vector<Gid>& participants,
                       std::int64_t sequence_number) {
  const std::lock_guard lock(mutex_);
  for (const Gid& participant : participants) {
    std::int64_t& last = counts_.sent[{writer, participant}];
    last = std::max(last, sequence_number);
  }
}

void StepTraffic::readers_changed(const Gid& writer, const std::vector<Gid>& participants) {
  Listeners told;
  {
    const std::lock_guard lock(mutex_);
    const auto gone = std::erase_if(counts_.sent, [&](const auto& sent) {
      const auto& [from, to] = sent.first;
      return from == writer &&
             std::find(participants.begin(), participants.end(), to) == participants.end();
    });
    if (gone == 0) {
      return;
    }
    told = listeners();
  }
  tell(told);
}

void StepTraffic::received(const SampleIdentity& sample) {
  Listeners told;
  {
    const std::lock_guard lock(mutex_);
    std::int64_t& last = counts_.received[sample.writer];
    last = std::max(last, sample.sequence_number);
    told = listeners();
  }
  tell(told);
}

StepTraffic::Listeners StepTraffic::listeners() {
  Listeners alive;
  std::erase_if(listeners_, [](const auto& weak) { return weak.expired(); });
  for (const auto& weak : listeners_) {
    if (auto listener = weak.lock()) {
      alive.push_back(std::move(listener));
    }
  }
  return alive;
}

void StepTraffic::tell(const Listeners& listeners) {
  for (const auto& listener : listeners) {
    (*listener)();
  }
}

StepTraffic::Counts StepTraffic::counts() const {
  const std::lock_guard lock(mutex_);
  return counts_;
}

void StepTraffic::on_change(const std::shared_ptr<const std::function<void()>>& call) {
  const std::lock_guard lock(mutex_);
  listeners_.push_back(call);
}

}  // namespace pipescout
