// SPDX-License-Identifier: Apache-2.0
#include "run/run.hpp"

#include <pthread.h>
#include <sys/signalfd.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <csignal>
#include <deque>
#include <iostream>
#include <system_error>
#include <utility>

#include "core/clock_watch.hpp"
#include "core/watchdog.hpp"
#include "pipescout/command_line/progress_printer.hpp"
#include "pipescout/dds/dds_transport.hpp"
#include "pipescout/runtime/component_container.hpp"
#include "pipescout/runtime/stop_signals.hpp"
#include "run/child_process.hpp"
#include "run/event_loop.hpp"
#include "run/executors.hpp"
#include "run/export_relay.hpp"
#include "run/host_node.hpp"
#include "run/host_status.hpp"
#include "run/mission.hpp"
#include "run/name_keeper.hpp"
#include "run/service_manager.hpp"

namespace pipescout::host {
namespace {

/// From the request to stop until the process has ended; of that, for the components.
constexpr Duration kGrace = std::chrono::milliseconds(2000);
constexpr Duration kComponentGrace = std::chrono::milliseconds(1500);
/// For the components of a mission that has ended by itself: nobody waits, and what was recorded
/// may have to wait for a busy disk.
constexpr Duration kGraceAfterTheEnd = std::chrono::seconds(30);
constexpr Duration kDiagnosticsPeriod = std::chrono::seconds(1);
/// While a fleet comes up, the graph changes all the time.
constexpr Duration kLeastBetweenLooks = std::chrono::milliseconds(200);

/// One component of the running composition: loaded here, or in a process of its own.
struct Running {
  const ComponentEntry* entry = nullptr;
  Executor* executor = nullptr;  ///< of its own; null: that of the composition
  std::uint64_t id = 0;          ///< in the container; 0: not loaded
  bool unloaded = false;
  std::vector<NamedParameter> parameters;
  std::unique_ptr<ChildSupervisor> supervisor;  ///< isolated components

  [[nodiscard]] bool has_stopped() const {
    return supervisor ? !supervisor->running() : id == 0 || unloaded;
  }
};

/// How the components stopped.
struct StopOutcome {
  bool in_time = true;  ///< all of them
  /// A callback hangs on a thread of this process: nothing can be destroyed any more.
  bool hangs_here = false;
};

/// SIGCHLD as a file descriptor, for the loop.
class ChildSignal {
 public:
  ChildSignal() {
    sigset_t set;
    sigemptyset(&set);
    sigaddset(&set, SIGCHLD);
    pthread_sigmask(SIG_BLOCK, &set, nullptr);
    fd_ = signalfd(-1, &set, SFD_CLOEXEC | SFD_NONBLOCK);
    if (fd_ < 0) {
      throw std::system_error(errno, std::generic_category(), "signalfd");
    }
  }
  ChildSignal(const ChildSignal&) = delete;
  ChildSignal& operator=(const ChildSignal&) = delete;
  ~ChildSignal() { close(fd_); }

  [[nodiscard]] int fd() const noexcept { return fd_; }
  void drain() const {
    signalfd_siginfo info{};
    while (read(fd_, &info, sizeof info) == sizeof info) {
    }
  }

 private:
  int fd_ = -1;
};

class Run {
 public:
  explicit Run(const RunOptions& options)
      : options_(options),
        signals_(
            kGrace,
            [this](int number) {
              loop_.post([this, number] {
                stop_signal_ = number;
                progress_printer_.finish();
                std::cerr << "stopping\n";
              });
            },
            [] { ChildProcess::signal_all(SIGKILL); }),
        progress_printer_(std::cout, isatty(STDOUT_FILENO) == 1) {}

  /// What is left to be done when nothing runs any more.
  struct End {
    int code = 0;
    /// Folder of the mission that is to be summarised; nothing: there is none, or it has been.
    std::optional<std::filesystem::path> mission{};
  };

