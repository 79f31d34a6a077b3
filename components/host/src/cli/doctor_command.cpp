// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <filesystem>
#include <iostream>
#include <rcl_interfaces/srv/get_parameters.hpp>
#include <sensor_msgs/msg/camera_info.hpp>
#include <sensor_msgs/msg/imu.hpp>
#include <sensor_msgs/msg/nav_sat_fix.hpp>

#include "cli/session.hpp"
#include "doctor/checks.hpp"
#include "doctor/machine.hpp"
#include "doctor/trial.hpp"
#include "pipescout/files/temporary_folder.hpp"
#include "pipescout/runtime/conversions.hpp"
#include "run/run.hpp"

namespace pipescout::host {
namespace {

namespace fs = std::filesystem;
using doctor::Observation;

struct DoctorOptions {
  DiscoveryOptions discovery;
  RunOptions run;
  double listen = 2.0;  ///< s
  /// For a component to be made and configured, s: maps and pictures are read then.
  double patience = 60.0;
};

/// Listens to the sensors that others publish.
class Listener {
 public:
  Listener(Session& session, Observation& seen) : session_(session), seen_(seen) {
    for (const auto& [topic, types] : session.graph().topics()) {
      const bool published = std::any_of(
          seen.endpoints.begin(), seen.endpoints.end(), [&topic = topic](const auto& endpoint) {
            return endpoint.is_publisher &&
                   endpoint.wire_topic == mangle_topic_name(topic, DdsTopicKind::kTopic);
          });
      if (!published) {
        continue;
      }
      if (types.contains("sensor_msgs/msg/Imu")) {
        listen<sensor_msgs::msg::Imu>(topic, [this, topic = topic](const auto& imu) {
          auto& sample = seen_.imus[topic];
          sample.frame = imu.header.frame_id;
          const auto& force = imu.linear_acceleration;
          const auto& rate = imu.angular_velocity;
          sample.specific_force.push_back({force.x, force.y, force.z});
          sample.angular_velocity.push_back({rate.x, rate.y, rate.z});
        });
      } else if (types.contains("sensor_msgs/msg/NavSatFix")) {
        listen<sensor_msgs::msg::NavSatFix>(topic, [this, topic = topic](const auto& fix) {
          auto& sample = seen_.fixes[topic];
          sample.has_fix = fix.status.status >= sensor_msgs::msg::NavSatStatus::STATUS_FIX;
          sample.latitude = fix.latitude;
          sample.longitude = fix.longitude;
          std::copy(fix.position_covariance.begin(), fix.position_covariance.end(),
                    sample.covariance.begin());
          sample.covariance_type = fix.position_covariance_type;
        });
      } else if (types.contains("sensor_msgs/msg/CameraInfo")) {
        listen<sensor_msgs::msg::CameraInfo>(topic, [this, topic = topic](const auto& camera) {
          seen_.cameras[topic] = {camera.k[0], camera.width, camera.height};
        });
      }
    }
  }
  Listener(const Listener&) = delete;
  Listener& operator=(const Listener&) = delete;
  ~Listener() {
    for (auto& [topic, ages] : ages_) {
      const auto middle = ages.begin() + static_cast<std::ptrdiff_t>(ages.size() / 2);
      std::nth_element(ages.begin(), middle, ages.end());
      seen_.stamp_age[topic] = *middle;
    }
  }
  [[nodiscard]] bool hears_anything() const { return !subscriptions_.empty(); }

 private:
  template <class T, class Take>
  void listen(const std::string& topic, Take take) {
    subscriptions_.push_back(session_.node()
                                 .create_subscription<T>(topic, QoS::sensor_data(100),
                                                         [this, topic, take](const T& message) {
                                                           take(message);
                                                           ages_[topic].push_back(to_seconds(
                                                               session_.node().now() -
                                                               from_message(message.header.stamp)));
                                                         })
                                 .untyped());
  }

