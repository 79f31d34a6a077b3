// SPDX-License-Identifier: Apache-2.0
// Components for the tests of the host: two that work, and one that fails where it is told to.
#include <csignal>
#include <cstdlib>
#include <future>
#include <std_msgs/msg/string.hpp>
#include <stdexcept>

#include "pipescout/runtime/component.hpp"
#include "pipescout/runtime/register_component.hpp"

namespace pipescout_test {

using pipescout::CallbackReturn;
using pipescout::Component;
using pipescout::ComponentOptions;

/// Publishes `count` messages on `chatter`, one per `period`, and is complete then; endless with
/// count 0. Logs that it was deactivated.
class Talker : public Component {
 public:
  explicit Talker(ComponentOptions options)
      : Component(std::move(options)),
        text_(parameters().declare<std::string>("text", "hello", {.description = "what is said"})),
        period_(parameters().declare<double>(
            "period", 0.02,
            {.description = "time between two messages, s",
             .floating_point_range = pipescout::FloatingPointRange{0.001, 10.0}})),
        count_(parameters().declare<std::uint32_t>("count", 0,
                                                   {.description = "messages; 0: endless"})) {}

 protected:
  CallbackReturn on_configure() override {
    publisher_ = create_publisher<std_msgs::msg::String>("chatter", pipescout::QoS::reliable());
    timer_ = create_timer(pipescout::from_seconds(period_.get()), [this] { say(); });
    return CallbackReturn::kSuccess;
  }
  CallbackReturn on_deactivate() override {
    logger().info("was deactivated");
    return CallbackReturn::kSuccess;
  }
  CallbackReturn on_cleanup() override {
    timer_.reset();
    publisher_ = {};
    return CallbackReturn::kSuccess;
  }

 private:
  void say() {
    const auto count = count_.get();
    if (count != 0 && said_ == count) {
      return;
    }
    std_msgs::msg::String message;
    message.data(text_.get() + " " + std::to_string(said_));
    publisher_.publish(std::move(message));
    ++said_;
    report_progress(said_, count);
    if (said_ == count) {
      report_complete();
    }
  }

  pipescout::Parameter<std::string> text_;
  pipescout::Parameter<double> period_;
  pipescout::Parameter<std::uint32_t> count_;
  std::uint32_t said_ = 0;
  pipescout::Publisher<std_msgs::msg::String> publisher_;
  std::shared_ptr<pipescout::Timer> timer_;
};

/// Is complete after `count` messages on `chatter`, when that is not 0.
class Listener : public Component {
 public:
  explicit Listener(ComponentOptions options)
      : Component(std::move(options)),
        count_(parameters().declare<std::uint32_t>("count", 0,
                                                   {.description = "messages; 0: endless"})) {}

 protected:
  CallbackReturn on_configure() override {
    subscription_ = create_subscription<std_msgs::msg::String>(
        "chatter", pipescout::QoS::reliable(), [this](const std_msgs::msg::String&) {
          ++heard_;
          report_progress(heard_, count_.get());
          if (heard_ == count_.get()) {
            report_complete();
          }
        });
    return CallbackReturn::kSuccess;
  }
  CallbackReturn on_cleanup() override {
    subscription_ = {};
    return CallbackReturn::kSuccess;
  }

 private:
  pipescout::Parameter<std::uint32_t> count_;
  std::uint32_t heard_ = 0;
  pipescout::Subscription<std_msgs::msg::String> subscription_;
};

/// Fails in the place that the parameter `where` names ("constructor", "configure", "activate",
/// "deactivate", "cleanup", "shutdown", "message"; "timer": soon after activation), in the way that
/// `how` names: "throw", "return" (an error from a lifecycle callback), "abort", "hang", "report"
/// (report_failed), "complete" (report_complete).
class FailingComponent : public Component {
 public:
  explicit FailingComponent(ComponentOptions options)
      : Component(std::move(options)),
        where_(parameters().declare<std::string>("where", "nowhere").get()),
        how_(parameters().declare<std::string>("how", "throw").get()) {
    fail_in("constructor");
  }

 protected:
  CallbackReturn on_configure() override {
    subscription_ = create_subscription<std_msgs::msg::String>(
        "chatter", pipescout::QoS::reliable(),
        [this](const std_msgs::msg::String&) { fail_in("message"); });
    return fail_in("configure");
  }
  CallbackReturn on_activate() override {
    if (where_ == "timer") {
      timer_ = create_timer(std::chrono::milliseconds(1), [this] { fail_in("timer"); });
    }
    return fail_in("activate");
  }
  CallbackReturn on_deactivate() override { return fail_in("deactivate"); }
  CallbackReturn on_cleanup() override {
    timer_.reset();
    subscription_ = {};
    return fail_in("cleanup");
  }
  CallbackReturn on_shutdown() override { return fail_in("shutdown"); }

 private:
  CallbackReturn fail_in(const std::string& place) {
    if (place != where_) {
      return CallbackReturn::kSuccess;
    }
    if (how_ == "throw") {
      throw std::runtime_error("told to fail in " + place);
    }
    if (how_ == "abort") {
      std::abort();
    }
    if (how_ == "hang") {
      logger().info("hangs in " + place);
      std::promise<void>().get_future().wait();
    }
    if (how_ == "report") {
      report_failed("told to fail in " + place);
    }
    if (how_ == "complete") {
      report_complete();
    }
    return how_ == "return" ? CallbackReturn::kFailure : CallbackReturn::kSuccess;
  }

  std::string where_;
  std::string how_;
  pipescout::Subscription<std_msgs::msg::String> subscription_;
  std::shared_ptr<pipescout::Timer> timer_;
};

}  // namespace pipescout_test

PIPESCOUT_REGISTER_COMPONENT(pipescout_test::Talker)
PIPESCOUT_REGISTER_COMPONENT(pipescout_test::Listener)
PIPESCOUT_REGISTER_COMPONENT(pipescout_test::FailingComponent)