  End run() {
    loop_.watch(child_signal_.fd(), [this] { reap_children(); });
    loop_.on_turn([this](SteadyTime now) { return on_turn(now); });
    bool failed = false;
    try {
      read_composition();
      make_components();
      open_mission();
      start_components();
      wait_for_end();
    } catch (const std::exception& error) {
      std::cerr << "error: " << error.what() << '\n';
      failed = true;
    }
    show_progress(steady_now());
    progress_printer_.finish();
    const bool ends_by_itself = !stopping() && !failed;
    if (!ends_by_itself) {
      signals_.expect_end();
    }
    service_manager::tell_stopping();
    // From now on the time of grace counts, which is shorter.
    watchdog_.reset();
    const auto stopped = stop_components(ends_by_itself ? kGraceAfterTheEnd : kComponentGrace);
    signals_.expect_end();
    failed = !stopped.in_time || failed;
    finish_log();
    if (stopped.hangs_here) {
      if (folder_) {
        finish_summary(folder_->path());
      }
      std::cout.flush();
      std::cerr.flush();
      ChildProcess::signal_all(SIGKILL);
      _exit(1);
    }
    if (executors_) {
      executors_->stop();
    }
    End end{.code = names_ && names_->has_lost() ? kExitNameTaken : failed ? 1 : exit_code()};
    if (folder_ && failed && !started_ && !holds_messages(folder_->path())) {
      std::cerr << "nothing was recorded: removed the mission folder " << folder_->path().string()
                << '\n';
      folder_->discard();
      folder_.reset();
    }
    // Who stops a service does not wait for the tables of hours: `pipescout summary` makes them.
    const bool is_hurried = stopping() && stop_signal_ != SIGINT;
    if (folder_ && !is_hurried) {
      end.mission = folder_->path();
    } else if (folder_ && !finish_summary(folder_->path())) {
      end.code = 1;
    }
    return end;
  }

 private:
  [[nodiscard]] bool stopping() const { return stop_signal_ != 0; }

  [[nodiscard]] int exit_code() const {
    if (start_again_) {
      return kExitStartAgain;
    }
    const bool complete = progress_->outcome() == MissionProgress::Outcome::kComplete;
    if (complete || mission_.composition.complete_when.empty()) {
      return 0;
    }
    return 128 + stop_signal_;
  }

  void read_composition() {
    mission_.open(options_, registry_);
    progress_.emplace(mission_.composition.complete_when);
  }

  void make_components() {
    auto dds = DdsOptions::from_environment();
    dds.name = "pipescout " + mission_.composition.name;
    dds.enclave = options_.enclave.value_or(dds.enclave);
    dds.exported_topics = exported_topics(mission_.composition);
    for (const auto& entry : mission_.composition.components) {
      dds.super_client |= !entry.isolate && registry_.sees_whole_graph(entry.type);
    }
    dds.security.on_revocations_changed = [this] {
      start_again_ = true;
      kill(getpid(), SIGTERM);
    };
    dds.announcements = std::make_shared<Announcements>();
    context_ = Context::create(create_dds_transport(dds));
    names_.emplace(mission_.composition, dds, *context_, loop_);
    names_->await([this] { return stopping(); }, kGrace);
    executors_.emplace(Executors::Callbacks{
        .on_failure = [this] { loop_.post([] {}); },
        .warn = [this](const std::string& text) { container_->node().logger().warn(text); }});
    auto& shared = executors_->add("the composition", mission_.composition.executor);
    container_ = std::make_unique<ComponentContainer>(
        ContainerOptions{
            context_, &shared, {join_namespaces("/", options_.ns), "pipescout_container"}},
        registry_);
    for (const auto& problem : registry_.problems()) {
      container_->node().logger().warn(problem);
    }
    for (const auto& entry : mission_.composition.components) {
      auto& component = components_.emplace_back();
      component.entry = &entry;
      if (entry.executor && !entry.isolate) {
        component.executor = &executors_->add(entry.name.fully_qualified(), *entry.executor);
      }
    }
    executors_->start();
    for (auto& component : components_) {
      const auto& entry = *component.entry;
      if (entry.isolate) {
        launch(component);
      } else {
        load(component);
      }
    }
    wait_for_children();
    check_parameters();
  }

  void load(Running& component) {
    LoadRequest request;
    request.class_name = component.entry->type;
    request.name = component.entry->name;
    request.remap_rules = component.entry->remappings;
    request.parameter_overrides = component.entry->parameters;
    request.log_threshold = component.entry->log_level;
    request.executor = component.executor;
    try {
      const auto loaded = container_->load(std::move(request));
      component.id = loaded.id;
      component.parameters = loaded.component->parameters().all();
    } catch (const std::exception& error) {
      throw StartError(located(*component.entry, error.what()));
    }
  }

