// SPDX-License-Identifier: Apache-2.0
#include "cli/session.hpp"

#include <unistd.h>

#include <algorithm>
#include <condition_variable>
#include <mutex>

namespace pipescout::host {

void DiscoveryOptions::add_to(CLI::App& command, bool with_services) {
  command
      .add_option("--spin-time", spin_time, "Seconds to look for others on the network, at most")
      ->check(CLI::NonNegativeNumber)
      ->capture_default_str();
  if (with_services) {
    command
        .add_option("--timeout", timeout, "Seconds to wait for the answer of a service, at most")
        ->check(CLI::NonNegativeNumber)
        ->capture_default_str();
  }
}

Session::Session(DiscoveryOptions options) : options_(options) {
  auto dds = DdsOptions::from_environment();
  dds.name = "pipescout command line";
  context_ = Context::create(create_dds_transport(dds));
  NodeOptions node;
  node.context = context_;
  node.executor = &executor_;
  node.name = {"/", "_pipescout_cli_" + std::to_string(getpid())};
  node.standard_interfaces = false;
  node_ = std::make_unique<Node>(std::move(node));
}

Session::~Session() = default;

void Session::settle(Duration quiet) {
  std::mutex mutex;
  std::condition_variable changed;
  SteadyTime last_change = std::chrono::steady_clock::now();
  const auto handle = graph().on_changed([&] {
    const std::lock_guard lock(mutex);
    last_change = std::chrono::steady_clock::now();
    changed.notify_all();
  });
  const SteadyTime end = last_change + spin_time();
  std::unique_lock lock(mutex);
  while (true) {
    const auto until = std::min(end, last_change + quiet);
    if (SteadyTime(std::chrono::steady_clock::now()) >= until) {
      return;
    }
    changed.wait_until(lock, until);
  }
}

std::vector<NodeName> Session::nodes(bool hidden) {
  auto names = graph().nodes();
  std::erase_if(names, [&](const NodeName& name) {
    return name == node_->node_name() || (!hidden && is_hidden(name.fully_qualified()));
  });
  return names;
}

NodeName Session::find_node(const std::string& name) {
  NodeName wanted;
  try {
    wanted = NodeName::parse(absolute_name(name));
  } catch (const InvalidName& error) {
    throw CommandError(error.what());
  }
  const bool found = wait_for([&] {
    const auto all = graph().nodes();
    return std::find(all.begin(), all.end(), wanted) != all.end();
  });
  if (!found) {
    throw CommandError("Node not found: " + wanted.fully_qualified());
  }
  return wanted;
}

bool Session::serves(const NodeName& node, std::string_view service, std::string_view type) {
  const auto services = graph().services();
  const auto found = services.find(node.fully_qualified() + "/" + std::string(service));
  return found != services.end() && found->second.contains(std::string(type));
}

bool is_hidden(std::string_view name) {
  return name.starts_with('_') || name.find("/_") != std::string_view::npos;
}

std::string absolute_name(const std::string& name) {
  return name.starts_with('/') ? name : "/" + name;
}

std::string full_type_name(const std::string& name) {
  const auto slash = name.find('/');
  const bool is_short =
      slash != std::string::npos && name.find('/', slash + 1) == std::string::npos;
  return is_short ? name.substr(0, slash) + "/msg" + name.substr(slash) : name;
}

}  // namespace pipescout::host
