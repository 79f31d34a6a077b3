// SPDX-License-Identifier: Apache-2.0
#include "input_watch.hpp"

#include <algorithm>
#include <limits>
#include <stdexcept>
#include <string_view>
#include <utility>

#include "endpoint_name.hpp"
#include "pipescout/runtime/names.hpp"
#include "pipescout/runtime/severity.hpp"
#include "text_for_people.hpp"

namespace pipescout {

namespace {

constexpr const char* kTopics = "inputs.topics";
constexpr const char* kMinimumRates = "inputs.minimum_rates";
constexpr const char* kMaximumAges = "inputs.maximum_ages";

/// A rate is counted over at least this, s, and over as long as so many messages take: one message
/// more or less, which is chance, then changes it by a fifth at most.
constexpr double kShortestWindow = 1.0;
constexpr double kMessagesOfWindow = 5.0;

double window_of(const InputExpectation& expected) {
  return expected.minimum_rate > 0.0
             ? std::max(kShortestWindow, kMessagesOfWindow / expected.minimum_rate)
             : kShortestWindow;
}

double limit_at(const std::vector<double>& limits, std::size_t index) {
  return limits.empty() ? 0.0 : limits[index];
}

void check_limits(const char* name, const std::vector<double>& limits, std::size_t topics) {
  if (!limits.empty() && limits.size() != topics) {
    throw std::invalid_argument(std::string(name) + " has " + std::to_string(limits.size()) +
                                " values for " + std::to_string(topics) + " of " + kTopics +
                                "; expected one each, or none at all");
  }
}

void warn(InputReport& report, DiagnosticLevel level, std::string message) {
  report.level = worse(report.level, level);
  report.message += (report.message.empty() ? "" : ", ") + std::move(message);
}

}  // namespace

InputWatch::InputWatch(Component& component) : component_(component) {
  const FloatingPointRange not_negative{.from = 0.0, .to = std::numeric_limits<double>::max()};
  topics_ = component.parameters().declare<std::vector<std::string>>(
      kTopics, {},
      {.description = "inputs whose rate and age are watched while the component is active, with a "
                      "warning on /diagnostics; takes effect when configured"});
  minimum_rates_ = component.parameters().declare<std::vector<double>>(
      kMinimumRates, {},
      {.description = std::string("Hz, for each of ") + kTopics + "; 0: any rate",
       .floating_point_range = not_negative});
  maximum_ages_ = component.parameters().declare<std::vector<double>>(
      kMaximumAges, {},
      {.description = std::string("s between now and the newest stamp, for each of ") + kTopics +
                      "; 0: any age",
       .floating_point_range = not_negative});
}

void InputWatch::configure() {
  const auto topics = topics_.share();
  const auto rates = minimum_rates_.share();
  const auto ages = maximum_ages_.share();
  check_limits(kMinimumRates, *rates, topics->size());
  check_limits(kMaximumAges, *ages, topics->size());
  std::map<std::string, InputExpectation> declared;
  for (std::size_t i = 0; i < topics->size(); ++i) {
    std::string name;
    try {
      name = component_.resolve_topic((*topics)[i]);
    } catch (const InvalidName& error) {
      throw std::invalid_argument(std::string(kTopics) + ": " + error.what());
    }
    if (!declared.try_emplace(name, InputExpectation{limit_at(*rates, i), limit_at(*ages, i)})
             .second) {
      throw std::invalid_argument(std::string(kTopics) + " has '" + (*topics)[i] + "' twice");
    }
  }
  declared_ = std::move(declared);
  histories_.clear();
}

std::vector<InputReport> InputWatch::look() {
  std::vector<InputReport> reports;
  if (component_.state() != LifecycleState::kActive) {
    histories_.clear();
    return reports;
  }
  const Time now = component_.now();
  std::map<std::string, InputExpectation> missing = declared_;
  Histories histories;
  for (const auto& subscription : component_.subscriptions()) {
    const std::string name = ros_name(*subscription);
    const auto declared = declared_.find(name);
    const InputExpectation& expected =
        declared == declared_.end() ? subscription->expected() : declared->second;
    missing.erase(name);
    if (expected == InputExpectation{}) {
      continue;
    }
    History& history = histories[subscription];
    if (const auto before = histories_.find(subscription); before != histories_.end()) {
      history = std::move(before->second);
    }
    reports.push_back(judge(*subscription, history, expected, now));
    reports.back().topic = name;
  }
  histories_ = std::move(histories);
  for (const auto& [name, expected] : missing) {
    reports.push_back({.topic = name,
                       .level = DiagnosticLevel::kWarn,
                       .message = std::string("is in ") + kTopics + ", and no input"});
  }
  return reports;
}

InputReport InputWatch::judge(const UntypedSubscription& subscription, History& history,
                              const InputExpectation& expected, Time now) {
  const SubscriptionStatistics statistics = subscription.statistics();
  InputReport report;
  if (statistics.received == 0) {
    // Its source has not begun, which is no fault; nor may the clock have.
    history = {};
    report.level = DiagnosticLevel::kStale;
    report.message = "waits for the first message";
    return report;
  }
  auto& counts = history.counts;
  if (counts.empty() || now < counts.back().time) {
    // Just activated, its first message, or the clock was set back.
    counts.assign(1, {now, statistics.received});
    history.changed = now;
  }
  if (statistics.received != counts.back().received) {
    history.changed = now;
  }
  if (now > counts.back().time) {
    counts.push_back({now, statistics.received});
  }
  const Time start = now - from_seconds(window_of(expected));
  while (counts.size() > 1 && counts[1].time <= start) {
    counts.pop_front();
  }

  const double age = to_seconds(now - statistics.last_stamp.value_or(history.changed));
  report.values["age_s"] = text_for_people(age);
  const double span = to_seconds(now - counts.front().time);
  // Not yet a window long: what is missing may still come.
  const bool judged = counts.front().time <= start;
  if (judged) {
    const auto received = static_cast<double>(statistics.received - counts.front().received);
    report.values["rate_hz"] = text_for_people(received / span);
    if (received == 0.0 && expected.minimum_rate > 0.0) {
      warn(report, DiagnosticLevel::kError, "nothing came in " + text_for_people(span) + " s");
      return report;
    }
    // Where the window begins between two messages is chance.
    if ((received + 1.0) / span < expected.minimum_rate) {
      warn(report, DiagnosticLevel::kWarn,
           "comes at " + text_for_people(received / span) + " Hz, expected at least " +
               text_for_people(expected.minimum_rate));
    }
  }
  if (expected.maximum_age > 0.0 && age > expected.maximum_age) {
    warn(report, DiagnosticLevel::kWarn,
         "is " + text_for_people(age) + " s old, expected at most " +
             text_for_people(expected.maximum_age));
  }
  return report;
}

}  // namespace pipescout