  void launch(Running& component) {
    std::vector<std::string> arguments{"run", options_.composition};
    arguments.insert(arguments.end(), options_.arguments.begin(), options_.arguments.end());
    arguments.insert(arguments.end(),
                     {"--namespace", options_.ns, "--out", mission_.folder.string(),
                      "--isolated-component", component.entry->name.fully_qualified()});
    for (const auto& parameter : options_.parameters) {
      arguments.insert(arguments.end(), {"--param", parameter});
    }
    for (const auto& file : options_.parameter_files) {
      arguments.insert(arguments.end(), {"--params-file", file});
    }
    if (options_.enclave) {
      arguments.insert(arguments.end(), {"--enclave", *options_.enclave});
    }
    const auto logger = container_->node().logger();
    component.supervisor = std::make_unique<ChildSupervisor>(
        component.entry->name.fully_qualified(), component.entry->restart,
        [this, arguments, &component]() -> std::unique_ptr<Child> {
          auto child = std::make_unique<ChildProcess>(arguments);
          loop_.watch(child->control_fd(), [this, &component] { receive(component); });
          return child;
        },
        [logger](LogSeverity severity, const std::string& text) { logger.log(severity, text); });
    component.supervisor->launch(steady_now());
  }

  static ChildProcess* process(const Running& component) {
    return component.supervisor ? static_cast<ChildProcess*>(component.supervisor->child())
                                : nullptr;
  }

  void receive(Running& component) {
    auto* child = process(component);
    while (child != nullptr) {
      try {
        const auto message = child->receive();
        if (!message) {
          break;
        }
        component.supervisor->on_message(*message);
      } catch (const std::invalid_argument& error) {
        container_->node().logger().error(component.supervisor->name() +
                                          " sent a malformed message: " + error.what());
      }
    }
    if (child != nullptr && child->closed()) {
      loop_.unwatch(child->control_fd());
    }
  }

  void reap_children() {
    child_signal_.drain();
    for (auto& component : components_) {
      auto* child = process(component);
      if (child == nullptr) {
        continue;
      }
      if (const auto status = child->reap()) {
        // What it said last comes before its end.
        receive(component);
        loop_.unwatch(child->control_fd());
        component.supervisor->on_exit(*status, steady_now());
      }
    }
  }

  std::optional<SteadyTime> on_turn(SteadyTime now) {
    auto due = progress_printer_.due();
    const auto at = [&](std::optional<SteadyTime> time) {
      if (time) {
        due = due ? std::min(*due, *time) : *time;
      }
    };
    std::string states;
    for (auto& component : components_) {
      if (component.supervisor) {
        component.supervisor->on_time(now);
        at(component.supervisor->deadline());
        states += to_string(component.supervisor->state()) +
                  std::to_string(component.supervisor->restarts()) + ' ';
      }
    }
    if (names_ && host_ && !stopping()) {
      at(names_->look(
          container_->node(), [this] { deactivate(); }, now));
      graph_changed_ = graph_changed_ || !network_status_.message.starts_with(names_->conflict());
    }
    if (host_ && graph_changed_ && now >= graph_looked_at_ + kLeastBetweenLooks) {
      graph_changed_ = false;
      graph_looked_at_ = now;
      look_at_graph(now);
    }
    if (host_ && (now >= diagnostics_at_ || states != diagnostics_states_)) {
      diagnostics_at_ = now + kDiagnosticsPeriod;
      diagnostics_states_ = states;
      publish_diagnostics(now);
    }
    if (host_) {
      at(diagnostics_at_);
      at(graph_changed_ ? std::optional(graph_looked_at_ + kLeastBetweenLooks) : std::nullopt);
    }
    if (watchdog_) {
      at(watchdog_->on_time(now));
    }
    show_progress(now);
    return due;
  }

  void show_progress(SteadyTime now) {
    if (progress_ && !mission_.composition.complete_when.empty() && !stopping()) {
      progress_printer_.show(progress_->line(), progress_->fraction(), now);
    }
  }

  /// Another process has the names.
  void deactivate() {
    for (const auto& loaded : container_->components()) {
      loaded.component->request_transition(LifecycleTransition::kDeactivate);
    }
    for (auto& component : components_) {
      if (component.supervisor) {
        component.supervisor->stop();
      }
    }
  }

  void look_at_graph(SteadyTime now) {
    auto network = host_status_->network(context_->graph(), names_->conflict());
    if (network != network_status_) {
      if (!network.message.empty() && names_->conflict().empty()) {
        container_->node().logger().warn(network.message);
      }
      network_status_ = std::move(network);
      diagnostics_at_ = now;
    }
    if (exports_) {
      exports_->look();
    }
  }

