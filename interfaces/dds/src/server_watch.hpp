// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <mutex>
#include <string>
#include <vector>

#include "discovery.hpp"
#include "event_thread.hpp"
#include "pipescout/dds/network_options.hpp"
#include "pipescout/runtime/time.hpp"

namespace pipescout::dds {

/// Whether the discovery servers of a participant are there. Logs that one is missing, and that it
/// is back. Thread-safe.
class ServerWatch {
 public:
  /// `events` and `discovery` must outlive it.
  ServerWatch(EventThread& events, const Discovery& discovery,
              const std::vector<DiscoveryServerAddress>& servers);
  ServerWatch(const ServerWatch&) = delete;
  ServerWatch& operator=(const ServerWatch&) = delete;
  ~ServerWatch();

  /// A sentence for each server that has been missing for some time.
  [[nodiscard]] std::vector<std::string> missing() const;

 private:
  struct Server {
    DiscoveryServerAddress address;
    SteadyTime missing_since;
    bool is_missing = false;  ///< for so long that it was said
  };

  void look();
  void look_again();
  [[nodiscard]] std::string sentence(const Server& server) const;  // under mutex_

  EventThread& events_;
  const Discovery& discovery_;
  mutable std::mutex mutex_;
  std::vector<Server> servers_;
};

}  // namespace pipescout::dds
