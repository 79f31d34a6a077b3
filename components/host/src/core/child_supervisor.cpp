// SPDX-License-Identifier: Apache-2.0
#include "core/child_supervisor.hpp"

#include <sys/wait.h>

#include <algorithm>
#include <csignal>
#include <cstring>
#include <nlohmann/json.hpp>
#include <stdexcept>
#include <utility>

namespace pipescout::host {
namespace {

using nlohmann::json;

constexpr Duration kLongestPause = std::chrono::minutes(1);

}  // namespace

std::string ChildMessage::to_json() const {
  json object;
  switch (event) {
    case Event::kConstructed:
      object["event"] = "constructed";
      break;
    case Event::kActive:
      object["event"] = "active";
      break;
    case Event::kBroke:
      object["event"] = "broke";
      break;
    case Event::kAlive:
      object["event"] = "alive";
      break;
    case Event::kFailed:
      object["event"] = "failed";
      break;
  }
  object["message"] = message;
  object["parameters"] = json::array();
  for (const auto& parameter : parameters) {
    if (parameter.value.is_set()) {
      object["parameters"].push_back({parameter.name, to_yaml(parameter.value)});
    }
  }
  return object.dump(-1, ' ', false, json::error_handler_t::replace);
}

ChildMessage ChildMessage::from_json(const std::string& text) {
  ChildMessage message;
  try {
    const auto object = json::parse(text);
    const auto event = object.at("event").get<std::string>();
    if (event == "constructed") {
      message.event = Event::kConstructed;
    } else if (event == "active") {
      message.event = Event::kActive;
    } else if (event == "broke") {
      message.event = Event::kBroke;
    } else if (event == "alive") {
      message.event = Event::kAlive;
    } else if (event != "failed") {
      throw std::invalid_argument("event '" + event + "' is unknown");
    }
    message.message = object.at("message").get<std::string>();
    for (const auto& parameter : object.at("parameters")) {
      message.parameters.push_back({parameter.at(0).get<std::string>(),
                                    parse_parameter_value(parameter.at(1).get<std::string>())});
    }
  } catch (const json::exception& error) {
    throw std::invalid_argument(error.what());
  }
  return message;
}

ChildSupervisor::ChildSupervisor(std::string name, RestartPolicy policy, Launch launch, Log log)
    : name_(std::move(name)), policy_(policy), launch_(std::move(launch)), log_(std::move(log)) {}

void ChildSupervisor::launch(SteadyTime now) {
  try_launch(now);
}

void ChildSupervisor::try_launch(SteadyTime now) {
  relaunch_at_.reset();
  try {
    child_ = launch_();
    state_ = State::kLaunched;
    log_(LogSeverity::kInfo, name_ + " runs in process " + std::to_string(child_->pid()));
  } catch (const std::exception& error) {
    ended(std::string("could not be launched: ") + error.what(), now);
  }
}

void ChildSupervisor::activate() {
  activate_ = true;
  if (state_ == State::kConstructed) {
    state_ = State::kActivating;
    child_->start_component();
  }
}

void ChildSupervisor::stop() {
  relaunch_at_.reset();
  if (child_) {
    state_ = State::kStopping;
    child_->signal(SIGINT);
  } else if (state_ != State::kFailed) {
    state_ = State::kStopped;
  }
}

void ChildSupervisor::ask() {
  if (state_ == State::kActive && !asked_) {
    asked_ = true;
    child_->ask();
  }
}

void ChildSupervisor::on_message(const ChildMessage& message) {
  if (!child_ || state_ == State::kStopping) {
    return;
  }
  switch (message.event) {
    case ChildMessage::Event::kConstructed:
      state_ = State::kConstructed;
      parameters_ = message.parameters;
      if (activate_) {
        activate();
      }
      break;
    case ChildMessage::Event::kActive:
      state_ = State::kActive;
      was_active_ = true;
      break;
    case ChildMessage::Event::kBroke:
      broke_ = true;
      break;
    case ChildMessage::Event::kAlive:
      asked_ = false;
      break;
    case ChildMessage::Event::kFailed:
      if (was_active_) {
        // It ran before: its end counts as one more end by itself.
        log_(LogSeverity::kError, name_ + ": " + message.message);
      } else {
        fail(message.message);
      }
      break;
  }
}

void ChildSupervisor::on_exit(int status, SteadyTime now) {
  child_.reset();
  asked_ = false;
  last_exit_ = describe_exit(status);
  if (state_ == State::kStopping) {
    state_ = State::kStopped;
  } else if (state_ != State::kFailed) {
    ended(last_exit_, now);
  }
}

void ChildSupervisor::ended(const std::string& how, SteadyTime now) {
  last_exit_ = how;
  if (restarts_ >= policy_.limit) {
    fail(how + "; it was restarted " + std::to_string(restarts_) + " times, the limit is reached");
    log_(LogSeverity::kError, name_ + " " + error_);
    return;
  }
  ++restarts_;
  const auto pause = restart_pause(policy_, restarts_);
  state_ = State::kPausing;
  relaunch_at_ = now + pause;
  log_(LogSeverity::kError, name_ + " " + how + "; restart " + std::to_string(restarts_) + " of " +
                                std::to_string(policy_.limit) + " in " +
                                to_string(ParameterValue(to_seconds(pause))) + " s");
}

void ChildSupervisor::fail(const std::string& why) {
  state_ = State::kFailed;
  error_ = why;
}

void ChildSupervisor::on_time(SteadyTime now) {
  if (relaunch_at_ && now >= *relaunch_at_) {
    try_launch(now);
  }
}

const char* to_string(ChildSupervisor::State state) noexcept {
  switch (state) {
    case ChildSupervisor::State::kLaunched:
      return "launched";
    case ChildSupervisor::State::kConstructed:
      return "constructed";
    case ChildSupervisor::State::kActivating:
      return "activating";
    case ChildSupervisor::State::kActive:
      return "active";
    case ChildSupervisor::State::kPausing:
      return "waiting for restart";
    case ChildSupervisor::State::kStopping:
      return "stopping";
    case ChildSupervisor::State::kStopped:
      return "stopped";
    case ChildSupervisor::State::kFailed:
      return "failed";
  }
  return "unknown";
}

std::string describe_exit(int status) {
  if (WIFSIGNALED(status)) {
    const int number = WTERMSIG(status);
    const char* name = sigdescr_np(number);
    return "was killed by signal " + std::to_string(number) + " (" +
           (name != nullptr ? name : "unknown") + ")";
  }
  return "exited with code " + std::to_string(WEXITSTATUS(status));
}

Duration restart_pause(const RestartPolicy& policy, int restart) {
  const auto longest = std::max(kLongestPause, policy.backoff);
  auto pause = policy.backoff;
  for (int i = 1; i < restart && pause < longest; ++i) {
    pause *= 2;
  }
  return std::min(pause, longest);
}

}  // namespace pipescout::host
