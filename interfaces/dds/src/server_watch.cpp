// SPDX-License-Identifier: Apache-2.0
#include "server_watch.hpp"

#include <algorithm>

#include "pipescout/dds/discovery_server.hpp"
#include "pipescout/runtime/logger.hpp"

namespace pipescout::dds {
namespace {

constexpr Duration kPeriod = std::chrono::seconds(1);

// A server that is there has answered by then.
constexpr Duration kPatience = std::chrono::seconds(3);

}  // namespace

ServerWatch::ServerWatch(EventThread& events, const Discovery& discovery,
                         const std::vector<DiscoveryServerAddress>& servers)
    : events_(events), discovery_(discovery) {
  const SteadyTime now = steady_now();
  for (const auto& address : servers) {
    servers_.push_back({.address = address, .missing_since = now});
  }
  events_.admit(this);
  look_again();
}

ServerWatch::~ServerWatch() {
  events_.dismiss(this);
}

std::vector<std::string> ServerWatch::missing() const {
  std::vector<std::string> sentences;
  const std::lock_guard lock(mutex_);
  for (const Server& server : servers_) {
    if (server.is_missing) {
      sentences.push_back(sentence(server));
    }
  }
  return sentences;
}

std::string ServerWatch::sentence(const Server& server) const {
  const bool all = std::all_of(servers_.begin(), servers_.end(),
                               [](const Server& each) { return each.is_missing; });
  return "discovery server " + to_string(server.address) + " (id " +
         std::to_string(server.address.id) + ") does not answer" +
         (all ? ": no other process is found until it does" : "; another one is there");
}

void ServerWatch::look_again() {
  events_.post_after(this, kPeriod, [this] {
    look();
    look_again();
  });
}

void ServerWatch::look() {
  const Logger logger("pipescout.transport");
  const SteadyTime now = steady_now();
  const std::lock_guard lock(mutex_);
  for (Server& server : servers_) {
    const bool was_missing = server.is_missing;
    if (discovery_.knows(discovery_server_identity(server.address.id))) {
      server.missing_since = now;
    }
    server.is_missing = now - server.missing_since >= kPatience;
    if (server.is_missing && !was_missing) {
      logger.warn(sentence(server));
    } else if (was_missing && !server.is_missing) {
      logger.info("discovery server " + to_string(server.address) + " is there");
    }
  }
}

}  // namespace pipescout::dds