  void publish_diagnostics(SteadyTime now) {
    std::vector<diagnostic_msgs::msg::DiagnosticStatus> all;
    std::vector<pid_t> children;
    for (const auto& component : components_) {
      if (!component.supervisor) {
        continue;
      }
      const auto& supervisor = *component.supervisor;
      diagnostic_msgs::msg::DiagnosticStatus status;
      const bool failed = supervisor.state() == ChildSupervisor::State::kFailed;
      status.level = static_cast<std::uint8_t>(failed                      ? DiagnosticLevel::kError
                                               : supervisor.restarts() > 0 ? DiagnosticLevel::kWarn
                                                                           : DiagnosticLevel::kOk);
      status.name = container_->node().node_name().fully_qualified().substr(1) + ": process of " +
                    supervisor.name();
      status.message = failed ? supervisor.error() : to_string(supervisor.state());
      const auto add = [&](const char* key, std::string value) {
        diagnostic_msgs::msg::KeyValue pair;
        pair.key = key;
        pair.value = std::move(value);
        status.values.push_back(std::move(pair));
      };
      add("state", to_string(supervisor.state()));
      if (supervisor.running()) {
        children.push_back(supervisor.child()->pid());
      }
      add("process",
          supervisor.running() ? std::to_string(supervisor.child()->pid()) : std::string("none"));
      add("restarts", std::to_string(supervisor.restarts()));
      add("restart_limit", std::to_string(supervisor.policy().limit));
      add("last_exit", supervisor.last_exit());
      all.push_back(std::move(status));
    }
    all.push_back(host_status_->process(children, now));
    all.push_back(look_at_clock());
    all.push_back(network_status_);
    if (exports_) {
      all.push_back(exports_->status());
    }
    host_->publish_diagnostics(std::move(all));
  }

  diagnostic_msgs::msg::DiagnosticStatus look_at_clock() {
    // Where this thread had to wait in between, the two clocks do not tell the same moment.
    constexpr Duration kLongestRead = std::chrono::milliseconds(10);
    const SteadyTime before = steady_now();
    const Time system = context_->system_clock()->now();
    std::optional<ClockStep> step;
    if (steady_now() - before <= kLongestRead) {
      step = clock_watch_.look(system, before);
    }
    if (step) {
      container_->node().logger().warn(to_text(*step));
    }
    return host_status_->clock(step);
  }

  void check_executor() const {
    if (executors_ && executors_->failed()) {
      throw std::runtime_error(executors_->failure());
    }
  }

  /// Until `done`, or the run is stopped. Throws when the executor failed.
  void wait(const std::function<bool()>& done) {
    loop_.run_until([&] { return done() || stopping() || executors_->failed(); });
    check_executor();
  }

  void wait_for_children() {
    for (auto& component : components_) {
      if (component.supervisor) {
        using State = ChildSupervisor::State;
        wait([&] {
          const auto state = component.supervisor->state();
          return state == State::kConstructed || state == State::kFailed;
        });
        throw_if_failed(component);
        component.parameters = component.supervisor->parameters();
      }
    }
  }

  static void throw_if_failed(const Running& component) {
    if (component.supervisor->state() == ChildSupervisor::State::kFailed) {
      throw StartError("component " + component.supervisor->name() + ": " +
                       component.supervisor->error());
    }
  }

  void check_parameters() const {
    if (stopping()) {
      return;
    }
    std::vector<std::vector<NamedParameter>> parameters;
    for (const auto& component : components_) {
      parameters.push_back(component.parameters);
    }
    check_parameter_arguments(mission_.composition, parameters);
  }

  void open_mission() {
    if (stopping()) {
      return;
    }
    folder_.emplace(mission_.folder);
    std::vector<std::vector<NamedParameter>> parameters;
    std::vector<NodeName> names;
    std::vector<NodeName> watched;
    for (const auto& component : components_) {
      parameters.push_back(component.parameters);
      names.push_back(component.entry->name);
      // Those in processes of their own say it to their supervisors.
      if (awaited(component) && !component.supervisor) {
        watched.push_back(component.entry->name);
      }
    }
    folder_->write_composition(to_yaml(mission_.composition, parameters));
    folder_->write_versions(versions_of(mission_.composition, registry_));
    std::cout << "mission folder: " << folder_->path().string() << std::endl;
    HostNode::Callbacks callbacks;
    callbacks.reported = [this](const NodeName& name, ComponentReport report) {
      loop_.post([this, name, report] { progress_->report(name, report); });
    };
    callbacks.broke = [this](const NodeName& name) {
      loop_.post([this, name] { broken_ = name.fully_qualified(); });
    };
    host_status_.emplace(container_->node().node_name(), names);
    if (mission_.composition.exports) {
      exports_.emplace(container_->node(), *mission_.composition.exports);
    }
    graph_changed_ = true;
    graph_changes_ =
        context_->graph().on_changed([this] { loop_.post([this] { graph_changed_ = true; }); });
    host_ = std::make_unique<HostNode>(container_->node(), names, watched, std::move(callbacks));
    host_->log_into(*folder_);
  }

