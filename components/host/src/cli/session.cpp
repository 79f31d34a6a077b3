// SPDX-License-Identifier: Apache-2.0
#include "cli/session.hpp"

#include <unistd.h>

#include <algorithm>
#include <iostream>

#include "pipescout/dds/dds_transport.hpp"

namespace pipescout::host {
namespace {

/// From a signal to the end of the program.
constexpr Duration kGrace = std::chrono::seconds(2);

std::string sentence(const UnheardParticipant& participant) {
  const std::string port = std::to_string(participant.port);
  if (participant.has_no_udp) {
    return "somebody takes messages of this domain from shared memory port " + port +
           " alone, without UDP or in another network namespace";
  }
  std::string who = participant.process == 0 ? "a process of another user"
                                             : "process " + std::to_string(participant.process) +
                                                   " (" + participant.program + ")";
  if (participant.port != 0) {
    who += " at UDP port " + port;
  }
  return who + " has sockets of this domain and has not answered";
}

std::string sentence(const UntoldParticipant& untold) {
  const auto& participant = untold.participant;
  const std::string who = participant.name + " (" + to_string(participant.gid) + ")";
  return untold.has_told_its_nodes
             ? std::to_string(untold.undiscovered_endpoints) + " publishers and subscriptions of " +
                   who + " have not been discovered"
             : who + " has not said which nodes it has";
}

}  // namespace

void DiscoveryOptions::add_to(CLI::App& command, bool with_services) {
  const CLI::Range seconds(0.0, 1e6);
  command.add_option("--spin-time", spin_time, "Longest time for discovery, in seconds")
      ->check(seconds)
      ->capture_default_str();
  if (with_services) {
    command
        .add_option("--timeout", timeout,
                    "Longest time to wait for the reply of a service, in seconds")
        ->check(seconds)
        ->capture_default_str();
  }
}

Session::Session(DiscoveryOptions options)
    : options_(options),
      signals_(
          kGrace, [this](int signal) { interrupt(signal); }, [] {}),
      end_of_discovery_(add_saturated(begin_, from_seconds(options.spin_time))) {
  auto dds = DdsOptions::from_environment();
  dds.name = "pipescout command line";
  dds.super_client = true;
  dds.hears_unexported = true;
  is_alone_ = dds.localhost_only && dds.static_peers.empty() && dds.discovery_servers.empty();
  context_ = Context::create(create_dds_transport(dds));
  NodeOptions node;
  node.context = context_;
  node.executor = &executor_;
  node.name = {"/", "_pipescout_cli_" + std::to_string(getpid())};
  node.standard_interfaces = false;
  node_ = std::make_unique<Node>(std::move(node));
  graph_changes_ = graph().on_changed([this] { note_change(); });
}

Session::~Session() = default;

void Session::begin(const DiscoveryOptions& options) {
  options_ = options;
  end_of_discovery_ = add_saturated(steady_now(), from_seconds(options.spin_time));
}

void Session::note_change() {
  const std::lock_guard lock(mutex_);
  last_change_ = steady_now();
  changed_.notify_all();
}

void Session::interrupt(int signal) {
  {
    const std::lock_guard lock(mutex_);
    stop_signal_ = signal;
    changed_.notify_all();
  }
  executor_.stop();
}

void Session::throw_if_interrupted() const {
  const std::lock_guard lock(mutex_);
  if (stop_signal_ != 0) {
    throw CommandInterrupted(stop_signal_);
  }
}

void Session::spin_until(const std::function<bool()>& done) {
  constexpr auto kForever = std::chrono::hours(24 * 365);
  executor_.spin_until(done, kForever);
  throw_if_interrupted();
}

void Session::spin_for(Duration time) {
  executor_.spin_until([] { return false; }, time);
  throw_if_interrupted();
}

bool Session::wait_for(const std::function<bool()>& found) {
  std::unique_lock lock(mutex_);
  while (stop_signal_ == 0) {
    const auto seen = last_change_;
    lock.unlock();
    // With no lock held: it asks the graph.
    if (found()) {
      return true;
    }
    lock.lock();
    if (!changed_.wait_until(lock, end_of_discovery_,
                             [&] { return stop_signal_ != 0 || last_change_ != seen; })) {
      return false;
    }
  }
  throw CommandInterrupted(stop_signal_);
}

bool Session::may_be_others() const {
  const auto participants = context_->transport()->remote_participants();
  return !is_alone_ || std::any_of(participants.begin(), participants.end(), [](const auto& each) {
    return each.enclave.empty();  // not of ROS: does not say when it has told everything
  });
}

Session::Missing Session::what_is_missing() {
  // The census first: it forgets who has gone and so tells nothing any more.
  const auto unheard = context_->transport()->take_census();
  Missing missing;
  for (const auto& each : graph().untold()) {
    if (each.lacks()) {
      missing.may_come = true;
      missing.sentences.push_back(sentence(each));
    } else {
      missing.nodes_may_follow = true;
    }
  }
  for (const auto& each : unheard) {
    missing.may_come |= !each.has_no_udp;
    missing.sentences.push_back(sentence(each));
  }
  return missing;
}

std::vector<std::string> Session::discover(Duration quiet) {
  // The kernel does not tell when sockets come and go.
  constexpr Duration kLookAgain = std::chrono::milliseconds(50);
  const SteadyTime somebody_until = add_saturated(begin_, from_seconds(options_.spin_time));
  std::unique_lock lock(mutex_);
  while (stop_signal_ == 0) {
    const auto seen = last_change_;
    lock.unlock();
    Missing missing = what_is_missing();
    const bool has_found = is_alone_ || !context_->transport()->remote_participants().empty() ||
                           steady_now() >= somebody_until;
    const Duration quiet_asked =
        std::max(may_be_others() ? quiet : Duration{0},
                 missing.nodes_may_follow ? kLongestCollecting : Duration{0});
    lock.lock();
    const SteadyTime now = steady_now();
    const SteadyTime quiet_at = last_change_ + quiet_asked;
    if (now >= end_of_discovery_ ||
        (has_found && !missing.may_come && last_change_ == seen && now >= quiet_at)) {
      return std::move(missing.sentences);
    }
    const SteadyTime until = !missing.may_come && now < quiet_at ? quiet_at : now + kLookAgain;
    changed_.wait_until(lock, std::min(end_of_discovery_, until),
                        [&] { return stop_signal_ != 0 || last_change_ != seen; });
  }
  throw CommandInterrupted(stop_signal_);
}

void Session::settle() {
  for (const auto& sentence : discover()) {
    std::cerr << "WARNING: this may be incomplete: " << sentence << '\n';
  }
}

std::vector<NodeName> Session::nodes(bool hidden) {
  auto names = graph().nodes();
  std::erase_if(names, [&](const NodeName& name) {
    return name == node_->node_name() || (!hidden && name.name.starts_with('_'));
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

std::shared_ptr<UntypedClient> Session::create_client(const std::string& service,
                                                      const MessageType& request,
                                                      const MessageType& response) {
  return create_untyped_client(*context_, {.name = service,
                                           .request = &request,
                                           .response = &response,
                                           .group = node_->default_group()});
}

std::shared_ptr<const void> Session::call(UntypedClient& client,
                                          std::shared_ptr<const void> request,
                                          const std::string& service) {
  // Shared with the client, which answers what is left when it goes.
  const auto result = std::make_shared<std::optional<ServiceResult<void>>>();
  client.call(
      std::move(request), [result](const ServiceResult<void>& answer) { *result = answer; },
      from_seconds(options_.timeout));
  // The client itself watches the time; this one is only a bound on top of it.
  executor_.spin_until([&] { return result->has_value(); },
                       from_seconds(options_.timeout) + std::chrono::seconds(1));
  throw_if_interrupted();
  const auto answer = result->value_or(ServiceResult<void>(ServiceError::kTimeout));
  if (!answer) {
    throw CommandError("service " + service + ": " + to_string(answer.error()));
  }
  return answer.shared();
}

bool is_hidden(std::string_view name) {
  return name.starts_with('_') || name.find("/_") != std::string_view::npos;
}

std::string absolute_name(const std::string& name) {
  return name.starts_with('/') ? name : "/" + name;
}

std::string logger_of(const NodeName& node) {
  auto name = node.fully_qualified().substr(1);
  std::replace(name.begin(), name.end(), '/', '.');
  return name;
}

std::string full_type_name(const std::string& name) {
  const auto slash = name.find('/');
  const bool is_short =
      slash != std::string::npos && name.find('/', slash + 1) == std::string::npos;
  return is_short ? name.substr(0, slash) + "/msg" + name.substr(slash) : name;
}

}  // namespace pipescout::host
