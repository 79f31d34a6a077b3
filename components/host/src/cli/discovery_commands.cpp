// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <condition_variable>
#include <iostream>
#include <memory>
#include <mutex>
#include <string>

#include "cli/session.hpp"
#include "pipescout/command_line/text_table.hpp"
#include "pipescout/dds/dds_transport.hpp"
#include "pipescout/dds/discovery_server.hpp"
#include "run/service_manager.hpp"

namespace pipescout::host {
namespace {

/// From a signal to the end of the server.
constexpr Duration kServerGrace = std::chrono::seconds(2);

struct ServerStartOptions {
  int id = 0;
  std::string address = "0.0.0.0";
  int port = DiscoveryServerAddress::kDefaultPort;
};

struct ServerListOptions {
  DiscoveryOptions discovery;
};

/// A signal that is waited for.
class StopOrder {
 public:
  void come() {
    const std::lock_guard lock(mutex_);
    came_ = true;
    changed_.notify_all();
  }
  void wait() {
    std::unique_lock lock(mutex_);
    changed_.wait(lock, [this] { return came_; });
  }
  /// False after the time.
  bool wait_for(Duration time) {
    std::unique_lock lock(mutex_);
    return changed_.wait_for(lock, time, [this] { return came_; });
  }

 private:
  std::mutex mutex_;
  std::condition_variable changed_;
  bool came_ = false;
};

int start_server(const ServerStartOptions& options) {
  StopSignals::block();
  StopOrder stop;
  StopSignals signals(
      kServerGrace, [&](int) { stop.come(); }, [] {});
  // It makes servers of those that it names, which need not know each other.
  unsetenv("ROS_DISCOVERY_SERVER");
  DiscoveryServerOptions server;
  const auto environment = DdsOptions::from_environment();
  server.domain_id = environment.domain_id;
  server.network = environment.network;
  server.id = static_cast<std::uint8_t>(options.id);
  server.address = options.address;
  server.port = static_cast<std::uint16_t>(options.port);
  if (stop.wait_for(kTimeToForgetAServer)) {
    return kExitOk;
  }
  const auto running = start_discovery_server(server);
  const std::string place = options.address + ":" + std::to_string(options.port);
  std::cout << "discovery server " << options.id << " listens on " << place << std::endl;
  service_manager::tell_ready("listens on " + place);
  stop.wait();
  service_manager::tell_stopping();
  return kExitOk;
}

int list_servers(Session& session, const ServerListOptions&) {
  const auto servers = DdsOptions::from_environment().discovery_servers;
  if (servers.empty()) {
    throw CommandError("ROS_DISCOVERY_SERVER names no discovery server");
  }
  const auto* const transport = session.node().context().transport();
  const auto is_there = [&](const DiscoveryServerAddress& server) {
    const auto all = transport->remote_participants();
    return std::any_of(all.begin(), all.end(), [&](const DiscoveredParticipant& participant) {
      return participant.gid == discovery_server_identity(server.id);
    });
  };
  const bool all_there =
      session.wait_for([&] { return std::all_of(servers.begin(), servers.end(), is_there); });
  command_line::TextTable table({"id", "server", "state"});
  for (const auto& server : servers) {
    table.add_row({static_cast<std::int64_t>(server.id), to_string(server),
                   is_there(server) ? "answers" : "does not answer"});
  }
  table.print(std::cout);
  session.settle();
  std::cout << "participants:\n";
  for (const auto& participant : transport->remote_participants()) {
    const bool is_server =
        std::any_of(servers.begin(), servers.end(), [&](const DiscoveryServerAddress& server) {
          return participant.gid == discovery_server_identity(server.id);
        });
    if (!is_server) {
      std::cout << "  " << participant.name << "\n";
    }
  }
  return all_there ? kExitOk : kExitError;
}

}  // namespace

void add_discovery_commands(CLI::App& app, Action& action) {
  auto* group = app.add_subcommand("discovery", "Discovery servers of Fast DDS");
  group->require_subcommand(1);

  auto options = std::make_shared<ServerStartOptions>();
  auto* start = group->add_subcommand(
      "start", "Run a discovery server until it is stopped (SIGINT, SIGTERM)");
  start
      ->add_option("-i,--server-id", options->id,
                   "Its place in ROS_DISCOVERY_SERVER, counted from 0")
      ->check(CLI::Range(0, 255))
      ->capture_default_str();
  start
      ->add_option("-l,--listen", options->address,
                   "IPv4 address of the interface to listen on; 0.0.0.0: all")
      ->check(CLI::ValidIPV4)
      ->capture_default_str();
  start->add_option("-p,--port", options->port, "UDP port")
      ->check(CLI::Range(1, 65535))
      ->capture_default_str();
  start->callback([options, &action] { action = [options] { return start_server(*options); }; });

  add_session_command<ServerListOptions>(
      *group, action, "list",
      "Show which of the servers in ROS_DISCOVERY_SERVER answer, and who is known to them", false,
      list_servers);
}

}  // namespace pipescout::host