  void start_components() {
    for (auto& component : components_) {
      if (stopping()) {
        return;
      }
      if (component.supervisor) {
        using State = ChildSupervisor::State;
        component.supervisor->activate();
        wait([&] {
          const auto state = component.supervisor->state();
          return state == State::kActive || state == State::kFailed;
        });
        throw_if_failed(component);
      } else {
        auto result = std::make_shared<std::optional<TransitionResult>>();
        container_->start(component.id, [this, result](const TransitionResult& outcome) {
          loop_.post([result, outcome] { *result = outcome; });
        });
        wait([&] { return result->has_value(); });
        if (*result && !(*result)->success) {
          throw StartError("component " + component.entry->name.fully_qualified() + " (" +
                           component.entry->location + "): " + (*result)->message);
        }
      }
    }
    names_->check();
    if (!stopping()) {
      started_ = true;
      context_->graph().announce_pending();  // who hears of it may look for the nodes at once
      const auto status =
          std::to_string(components_.size()) +
          (components_.size() == 1 ? " component is active" : " components are active");
      container_->node().logger().info(status);
      service_manager::tell_ready(mission_.composition.name + ": " + status);
      start_watchdog();
    }
  }

  void start_watchdog() {
    const auto period = service_manager::watchdog_period();
    if (!period) {
      return;
    }
    Watchdog::Callbacks callbacks;
    callbacks.ask = [this] {
      executors_->ask();
      for (auto& component : components_) {
        if (component.supervisor) {
          component.supervisor->ask();
        }
      }
    };
    callbacks.silent = [this] {
      auto silent = executors_->silent();
      for (const auto& component : components_) {
        if (component.supervisor && component.supervisor->silent()) {
          silent.push_back(component.supervisor->name());
        }
      }
      return silent;
    };
    callbacks.alive = service_manager::tell_alive;
    callbacks.warn = [this](const std::string& text) { container_->node().logger().error(text); };
    watchdog_.emplace(*period, steady_now(), std::move(callbacks));
  }

  void wait_for_end() {
    const auto awaited_child = [&](auto test) -> const Running* {
      for (const auto& component : components_) {
        if (component.supervisor && awaited(component) && test(*component.supervisor)) {
          return &component;
        }
      }
      return nullptr;
    };
    const auto has_failed = [](const ChildSupervisor& child) {
      return child.state() == ChildSupervisor::State::kFailed;
    };
    wait([&] {
      if (const auto* component = awaited_child([](const auto& child) { return child.broke(); })) {
        broken_ = component->supervisor->name();
      }
      return progress_->outcome() != MissionProgress::Outcome::kRunning || !broken_.empty() ||
             (names_->is_inactive() && !mission_.composition.complete_when.empty()) ||
             awaited_child(has_failed) != nullptr;
    });
    if (stopping()) {
      return;
    }
    if (names_->is_inactive()) {
      throw std::runtime_error(names_->conflict() + " The mission will not complete");
    }
    if (progress_->outcome() == MissionProgress::Outcome::kFailed) {
      throw std::runtime_error("component " + progress_->failure());
    }
    if (progress_->outcome() == MissionProgress::Outcome::kComplete) {
      return;
    }
    if (!broken_.empty()) {
      throw std::runtime_error("component " + broken_ +
                               " went through its error state and will not complete");
    }
    throw_if_failed(*awaited_child(has_failed));
  }

  [[nodiscard]] bool awaited(const Running& component) const {
    const auto& names = mission_.composition.complete_when;
    return std::find(names.begin(), names.end(), component.entry->name) != names.end();
  }

  void request_stop(Running& component) {
    if (component.supervisor) {
      component.supervisor->stop();
    } else if (component.id != 0) {
      container_->unload(component.id, [this, &component](const TransitionResult&) {
        loop_.post([&component] { component.unloaded = true; });
      });
    }
  }

  /// Nothing is left to wait for: what an executor that failed should do will not happen.
  [[nodiscard]] bool settled(const Running& component) const {
    return component.has_stopped() || (!component.supervisor && executors_->failed());
  }

