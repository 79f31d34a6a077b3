// SPDX-License-Identifier: Apache-2.0
// A program outside of the project that makes a component and lets it work, in process.
#include <iostream>
#include <memory>
#include <std_msgs/msg/string.hpp>

#include "pipescout/runtime/component.hpp"

namespace {

class Talker final : public pipescout::Component {
 public:
  using Component::Component;

 protected:
  pipescout::CallbackReturn on_configure() override {
    publisher_ = create_publisher<std_msgs::msg::String>("chatter", pipescout::QoS::latched());
    return pipescout::CallbackReturn::kSuccess;
  }
  pipescout::CallbackReturn on_activate() override {
    default_group()->post([this] {
      std_msgs::msg::String hello;
      hello.data = "hello";
      publisher_.publish(std::move(hello));
    });
    return pipescout::CallbackReturn::kSuccess;
  }

 private:
  pipescout::Publisher<std_msgs::msg::String> publisher_;
};

}  // namespace

int main() {
  pipescout::Executor executor;
  const auto context = pipescout::Context::create_in_process();
  Talker talker({.context = context, .executor = &executor, .name = {"/", "talker"}});
  pipescout::Node listener({.context = context, .executor = &executor, .name = {"/", "listener"}});
  bool heard = false;
  const auto subscription = listener.create_subscription<std_msgs::msg::String>(
      "chatter", pipescout::QoS::latched(),
      [&](const std_msgs::msg::String& message) { heard = message.data == "hello"; });
  talker.request_transition(pipescout::LifecycleTransition::kConfigure);
  talker.request_transition(pipescout::LifecycleTransition::kActivate);
  executor.spin_until([&] { return heard; }, std::chrono::seconds(10));
  std::cout << (heard ? "heard" : "heard nothing") << '\n';
  return heard ? 0 : 1;
}
