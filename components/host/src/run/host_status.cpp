// SPDX-License-Identifier: Apache-2.0
#include "run/host_status.hpp"

#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <fstream>
#include <iterator>
#include <sstream>
#include <utility>

#include "doctor/checks.hpp"
#include "pipescout/runtime/diagnostics.hpp"

namespace pipescout::host {
namespace {

std::string proc_file(pid_t pid, const char* name) {
  std::ifstream file("/proc/" + std::to_string(pid) + "/" + name);
  return {std::istreambuf_iterator<char>(file), {}};
}

/// Resident, of /proc/PID/statm; 0 for a process that has gone.
double memory_megabytes(pid_t pid) {
  constexpr double kMegabyte = 1e6;
  std::istringstream text(proc_file(pid, "statm"));
  double total = 0.0;
  double resident = 0.0;
  text >> total >> resident;
  return resident * static_cast<double>(sysconf(_SC_PAGESIZE)) / kMegabyte;
}

std::string with_one_decimal(double number) {
  std::ostringstream text;
  text.imbue(std::locale::classic());
  text.setf(std::ios::fixed);
  text.precision(1);
  text << number;
  return text.str();
}

void add(diagnostic_msgs::msg::DiagnosticStatus& status, const char* key, std::string value) {
  diagnostic_msgs::msg::KeyValue pair;
  pair.key = key;
  pair.value = std::move(value);
  status.values.push_back(std::move(pair));
}

diagnostic_msgs::msg::DiagnosticStatus make_status(const std::string& name) {
  diagnostic_msgs::msg::DiagnosticStatus status;
  status.level = static_cast<std::uint8_t>(DiagnosticLevel::kOk);
  status.name = name;
  status.hardware_id = "none";
  return status;
}

}  // namespace

double cpu_seconds_in(const std::string& stat, double ticks) {
  // The second field, a name in parentheses, may itself contain blanks and parentheses.
  const auto name_end = stat.rfind(')');
  if (name_end == std::string::npos) {
    return -1.0;
  }
  constexpr int kFieldsBefore = 11;  // from `state` to `cmajflt`, see proc(5)
  std::istringstream text(stat.substr(name_end + 1));
  std::string skipped;
  for (int field = 0; field < kFieldsBefore; ++field) {
    text >> skipped;
  }
  double user = 0.0;
  double system = 0.0;
  return text >> user >> system ? (user + system) / ticks : -1.0;
}

HostStatus::HostStatus(const NodeName& host, std::vector<NodeName> components)
    : name_(host.fully_qualified().substr(1)),
      nodes_(std::move(components)),
      started_(std::chrono::system_clock::now()) {
  nodes_.push_back(host);
  std::sort(nodes_.begin(), nodes_.end());
}

diagnostic_msgs::msg::DiagnosticStatus HostStatus::process(const std::vector<pid_t>& children,
                                                           SteadyTime now) {
  const auto ticks = static_cast<double>(sysconf(_SC_CLK_TCK));
  std::vector<pid_t> pids = children;
  pids.push_back(getpid());
  std::map<pid_t, double> seconds;
  double grown = 0.0;
  double memory = 0.0;
  for (const pid_t pid : pids) {
    const double total = cpu_seconds_in(proc_file(pid, "stat"), ticks);
    if (total < 0.0) {
      continue;
    }
    const auto before = cpu_seconds_.find(pid);
    grown += total - (before == cpu_seconds_.end() ? 0.0 : before->second);
    seconds.emplace(pid, total);
    memory += memory_megabytes(pid);
  }
  auto status = make_status(name_ + ": process");
  // The first time there is nothing to compare with.
  if (!cpu_seconds_.empty() && now > looked_at_) {
    constexpr double kPercent = 100.0;
    add(status, "cpu_percent", with_one_decimal(kPercent * grown / to_seconds(now - looked_at_)));
  }
  cpu_seconds_ = std::move(seconds);
  looked_at_ = now;
  add(status, "started", with_one_decimal(to_seconds(started_.time_since_epoch())));
  add(status, "memory_mb", with_one_decimal(memory));
  add(status, "processes", std::to_string(cpu_seconds_.size()));
  return status;
}

diagnostic_msgs::msg::DiagnosticStatus HostStatus::clock(const std::optional<ClockStep>& step) {
  auto status = make_status(name_ + ": clock");
  if (step) {
    ++clock_steps_;
    last_clock_step_ = to_text(*step);
    status.level = static_cast<std::uint8_t>(DiagnosticLevel::kWarn);
    status.message = last_clock_step_;
  }
  add(status, "steps", std::to_string(clock_steps_));
  add(status, "last_step", last_clock_step_.empty() ? "none" : last_clock_step_);
  return status;
}

diagnostic_msgs::msg::DiagnosticStatus HostStatus::network(const Graph& graph,
                                                           const std::string& error) const {
  doctor::Observation seen;
  seen.nodes = graph.nodes();
  std::erase_if(seen.nodes, [this](const NodeName& node) {
    return !std::binary_search(nodes_.begin(), nodes_.end(), node);
  });
  seen.endpoints = graph.endpoints();
  auto status = make_status(name_ + ": network");
  if (!error.empty()) {
    status.level = static_cast<std::uint8_t>(DiagnosticLevel::kError);
    status.message = error;
  }
  for (const auto& check : {doctor::check_node_names, doctor::check_clock_publishers}) {
    for (const auto& finding : check(seen)) {
      status.level = static_cast<std::uint8_t>(DiagnosticLevel::kError);
      status.message += (status.message.empty() ? "" : " ") + finding.what;
    }
  }
  return status;
}

}  // namespace pipescout::host
