// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <condition_variable>
#include <csignal>
#include <iostream>
#include <map>
#include <memory>
#include <mutex>
#include <rosgraph_msgs/msg/clock.hpp>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "pipescout/bag_topics/qos_profiles.hpp"
#include "pipescout/bags/bag_error.hpp"
#include "pipescout/bags/bag_reader.hpp"
#include "pipescout/runtime/component_container.hpp"
#include "pipescout/runtime/conversions.hpp"
#include "pipescout/runtime/standard_topics.hpp"
#include "pipescout/runtime/stop_signals.hpp"
#include "run/host_node.hpp"
#include "run/mission.hpp"
#include "run/run.hpp"

namespace pipescout::host {
namespace {

constexpr Duration kReplayGrace = std::chrono::milliseconds(2000);
/// For a transition, in which components compute at most.
constexpr Duration kTransitionTime = std::chrono::minutes(10);
constexpr const char* kRecorderClass = "pipescout::BagRecorder";

/// A signal that asks the process to end, for the one thread that does all the work.
class StopRequest {
 public:
  void set(int signal) {
    const std::lock_guard lock(mutex_);
    signal_ = signal;
    changed_.notify_all();
  }
  [[nodiscard]] int signal() const {
    const std::lock_guard lock(mutex_);
    return signal_;
  }
  /// Until that time, or the request.
  void wait_until(SteadyTime when) {
    std::unique_lock lock(mutex_);
    changed_.wait_until(lock, when, [this] { return signal_ != 0; });
  }

 private:
  mutable std::mutex mutex_;
  std::condition_variable changed_;
  int signal_ = 0;
};

/// Topics of every node: what stands in them is of this machine and its time.
bool is_about_the_process(const std::string& topic) {
  static const std::set<std::string_view> kNames{topics::kRosout.name, topics::kDiagnostics.name,
                                                 topics::kParameterEvents.name};
  return kNames.contains(topic) || topic.ends_with("/transition_event");
}

class Replay {
 public:
  Replay(const RunOptions& options, const ReplayOptions& replay)
      : options_(options),
        replay_(replay),
        signals_(
            kReplayGrace,
            [this](int number) {
              stop_.set(number);
              std::cerr << "stopping\n";
            },
            [] {}) {}

  int run() {
    bool failed = false;
    try {
      reader_ = std::make_unique<bags::BagReader>(replay_.bag);
      mission_.open(options_, registry_);
      make_components();
      open_mission();
      start_components();
      feed();
    } catch (const std::exception& error) {
      std::cerr << "error: " << error.what() << '\n';
      failed = true;
    }
    signals_.expect_end();
    failed = !end() || failed;
    return failed ? 1 : stop_.signal() != 0 ? 128 + stop_.signal() : 0;
  }
  /// Nothing: no mission was begun.
  [[nodiscard]] std::optional<std::filesystem::path> mission() const {
    return folder_ ? std::optional(folder_->path()) : std::nullopt;
  }

 private:
  [[nodiscard]] bool stopping() const { return stop_.signal() != 0; }
  /// All that the components do now, and what follows from it.
  void settle() { executor_.spin_ready(); }

  void make_components() {
    context_ = Context::create_in_process();
    set_first_time();
    progress_.emplace(mission_.composition.complete_when);
    container_ = std::make_unique<ComponentContainer>(
        ContainerOptions{
            context_, &executor_, {join_namespaces("/", options_.ns), "pipescout_container"}},
        registry_);
    if (replay_.record) {
      // First, so that it is the last to end.
      recorder_ =
          load({.class_name = kRecorderClass,
                .name = {container_->node().node_name().ns, "replay_recorder"},
                .remap_rules = {RemapRule::parse(std::string(topics::kClock.name) + ":=" + clock_)},
                .parameter_overrides = {parameter("output", *replay_.record),
                                        parameter("storage", "mcap"),
                                        parameter("repeatable", true)}})
              .component;
    }
    for (const auto& entry : mission_.composition.components) {
      LoadRequest request;
      request.class_name = entry.type;
      request.name = entry.name;
      request.remap_rules = entry.remappings;
      request.parameter_overrides = entry.parameters;
      request.log_threshold = entry.log_level;
      try {
        components_.push_back(load(std::move(request)).component);
      } catch (const std::exception& error) {
        throw StartError(located(entry, error.what()));
      }
      parameters_.push_back(components_.back()->parameters().all());
    }
    check_parameter_arguments(mission_.composition, parameters_);
  }

  static ParameterOverride parameter(const char* name, ParameterValue value) {
    return {.name = name, .value = std::move(value), .source = "pipescout run --bag"};
  }
  LoadedComponent load(LoadRequest request) {
    request.parameter_overrides.push_back(parameter("use_sim_time", true));
    return container_->load(std::move(request));
  }

