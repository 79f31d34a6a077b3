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

void StepTraffic::received(const SampleIdentity& sample) {
  std::vector<std::shared_ptr<const std::function<void()>>> told;
  {
    const std::lock_guard lock(mutex_);
    std::int64_t& last = counts_.received[sample.writer];
    last = std::max(last, sample.sequence_number);
    std::erase_if(listeners_, [](const auto& weak) { return weak.expired(); });
    for (const auto& weak : listeners_) {
      if (auto listener = weak.lock()) {
        told.push_back(std::move(listener));
      }
    }
  }
  for (const auto& tell : told) {
    (*tell)();
  }
}

StepTraffic::Counts StepTraffic::counts() const {
  const std::lock_guard lock(mutex_);
  return counts_;
}

void StepTraffic::on_received(const std::shared_ptr<const std::function<void()>>& call) {
  const std::lock_guard lock(mutex_);
  listeners_.push_back(call);
}

}  // namespace pipescout
