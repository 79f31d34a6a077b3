// SPDX-License-Identifier: Apache-2.0
// What run_component_test.cpp starts: a component as a program of its own.
#include <condition_variable>
#include <mutex>
#include <std_msgs/msg/string.hpp>

#include "pipescout/dds/run_component.hpp"

namespace pipescout_test {

/// Publishes the parameter `text` on `chatter`, and fails as `failure` says.
class Talker final : public pipescout::Component {
 public:
  explicit Talker(pipescout::ComponentOptions options) : Component(std::move(options)) {
    text_ = parameters().declare<std::string>("text", "nothing");
    repeat_ =
        parameters().declare<int>("repeat", 1, {.integer_range = pipescout::IntegerRange{1, 9}});
    failure_ = parameters().declare<std::string>("failure", "none");
    if (failure_.get() == "constructor") {
      throw std::runtime_error("the constructor failed");
    }
  }

 protected:
  pipescout::CallbackReturn on_configure() override {
    logger().debug("configures");
    if (failure_.get() == "configure") {
      throw std::runtime_error("no device");
    }
    publisher_ = create_publisher<std_msgs::msg::String>("chatter", pipescout::QoS::latched());
    return pipescout::CallbackReturn::kSuccess;
  }
  pipescout::CallbackReturn on_activate() override {
    timer_ = create_timer(std::chrono::milliseconds(10), [this] { talk(); });
    return pipescout::CallbackReturn::kSuccess;
  }
  pipescout::CallbackReturn on_deactivate() override {
    logger().info("deactivated");
    return pipescout::CallbackReturn::kSuccess;
  }
  pipescout::CallbackReturn on_cleanup() override {
    logger().info("cleaned up");
    return pipescout::CallbackReturn::kSuccess;
  }

 private:
  void talk() {
    if (failure_.get() == "hang") {
      logger().info("hangs");
      std::mutex mutex;
      std::unique_lock lock(mutex);
      std::condition_variable never;
      never.wait(lock, [] { return false; });
    }
    std_msgs::msg::String message;
    for (int i = 0; i < repeat_.get(); ++i) {
      message.data += text_.get();
    }
    publisher_.publish(std::move(message));
  }

  pipescout::Parameter<std::string> text_;
  pipescout::Parameter<int> repeat_;
  pipescout::Parameter<std::string> failure_;
  pipescout::Publisher<std_msgs::msg::String> publisher_;
  std::shared_ptr<pipescout::Timer> timer_;
};

}  // namespace pipescout_test

int main(int argc, char** argv) {
  return pipescout::run<pipescout_test::Talker>(argc, argv);
}