  Session& session_;
  Observation& seen_;
  std::map<std::string, std::vector<double>> ages_;
  std::vector<std::shared_ptr<UntypedSubscription>> subscriptions_;
};

void ask_for_datums(Session& session, Observation& seen) {
  using rcl_interfaces::srv::GetParameters;
  for (const auto& node : session.nodes(false)) {
    if (!session.serves(node, "get_parameters", "rcl_interfaces/srv/GetParameters")) {
      continue;
    }
    GetParameters::Request request;
    request.names = {"datum"};
    try {
      const auto response =
          session.call<GetParameters>(node.fully_qualified() + "/get_parameters", request);
      if (response->values.size() == 1) {
        const auto value = from_message(response->values.front());
        if (value.type() == ParameterType::kDoubleArray) {
          seen.datums[node] = value.get<std::vector<double>>();
        }
      }
    } catch (const CommandError& error) {
      std::cerr << error.what() << '\n';
    }
  }
}

void look_at_network(Session& session, const DoctorOptions& options, Observation& seen) {
  seen.undiscovered = session.discover();
  seen.nodes = session.nodes(true);
  // Nodes of command lines come and go.
  std::erase_if(seen.nodes, [](const NodeName& node) { return node.name.starts_with("_"); });
  seen.endpoints = session.graph().endpoints();
  std::erase_if(seen.endpoints, [](const GraphEndpoint& each) { return each.in_this_process; });
  for (const auto& participant : session.node().context().transport()->remote_participants()) {
    auto& nodes = participant.is_on_loopback_alone ? seen.nodes_on_loopback_alone
                                                   : seen.nodes_beyond_loopback;
    for (const auto& each : seen.endpoints) {
      if (each.node && participant_of(each.gid) == participant.gid) {
        nodes.insert(*each.node);
      }
    }
  }
  const auto clock = mangle_topic_name("/clock", DdsTopicKind::kTopic);
  seen.simulated_time = std::any_of(
      seen.endpoints.begin(), seen.endpoints.end(),
      [&clock](const auto& each) { return each.is_publisher && each.wire_topic == clock; });
  {
    const Listener listener(session, seen);
    if (listener.hears_anything()) {
      session.spin_for(from_seconds(options.listen));
    }
  }
  if (!seen.fixes.empty()) {
    ask_for_datums(session, seen);
  }
}

int examine(const DoctorOptions& options) {
  Observation seen;
  const auto& run = options.run;
  seen.machine = doctor::look_at_machine(run.out.value_or("."));
  try {
    Session session(options.discovery);
    look_at_network(session, options, seen);
  } catch (const TransportError& error) {
    seen.unreachable_network = error.what();
  }
  if (!run.composition.empty()) {
    // What the components on trial write goes there.
    const TemporaryFolder folder;
    auto inputs = run.inputs();
    inputs.mission_folder = [&folder](const std::string&) { return folder.path().string(); };
    doctor::try_composition(load_composition(run.composition, inputs),
                            from_seconds(options.patience), seen);
  }
  const auto findings = doctor::examine(seen);
  std::cout << doctor::report(findings);
  return doctor::has_errors(findings) ? kExitError : kExitOk;
}

}  // namespace

void add_doctor_command(CLI::App& app, Action& action) {
  const auto options = std::make_shared<DoctorOptions>();
  auto* const command =
      app.add_subcommand("doctor", "Look for what is wrong, before a run or in a running system");
  options->discovery.add_to(*command, true);
  command->callback([options, &action] { action = [options] { return examine(*options); }; });
  auto& run = options->run;
  command->add_option("composition", run.composition,
                      "Composition file: its components are made and configured on trial");
  command->add_option("arguments", run.arguments, "Arguments of the composition, NAME:=VALUE");
  command->add_option("--namespace", run.ns, "Namespace of all components, such as /robot_1")
      ->capture_default_str();
  command->add_option("--out", run.out, "Where the recording will be; default: this folder");
  command->add_option("--listen", options->listen, "Seconds to listen to sensors")
      ->check(CLI::Range(0.1, 3600.0))
      ->capture_default_str();
  command
      ->add_option("--patience", options->patience,
                   "Seconds for a component to be made and configured")
      ->check(CLI::Range(0.1, 3600.0))
      ->capture_default_str();
}

}  // namespace pipescout::host