  /// In the order of `stop_order`. Each component has its share of the time that is left to itself;
  /// if it takes longer, the next ones are stopped beside it.
  StopOutcome stop_components(Duration grace) {
    StopOutcome outcome;
    if (!container_) {
      return outcome;
    }
    const auto deadline = steady_now() + grace;
    auto left = static_cast<std::int64_t>(components_.size()) + 1;
    bool executor_hangs = false;
    for (const std::size_t k : stop_order(mission_.composition.components)) {
      if (k >= components_.size()) {
        continue;  // the start did not get that far
      }
      Running* const component = &components_[k];
      const auto now = steady_now();
      const auto share = now + (deadline - now) / left--;
      request_stop(*component);
      // Behind a callback that hangs on the only thread nothing of that executor gets its turn.
      const bool shares_executor = !component->supervisor && component->executor == nullptr;
      if (!shares_executor || !executor_hangs) {
        loop_.run_until([&] { return settled(*component); }, share);
        executor_hangs = executor_hangs || (shares_executor && !component->has_stopped() &&
                                            mission_.composition.executor.threads == 1);
      }
    }
    // What others loaded into this process.
    auto unloaded = std::make_shared<bool>(false);
    container_->unload_all([this, unloaded] { loop_.post([unloaded] { *unloaded = true; }); });
    loop_.run_until(
        [&] {
          return (*unloaded || executors_->failed()) &&
                 std::all_of(components_.begin(), components_.end(),
                             [&](const Running& component) { return settled(component); });
        },
        deadline);
    outcome.hangs_here = !*unloaded;
    for (const auto& component : components_) {
      if (component.has_stopped()) {
        continue;
      }
      std::cerr << "error: component " << component.entry->name.fully_qualified()
                << " did not stop in time";
      if (component.supervisor) {
        std::cerr << "; its process is killed";
        component.supervisor->child()->signal(SIGKILL);
      } else {
        outcome.hangs_here = true;
      }
      std::cerr << '\n';
      outcome.in_time = false;
    }
    outcome.in_time = outcome.in_time && !outcome.hangs_here;
    return outcome;
  }

  /// Waits for what the components logged at their end.
  void finish_log() {
    auto logged = std::make_shared<bool>(false);
    if (host_) {
      host_->when_logged([this, logged] { loop_.post([logged] { *logged = true; }); });
      loop_.run_until([&] { return *logged; }, steady_now() + std::chrono::milliseconds(100));
    }
  }

  const RunOptions& options_;
  EventLoop loop_;
  ChildSignal child_signal_;
  StopSignals signals_;
  int stop_signal_ = 0;
  std::atomic<bool> start_again_{false};
  ComponentRegistry registry_;
  Mission mission_;
  std::optional<MissionFolder> folder_;
  bool started_ = false;  ///< all components have been active
  std::optional<MissionProgress> progress_;
  command_line::ProgressPrinter progress_printer_;
  std::string broken_;
  SteadyTime diagnostics_at_{};
  std::string diagnostics_states_;
  std::optional<HostStatus> host_status_;
  diagnostic_msgs::msg::DiagnosticStatus network_status_;
  ClockWatch clock_watch_;
  bool graph_changed_ = false;
  SteadyTime graph_looked_at_{};
  std::shared_ptr<Context> context_;
  std::optional<Executors> executors_;
  std::unique_ptr<ComponentContainer> container_;
  std::unique_ptr<HostNode> host_;
  std::optional<ExportRelay> exports_;
  std::shared_ptr<void> graph_changes_;
  /// Addresses are kept by callbacks.
  std::deque<Running> components_;
  std::optional<Watchdog> watchdog_;
  std::optional<NameKeeper> names_;
};

}  // namespace

CompositionInputs RunOptions::inputs() const {
  CompositionInputs inputs;
  for (const auto& argument : arguments) {
    inputs.arguments.push_back(parse_argument(argument));
  }
  inputs.ns = join_namespaces("/", ns);
  inputs.parameters = parameters;
  inputs.parameter_files = parameter_files;
  inputs.sources = process_sources();
  if (out) {
    inputs.mission_folder = [folder = *out](const std::string&) { return folder; };
  }
  return inputs;
}

int run_composition(const RunOptions& options) {
  // A reader of our output that goes away must not end the mission.
  std::signal(SIGPIPE, SIG_IGN);
  StopSignals::block();
  const auto end = Run(options).run();
  return !end.mission || summarise_mission(*end.mission) ? end.code : 1;
}

}  // namespace pipescout::host