  void open_mission() {
    folder_.emplace(mission_.folder);
    folder_->write_composition(to_yaml(mission_.composition, parameters_));
    folder_->write_versions(versions_of(mission_.composition, registry_));
    std::cout << "mission folder: " << folder_->path().string() << std::endl;
    std::vector<NodeName> names;
    for (const auto& entry : mission_.composition.components) {
      names.push_back(entry.name);
    }
    HostNode::Callbacks callbacks;
    callbacks.reported = [this](const NodeName& name, ComponentReport report) {
      progress_->report(name, report);
    };
    callbacks.broke = [this](const NodeName& name) { broken_ = name.fully_qualified(); };
    host_ = std::make_unique<HostNode>(container_->node(), names, names, std::move(callbacks));
    host_->log_into(*folder_);
  }

  void change(Component& component, LifecycleTransition transition) {
    // Shared with the component, which may outlive this call.
    const auto result = std::make_shared<std::optional<TransitionResult>>();
    component.request_transition(transition,
                                 [result](const TransitionResult& outcome) { *result = outcome; });
    executor_.spin_until([&] { return result->has_value() || stopping(); }, kTransitionTime);
    if (*result && !(*result)->success) {
      throw StartError("component " + component.node_name().fully_qualified() + ": " +
                       (*result)->message);
    }
    settle();
  }

  /// The topic of the time that all components follow, as the composition remaps it.
  [[nodiscard]] std::string clock_topic() const {
    std::set<std::string> clocks;
    for (const auto& entry : mission_.composition.components) {
      clocks.insert(resolve_topic_name(topics::kClock.name, entry.name, entry.remappings));
    }
    if (clocks.size() > 1) {
      throw StartError(mission_.composition.path + ": the components follow the clocks " +
                       *clocks.begin() + " and " + *clocks.rbegin() +
                       "; replay the robots one by one");
    }
    return clocks.empty() ? std::string(topics::kClock.name) : *clocks.begin();
  }

  /// The components never see the time leap from zero to that of the recording.
  void set_first_time() {
    auto first = Time(Duration(reader_->metadata().starting_time));
    clock_ = clock_topic();
    reader_->set_filter({.topics = std::vector{clock_}});
    if (const auto message = reader_->next()) {
      const auto content = deserialize(message_type<rosgraph_msgs::msg::Clock>(), message->data);
      if (content) {
        first = from_message(static_cast<const rosgraph_msgs::msg::Clock*>(content.get())->clock);
      }
    }
    context_->simulated_clock(clock_)->set(first);
  }

  /// All are configured before one is active: what is read, and what is recorded, is known then.
  void start_components() {
    for (const auto& component : components_) {
      change(*component, LifecycleTransition::kConfigure);
    }
    if (recorder_) {
      std::vector<std::string> outputs;
      for (const auto& topic : published()) {
        if (!is_about_the_process(topic)) {
          outputs.push_back(topic);
        }
      }
      static_cast<void>(recorder_->parameters().set("topics", outputs));
      change(*recorder_, LifecycleTransition::kConfigure);
      change(*recorder_, LifecycleTransition::kActivate);
    }
    for (const auto& component : components_) {
      if (!stopping()) {
        change(*component, LifecycleTransition::kActivate);
      }
    }
  }

  /// Topics that the composition publishes.
  [[nodiscard]] std::set<std::string> published() const {
    std::set<std::string> topics;
    for (const auto& component : components_) {
      for (const auto& publisher : component->publishers()) {
        topics.insert(ros_name(publisher->topic()));
      }
    }
    return topics;
  }
  [[nodiscard]] std::set<std::string> subscribed() const {
    std::set<std::string> topics;
    for (const auto& component : components_) {
      for (const auto& subscription : component->subscriptions()) {
        topics.insert(ros_name(subscription->topic()));
      }
    }
    return topics;
  }
  static std::string ros_name(const WireTopic& topic) {
    const auto demangled = demangle_topic_name(topic.name);
    return demangled ? demangled->name : topic.name;
  }

