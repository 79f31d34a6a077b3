// SPDX-License-Identifier: Apache-2.0
#include "pipescout/dds/run_component.hpp"

#include <cxxabi.h>

#include <condition_variable>
#include <csignal>
#include <cstdlib>
#include <iostream>
#include <memory>
#include <mutex>
#include <optional>
#include <string>

#include "pipescout/dds/dds_transport.hpp"
#include "pipescout/runtime/bring_up.hpp"
#include "pipescout/runtime/component_registry.hpp"
#include "pipescout/runtime/executor_thread.hpp"
#include "pipescout/runtime/ros_arguments.hpp"
#include "pipescout/runtime/stop_signals.hpp"

namespace pipescout {
namespace {

constexpr int kExitError = 1;
constexpr int kExitUsage = 2;
constexpr Duration kGrace = std::chrono::seconds(2);

std::string name_of(const std::type_info& type) {
  int status = 0;
  const std::unique_ptr<char, decltype(&std::free)> name(
      abi::__cxa_demangle(type.name(), nullptr, nullptr, &status), &std::free);
  return name != nullptr ? name.get() : type.name();
}

bool is_of_command_line(const ParameterOverride& parameter) {
  return parameter.source.starts_with("-p ") || parameter.source.starts_with("--param ");
}

/// What the threads of the process tell the main thread.
class Events {
 public:
  void request_stop() {
    set([this] { stopping_ = true; });
  }
  void executor_failed() {
    set([this] { failed_ = true; });
  }
  void set_up(const TransitionResult& result) {
    set([this, &result] { up_ = result; });
  }
  void set_down() {
    set([this] { down_ = true; });
  }

  /// Until the component is up or could not be, or there is no use in waiting.
  std::optional<TransitionResult> wait_for_up() {
    std::unique_lock lock(mutex_);
    changed_.wait(lock, [this] { return up_ || stopping_ || failed_; });
    return up_;
  }
  void wait_for_stop() {
    std::unique_lock lock(mutex_);
    changed_.wait(lock, [this] { return stopping_ || failed_; });
  }
  void wait_for_down() {
    std::unique_lock lock(mutex_);
    changed_.wait(lock, [this] { return down_ || failed_; });
  }

 private:
  template <class Change>
  void set(const Change& change) {
    const std::lock_guard lock(mutex_);
    change();
    changed_.notify_all();
  }

  std::mutex mutex_;
  std::condition_variable changed_;
  bool stopping_ = false;
  bool failed_ = false;
  bool down_ = false;
  std::optional<TransitionResult> up_;
};

class Run {
 public:
  Run(const ComponentFactory& factory, const std::string& class_name, const RosArguments& arguments)
      : factory_(factory),
        class_name_(class_name),
        arguments_(arguments),
        signals_(
            kGrace, [this](int) { events_.request_stop(); }, [] {}) {}

  /// Throws what the component's constructor throws, TransportError, std::invalid_argument for a
  /// wrong environment.
  int run() {
    make();
    const ExecutorThread thread(executor_, {.on_failure = [this] { events_.executor_failed(); }});
    bring_up(*component_, [this](const TransitionResult& result) { events_.set_up(result); });
    const auto up = events_.wait_for_up();
    const bool failed = up && !up->success;
    if (failed) {
      std::cerr << "error: component " << component_->node_name().fully_qualified() << ": "
                << up->message << '\n';
    } else if (up) {
      component_->logger().info("active");
      events_.wait_for_stop();
    }
    signals_.expect_end();
    take_down(*component_, [this] { events_.set_down(); });
    events_.wait_for_down();
    component_.reset();
    if (thread.failed()) {
      std::cerr << "error: " << thread.failure() << '\n';
    }
    return failed || thread.failed() ? kExitError : 0;
  }

 private:
  void make() {
    ComponentOptions options;
    options.executor = &executor_;
    options.name.name = default_component_name(class_name_);
    options.remap_rules = arguments_.remap_rules;
    const auto name = remap_node(options.name, options.remap_rules);
    options.parameter_overrides = arguments_.parameters.overrides_for(name.fully_qualified());
    auto dds = DdsOptions::from_environment();
    dds.name = name.name;
    dds.enclave = arguments_.enclave.value_or(dds.enclave);
    options.context = Context::create(create_dds_transport(dds));
    component_ = factory_.create(std::move(options));
    for (const auto& unused : component_->parameters().unused_overrides()) {
      // A file may be for many nodes; what stands on this command line is for this one.
      if (!unused.parameter.from_wildcard || is_of_command_line(unused.parameter)) {
        throw ParameterError(unused.parameter.name, to_string(unused));
      }
    }
    auto logger = component_->logger();
    if (const auto threshold = arguments_.log_threshold(logger.name())) {
      logger.set_threshold(*threshold);
    }
  }

  const ComponentFactory& factory_;
  const std::string& class_name_;
  const RosArguments& arguments_;
  Events events_;
  /// Goes after all that may hang while it is destroyed.
  StopSignals signals_;
  Executor executor_;
  ComponentPtr<> component_;
};

void print_usage(const char* program) {
  std::cout << "usage: " << program << " [--ros-args ARGUMENT... [--]]\n"
            << "  -r, --remap FROM:=TO            a name, __node or __ns; NODE:FROM:=TO\n"
               "  -p, --param NAME:=VALUE         a parameter\n"
               "  --params-file FILE              parameters, YAML\n"
               "  --log-level [LOGGER:=]LEVEL     debug, info, warn, error, fatal\n"
               "  -e, --enclave ENCLAVE           security enclave\n";
}

}  // namespace

namespace detail {

int run_component(const ComponentFactory& factory, const std::type_info& type, int argc,
                  const char* const* argv) {
  try {
    const auto arguments = parse_ros_arguments(argc, argv);
    if (!arguments.others.empty()) {
      const auto& first = arguments.others.front();
      if (first == "-h" || first == "--help") {
        print_usage(argv[0]);
        return 0;
      }
      throw RosArgumentError(
          "'" + first + "' is not an argument of this program; those of ROS follow --ros-args");
    }
    // A reader of our output that goes away must not end the program.
    std::signal(SIGPIPE, SIG_IGN);
    StopSignals::block();
    return Run(factory, name_of(type), arguments).run();
  } catch (const RosArgumentError& error) {
    std::cerr << "error: " << error.what() << '\n';
    return kExitUsage;
  } catch (const ParameterError& error) {
    std::cerr << "error: " << error.what() << '\n';
    return kExitUsage;
  } catch (const std::exception& error) {
    std::cerr << "error: " << error.what() << '\n';
    return kExitError;
  }
}

}  // namespace detail
}  // namespace pipescout
