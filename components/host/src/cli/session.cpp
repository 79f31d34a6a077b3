// SPDX-License-Identifier: Apache-2.0
#include "cli/session.hpp"

#include <unistd.h>

#include <algorithm>
#include <iterator>
#include <map>
#include <rmw_dds_common/msg/participant_entities_info.hpp>
#include <set>
#include "pipescout/dds/dds_transport.hpp"

namespace pipescout::host {
namespace {

/// From a signal to the end of the program.
constexpr Duration kGrace = std::chrono::seconds(2);

}  // namespace

/// What other nodes have said that they consist of. DDS discovers participants, their node lists
/// and each endpoint apart from each other, so only this tells when all of a node is known.
class Session::Announcements {
 public:
  /// `on_new` is called after each announcement; it must not call back.
  Announcements(Context& context, std::function<void()> on_new)
      : context_(context), on_new_(std::move(on_new)) {
    SubscriptionOptions options;
    options.topic = {"ros_discovery_info", &message_type<ParticipantEntitiesInfo>()};
    options.qos = QoS::latched(100);
    options.callback = [this](const std::shared_ptr<const void>& message, const MessageInfo&) {
      keep(*static_cast<const ParticipantEntitiesInfo*>(message.get()));
    };
    subscription_ = context.create_subscription(std::move(options));
  }

  /// There are participants; all those of ROS 2 have listed their endpoints, and these are
  /// discovered.
  [[nodiscard]] bool complete() const {
    const auto& transport = *context_.transport();
    std::set<Gid> discovered;
    for (const auto& endpoint : transport.remote_endpoints()) {
      discovered.insert(endpoint.gid);
    }
    const auto participants = transport.remote_participants();
    const std::lock_guard lock(mutex_);
    return !participants.empty() &&
           std::all_of(participants.begin(), participants.end(), [&](const auto& participant) {
             if (participant.enclave.empty()) {
               return true;  // not of ROS
             }
             const auto announced = endpoints_.find(participant.gid);
             return announced != endpoints_.end() &&
                    std::includes(discovered.begin(), discovered.end(), announced->second.begin(),
                                  announced->second.end());
           });
  }

 private:
  using ParticipantEntitiesInfo = rmw_dds_common::msg::ParticipantEntitiesInfo;

  static Gid to_gid(const rmw_dds_common::msg::Gid& message) {
    Gid gid;
    std::copy_n(message.data.begin(), gid.bytes.size(), gid.bytes.begin());
    return gid;
  }

  void keep(const ParticipantEntitiesInfo& info) {
    std::set<Gid> endpoints;
    for (const auto& node : info.node_entities_info_seq) {
      for (const auto* gids : {&node.reader_gid_seq, &node.writer_gid_seq}) {
        std::transform(gids->begin(), gids->end(), std::inserter(endpoints, endpoints.end()),
                       to_gid);
      }
    }
    const std::lock_guard lock(mutex_);
    endpoints_[to_gid(info.gid)] = std::move(endpoints);
    on_new_();
  }

  Context& context_;
  const std::function<void()> on_new_;
  mutable std::mutex mutex_;
  std::map<Gid, std::set<Gid>> endpoints_;  ///< by participant
  std::shared_ptr<UntypedSubscription> subscription_;
};

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
      end_of_discovery_(add_saturated(steady_now(), from_seconds(options.spin_time))) {
  auto dds = DdsOptions::from_environment();
  dds.name = "pipescout command line";
  dds.super_client = true;
  dds.hears_unexported = true;
  context_ = Context::create(create_dds_transport(dds));
  announcements_ = std::make_unique<Announcements>(*context_, [this] { note_change(); });
  NodeOptions node;
  node.context = context_;
  node.executor = &executor_;
  node.name = {"/", "_pipescout_cli_" + std::to_string(getpid())};
  node.standard_interfaces = false;
  node_ = std::make_unique<Node>(std::move(node));
  graph_changes_ = graph().on_changed([this] { note_change(); });
}

Session::~Session() = default;

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

void Session::settle(Duration quiet) {
  std::unique_lock lock(mutex_);
  last_change_ = steady_now();
  while (stop_signal_ == 0) {
    const SteadyTime now = steady_now();
    if (now >= end_of_discovery_) {
      return;
    }
    const auto quiet_at = last_change_ + quiet;
    if (now < quiet_at) {
      changed_.wait_until(lock, std::min(end_of_discovery_, quiet_at));
      continue;
    }
    const auto seen = last_change_;
    lock.unlock();
    const bool complete = announcements_->complete();
    lock.lock();
    if (complete && last_change_ == seen) {
      return;
    }
    // What is missing comes as a change of the graph.
    changed_.wait_until(lock, end_of_discovery_,
                        [&] { return stop_signal_ != 0 || last_change_ != seen; });
  }
  throw CommandInterrupted(stop_signal_);
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

std::string full_type_name(const std::string& name) {
  const auto slash = name.find('/');
  const bool is_short =
      slash != std::string::npos && name.find('/', slash + 1) == std::string::npos;
  return is_short ? name.substr(0, slash) + "/msg" + name.substr(slash) : name;
}

}  // namespace pipescout::host