  /// Makes a publisher for each topic that is to be read, and has nothing else read.
  void choose_inputs() {
    const auto own = published();
    const auto wanted = subscribed();
    std::vector<std::string> inputs;
    inputs_.resize(reader_->topics().size());
    for (std::size_t i = 0; i < inputs_.size(); ++i) {
      const auto& topic = reader_->topics()[i];
      const bool is_clock = topic.name == clock_;
      if (!is_clock && (!wanted.contains(topic.name) || own.contains(topic.name))) {
        continue;
      }
      if (topic.serialization_format != "cdr") {
        throw StartError(replay_.bag + ": topic " + topic.name + ": its messages are '" +
                         topic.serialization_format + "', not cdr");
      }
      QoS qos = offer_for(qos_profiles_from_yaml(topic.offered_qos_profiles));
      // Nothing is lost here, and nobody hears of deadlines and leases of another time.
      qos = {.depth = qos.depth, .durability = qos.durability};
      inputs_[i] = container_->node().create_generic_publisher(topic.name, topic.type, qos,
                                                               {.managed = false});
      inputs.push_back(topic.name);
      has_clock_ = has_clock_ || is_clock;
    }
    if (inputs.empty() || (has_clock_ && inputs.size() == 1)) {
      throw StartError(replay_.bag + ": has no topic that the composition subscribes to");
    }
    reader_->set_filter({.topics = std::move(inputs)});
    if (!has_clock_) {
      clock_publisher_ = container_->node().create_publisher<rosgraph_msgs::msg::Clock>(
          clock_, topics::kClock.qos, {.managed = false});
    }
    settle();
  }

  void feed() {
    choose_inputs();
    std::uint64_t messages = 0;
    std::optional<Time> first;
    const SteadyTime begin = steady_now();
    while (is_running()) {
      const auto message = reader_->next();
      if (!message) {
        break;
      }
      const Time stamp{Duration(message->log_time)};
      first = first.value_or(stamp);
      if (replay_.rate && stamp > *first) {
        stop_.wait_until(
            add_saturated(begin, from_seconds(to_seconds(stamp - *first) / *replay_.rate)));
      }
      if (!has_clock_) {
        advance_clock(stamp);
      }
      inputs_.at(message->topic).publish(SerializedMessage(message->data));
      settle();
      ++messages;
    }
    if (!stopping()) {
      container_->node().logger().info(std::to_string(messages) + " messages of " + replay_.bag +
                                       " were replayed");
    }
  }

  /// False when there is nothing to go on for. Throws when a component cannot go on.
  [[nodiscard]] bool is_running() const {
    if (!broken_.empty()) {
      throw std::runtime_error("component " + broken_ + " went through its error state");
    }
    if (progress_->outcome() == MissionProgress::Outcome::kFailed) {
      throw std::runtime_error("component " + progress_->failure());
    }
    return !stopping() && progress_->outcome() == MissionProgress::Outcome::kRunning;
  }

  /// A bag without /clock: the time is that of its messages, and stops for each timer on the way.
  void advance_clock(Time to) {
    const auto clock = context_->simulated_clock(clock_);
    while (is_running()) {
      const auto due = clock->next_due();
      if (!due || *due >= to || *due <= clock->now()) {
        break;
      }
      set_clock(*due);
    }
    if (to > clock->now()) {
      set_clock(to);
    }
  }
  void set_clock(Time time) {
    rosgraph_msgs::msg::Clock message;
    message.clock = to_message(time);
    clock_publisher_.publish(message);
    settle();
  }

  /// False when something did not end well.
  bool end() {
    bool good = true;
    if (container_) {
      for (auto& input : inputs_) {
        input = {};
      }
      clock_publisher_ = {};
      components_.clear();
      recorder_.reset();
      bool unloaded = false;
      container_->unload_all([&] { unloaded = true; });
      executor_.spin_until([&] { return unloaded; }, kReplayGrace);
      settle();  // what was logged on the way
      if (!unloaded) {
        std::cerr << "error: the components did not stop in time\n";
        good = false;
      }
    }
    return good;
  }

  const RunOptions& options_;
  const ReplayOptions& replay_;
  StopRequest stop_;
  StopSignals signals_;
  ComponentRegistry registry_;
  std::unique_ptr<bags::BagReader> reader_;
  Mission mission_;
  std::optional<MissionFolder> folder_;
  std::optional<MissionProgress> progress_;
  std::string broken_;
  std::vector<std::vector<NamedParameter>> parameters_;
  std::shared_ptr<Context> context_;
  Executor executor_;
  std::unique_ptr<ComponentContainer> container_;
  std::unique_ptr<HostNode> host_;
  std::vector<std::shared_ptr<Component>> components_;
  std::shared_ptr<Component> recorder_;
  std::vector<GenericPublisher> inputs_;  // by the bag's index; empty: not read
  Publisher<rosgraph_msgs::msg::Clock> clock_publisher_;
  std::string clock_;
  bool has_clock_ = false;  // the bag
};

}  // namespace

int replay_composition(const RunOptions& options, const ReplayOptions& replay) {
  std::signal(SIGPIPE, SIG_IGN);
  StopSignals::block();
  std::optional<std::filesystem::path> mission;
  int code = 0;
  {
    Replay run(options, replay);
    code = run.run();
    mission = run.mission();
  }
  return !mission || summarise_mission(*mission) ? code : 1;
}

}  // namespace pipescout::host
