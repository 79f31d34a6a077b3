// SPDX-License-Identifier: Apache-2.0
#include <csignal>
#include <optional>

#include "pipescout/dds/dds_transport.hpp"
#include "pipescout/runtime/component_container.hpp"
#include "pipescout/runtime/stop_signals.hpp"
#include "run/child_process.hpp"
#include "run/event_loop.hpp"
#include "run/executors.hpp"
#include "run/host_node.hpp"
#include "run/run.hpp"

namespace pipescout::host {
namespace {

constexpr Duration kChildGrace = std::chrono::milliseconds(1800);

class IsolatedRun {
 public:
  IsolatedRun(const RunOptions& options, std::string component, int control_fd)
      : options_(options),
        component_(std::move(component)),
        control_(control_fd),
        signals_(
            kChildGrace, [this](int) { loop_.post([this] { stopped_ = true; }); }, [] {}) {}

  int run() {
    try {
      make();
    } catch (const std::exception& error) {
      control_.send({ChildMessage::Event::kFailed,
                     entry_ ? located(*entry_, error.what()) : error.what(),
                     {}});
      return 1;
    }
    loop_.watch(control_.fd(), [this] { take_control(); });
    int code = 0;
    loop_.run_until([this] { return stopped_ || started_ || executors_->failed(); });
    if (started_ && !stopped_) {
      code = start();
    }
    loop_.run_until([&] { return stopped_ || code != 0 || executors_->failed(); });
    if (executors_->failed()) {
      control_.send({ChildMessage::Event::kFailed, executors_->failure(), {}});
      code = 1;
    }
    signals_.expect_end();
    bool ended = false;
    container_->unload_all([&] { loop_.post([&] { ended = true; }); });
    loop_.run_until([&] { return ended || executors_->failed(); });
    executors_->stop();
    return code;
  }

 private:
  void make() {
    const auto composition = load_composition(options_.composition, options_.inputs());
    for (const auto& entry : composition.components) {
      if (entry.name.fully_qualified() == component_) {
        entry_ = entry;
      }
    }
    if (!entry_) {
      throw CompositionError("no component '" + component_ + "' in " + options_.composition);
    }
    auto dds = DdsOptions::from_environment();
    dds.name = "pipescout " + entry_->name.name;
    dds.enclave = options_.enclave.value_or(dds.enclave);
    dds.exported_topics = exported_topics(composition);
    dds.super_client |= ComponentRegistry().sees_whole_graph(entry_->type);
    context_ = Context::create(create_dds_transport(dds));
    executors_.emplace(Executors::Callbacks{
        .on_failure = [this] { loop_.post([] {}); },
        .warn = [this](const std::string& text) { container_->node().logger().warn(text); }});
    auto& executor = executors_->add(entry_->name.fully_qualified(),
                                     entry_->executor.value_or(composition.executor));
    alive_ = executor.create_callback_group();
    // Hidden, as all names with a leading '_' are: one that asks for the nodes sees the component.
    container_ = std::make_unique<ComponentContainer>(
        ContainerOptions{context_, &executor, {entry_->name.ns, "_" + entry_->name.name}});
    executors_->start();
    errors_ =
        watch_errors(container_->node(), container_->node().default_group(), entry_->name, [this] {
          control_.send({ChildMessage::Event::kBroke, "", {}});
        });
    LoadRequest request;
    request.class_name = entry_->type;
    request.name = entry_->name;
    request.remap_rules = entry_->remappings;
    request.parameter_overrides = entry_->parameters;
    request.log_threshold = entry_->log_level;
    const auto loaded = container_->load(std::move(request));
    id_ = loaded.id;
    control_.send({ChildMessage::Event::kConstructed, "", loaded.component->parameters().all()});
  }

  void take_control() {
    switch (control_.receive()) {
      case ControlSocket::Received::kNothing:
        break;
      case ControlSocket::Received::kStart:
        started_ = true;
        break;
      case ControlSocket::Received::kAsked:
        alive_->post([this] { control_.send({ChildMessage::Event::kAlive, "", {}}); });
        break;
      case ControlSocket::Received::kClosed:
        // Nobody is left to run for.
        loop_.unwatch(control_.fd());
        stopped_ = true;
        break;
    }
  }

  int start() {
    std::optional<TransitionResult> result;
    container_->start(id_, [&](const TransitionResult& outcome) {
      loop_.post([&result, outcome] { result = outcome; });
    });
    loop_.run_until([&] { return result.has_value() || executors_->failed(); });
    if (!result) {
      return 1;
    }
    if (!result->success) {
      control_.send({ChildMessage::Event::kFailed, entry_->location + ": " + result->message, {}});
      return 1;
    }
    context_->graph().announce_pending();
    control_.send({ChildMessage::Event::kActive, "", {}});
    return 0;
  }

  const RunOptions& options_;
  std::string component_;
  ControlSocket control_;
  std::optional<ComponentEntry> entry_;
  EventLoop loop_;
  bool stopped_ = false;
  /// Goes after all that may hang while it is destroyed.
  StopSignals signals_;
  bool started_ = false;
  std::shared_ptr<Context> context_;
  std::optional<Executors> executors_;
  std::shared_ptr<CallbackGroup> alive_;  ///< answers that the executor runs callbacks
  std::unique_ptr<ComponentContainer> container_;
  ErrorWatch errors_;
  std::uint64_t id_ = 0;
};

}  // namespace

int run_isolated(const RunOptions& options, const std::string& component, int control_fd) {
  std::signal(SIGPIPE, SIG_IGN);
  return IsolatedRun(options, component, control_fd).run();
}

}  // namespace pipescout::host
