// SPDX-License-Identifier: Apache-2.0
#include "peer_end.hpp"

#include <sstream>
#include <utility>

namespace pipescout::conformance {

namespace {

constexpr Duration kPatience = std::chrono::seconds(30);

QoS read_qos(std::istream& text) {
  QoS qos;
  bool reliable = false;
  bool transient_local = false;
  bool manual = false;
  std::int64_t deadline = 0;
  std::int64_t lease = 0;
  text >> qos.depth >> reliable >> transient_local >> deadline >> manual >> lease;
  qos.reliability = reliable ? Reliability::kReliable : Reliability::kBestEffort;
  qos.durability = transient_local ? Durability::kTransientLocal : Durability::kVolatile;
  qos.liveliness = manual ? Liveliness::kManualByTopic : Liveliness::kAutomatic;
  if (deadline > 0) {
    qos.deadline = std::chrono::milliseconds(deadline);
  }
  if (lease > 0) {
    qos.liveliness_lease = std::chrono::milliseconds(lease);
  }
  return qos;
}

}  // namespace

std::string to_text(const QoS& qos) {
  const auto milliseconds = [](const std::optional<Duration>& duration) {
    return duration ? std::chrono::duration_cast<std::chrono::milliseconds>(*duration).count() : 0;
  };
  std::ostringstream text;
  text << qos.depth << ' ' << (qos.reliability == Reliability::kReliable) << ' '
       << (qos.durability == Durability::kTransientLocal) << ' ' << milliseconds(qos.deadline)
       << ' ' << (qos.liveliness == Liveliness::kManualByTopic) << ' '
       << milliseconds(qos.liveliness_lease);
  return text.str();
}

PeerEnd::PeerEnd(std::shared_ptr<Context> context)
    : node_({.context = std::move(context),
             .executor = &executor_,
             .name = {"/conformance", "peer"},
             .standard_interfaces = false}),
      spinner_([this] { executor_.spin(); }) {}

PeerEnd::~PeerEnd() {
  executor_.stop();
  spinner_.join();
}

template <class Change>
void PeerEnd::change(Change change) {
  {
    const std::lock_guard lock(mutex_);
    change(counts_);
  }
  changed_.notify_all();
}

template <class Condition>
bool PeerEnd::wait(Condition condition) {
  std::unique_lock lock(mutex_);
  return changed_.wait_for(lock, kPatience, condition);
}

std::string PeerEnd::wait_for(const std::string& what, std::uint64_t count) {
  const auto number = [&]() -> std::uint64_t {
    if (what == "matched") {
      return counts_.matched;
    }
    if (what == "deadline_missed") {
      return counts_.deadline_missed;
    }
    if (what == "liveliness_lost") {
      return counts_.liveliness_lost;
    }
    return what == "incompatible" ? counts_.incompatible : counts_.received.size();
  };
  // "matched 0" asks for the end of a match.
  if (!wait([&] { return count == 0 ? number() == 0 : number() >= count; })) {
    return "timeout";
  }
  if (what != "received") {
    return "ok";
  }
  std::ostringstream values;
  const std::lock_guard lock(mutex_);
  for (const std::int64_t value : counts_.received) {
    values << (values.tellp() > 0 ? " " : "") << value;
  }
  return values.str();
}

std::string PeerEnd::execute(const std::string& line) {
  std::istringstream words(line);
  std::string command;
  std::string argument;
  words >> command;
  if (command == "publisher") {
    words >> argument;
    publisher_ = node_.create_publisher<std_msgs::msg::Int64>(
        argument, read_qos(words),
        {.events = {.deadline_missed =
                        [this](EventCount count) {
                          change([&](Counts& counts) { counts.deadline_missed = count.total; });
                        },
                    .liveliness_lost =
                        [this](EventCount count) {
                          change([&](Counts& counts) { counts.liveliness_lost = count.total; });
                        },
                    .incompatible_qos =
                        [this](const IncompatibleQos& event) {
                          change([&](Counts& counts) { counts.incompatible = event.count.total; });
                        },
                    .matched =
                        [this](std::size_t number) {
                          change([&](Counts& counts) { counts.matched = number; });
                        }}});
  } else if (command == "subscription") {
    words >> argument;
    subscription_ = node_.create_subscription<std_msgs::msg::Int64>(
        argument, read_qos(words),
        [this](const std_msgs::msg::Int64& message) {
          change([&](Counts& counts) { counts.received.push_back(message.data); });
        },
        {.events = {.deadline_missed =
                        [this](EventCount count) {
                          change([&](Counts& counts) { counts.deadline_missed = count.total; });
                        },
                    .incompatible_qos =
                        [this](const IncompatibleQos& event) {
                          change([&](Counts& counts) { counts.incompatible = event.count.total; });
                        },
                    .matched =
                        [this](std::size_t number) {
                          change([&](Counts& counts) { counts.matched = number; });
                        }}});
  } else if (command == "publish") {
    std_msgs::msg::Int64 message;
    std::int64_t value = 0;
    words >> value;
    message.data = value;
    publisher_.publish(std::move(message));
  } else if (command == "assert") {
    publisher_.assert_liveliness();
  } else if (command == "wait") {
    std::uint64_t count = 0;
    words >> argument >> count;
    return wait_for(argument, count);
  } else if (command == "drop") {
    publisher_ = {};
    subscription_ = {};
  } else {
    return "error: " + line;
  }
  return "ok";
}

}  // namespace pipescout::conformance
