// SPDX-License-Identifier: Apache-2.0
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <signal.h>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <condition_variable>
#include <ctime>
#include <example_interfaces/action/fibonacci.hpp>
#include <functional>
#include <memory>
#include <mutex>
#include <nav_msgs/msg/odometry.hpp>
#include <numbers>
#include <optional>
#include <pipescout_msgs/msg/fused_odometer.hpp>
#include <sensor_msgs/msg/image.hpp>
#include <set>
#include <stdexcept>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "pipescout/dds/dds_transport.hpp"
#include "pipescout/files/testing/temporary_folder.hpp"
#include "pipescout/keystore/keystore.hpp"
#include "pipescout/runtime/graph.hpp"
#include "pipescout/runtime/node.hpp"

namespace pipescout {
namespace {

using nav_msgs::msg::Odometry;
using pipescout_msgs::msg::FusedOdometer;
using sensor_msgs::msg::Image;

constexpr const char* kEchoMark = "echoed by cyclone";
constexpr Duration kPatience = std::chrono::seconds(30);

// Loopback only, as the project's own side.
constexpr const char* kWithMulticast =
    "<CycloneDDS><Domain><General><Interfaces>"
    "<NetworkInterface name='lo' multicast='true'/></Interfaces>"
    "<AllowMulticast>true</AllowMulticast></General></Domain></CycloneDDS>";
// As on a machine whose loopback has no multicast; after its start it speaks to those alone that
// speak to it.
constexpr const char* kWithoutMulticast =
    "<CycloneDDS><Domain><General><Interfaces>"
    "<NetworkInterface name='lo' multicast='false'/></Interfaces>"
    "<AllowMulticast>false</AllowMulticast></General>"
    "<Discovery><ParticipantIndex>auto</ParticipantIndex>"
    "<SPDPInterval>3600s</SPDPInterval></Discovery></Domain></CycloneDDS>";

/// The other vendor's program, running; reads its standard output.
class CyclonePeer {
 public:
  explicit CyclonePeer(std::uint32_t domain, const char* settings = kWithMulticast) {
    std::array<int, 2> input{};
    std::array<int, 2> output{};
    if (pipe(input.data()) != 0 || pipe(output.data()) != 0) {
      throw std::runtime_error("no pipes");
    }
    const std::string domain_text = std::to_string(domain);
    child_ = fork();
    if (child_ == 0) {
      prctl(PR_SET_PDEATHSIG, SIGKILL);
      dup2(input[0], STDIN_FILENO);
      dup2(output[1], STDOUT_FILENO);
      close(input[1]);
      close(output[0]);
      setenv("CYCLONEDDS_URI", settings, 1);
      execl(CYCLONE_PEER, "cyclone_peer", domain_text.c_str(), nullptr);
      _exit(127);
    }
    close(input[0]);
    close(output[1]);
    input_ = input[1];
    output_ = output[0];
    listener_ = std::thread([this] { listen(); });
  }

  ~CyclonePeer() {
    close(input_);
    int status = 0;
    waitpid(child_, &status, 0);
    listener_.join();
    close(output_);
    EXPECT_TRUE(WIFEXITED(status) && WEXITSTATUS(status) == 0) << "cyclone_peer failed";
  }
  CyclonePeer(const CyclonePeer&) = delete;
  CyclonePeer& operator=(const CyclonePeer&) = delete;

  bool wait_for_line(const std::string& line) {
    std::unique_lock lock(mutex_);
    return told_.wait_for(lock, kPatience, [&] { return lines_.contains(line) || ended_; }) &&
           lines_.contains(line);
  }
  std::set<std::string> lines() {
    const std::lock_guard lock(mutex_);
    return lines_;
  }

 private:
  void listen() {
    std::string pending;
    std::array<char, 4096> chunk{};
    ssize_t got = 0;
    while ((got = read(output_, chunk.data(), chunk.size())) > 0) {
      pending.append(chunk.data(), static_cast<std::size_t>(got));
      for (auto end = pending.find('\n'); end != std::string::npos; end = pending.find('\n')) {
        const std::lock_guard lock(mutex_);
        lines_.insert(pending.substr(0, end));
        pending.erase(0, end + 1);
        told_.notify_all();
      }
    }
    const std::lock_guard lock(mutex_);
    ended_ = true;
    told_.notify_all();
  }

  pid_t child_ = -1;
  int input_ = -1;
  int output_ = -1;
  std::mutex mutex_;
  std::condition_variable told_;
  std::set<std::string> lines_;
  bool ended_ = false;
  std::thread listener_;
};

/// Sends the message to the echo once both paths are matched, and returns what comes back.
template <class T>
std::optional<T> exchange(Node& node, Executor& executor, const std::string& name,
                          const T& message) {
  std::optional<T> echoed;
  // The callbacks on a match wake the executor.
  const auto publisher = node.create_publisher<T>(name + "_in", QoS::reliable(),
                                                  {.events = {.matched = [](std::size_t) {}}});
  const auto subscription = node.create_subscription<T>(
      name + "_out", QoS::reliable(), [&](const T& received) { echoed = received; },
      {.events = {.matched = [](std::size_t) {}}});
  if (!executor.spin_until(
          [&] { return publisher.subscription_count() > 0 && subscription.publisher_count() > 0; },
          kPatience)) {
    ADD_FAILURE() << name << ": not matched";
    return std::nullopt;
  }
  // Our reader's match does not tell that the peer's writer knows of it; reliable, volatile
  // endpoints of two vendors may still lose the first message, so it is sent until it returns.
  auto sender = publisher;
  for (int attempt = 0; attempt < 30 && !echoed; ++attempt) {
    sender.publish(message);
    executor.spin_until([&] { return echoed.has_value(); }, std::chrono::seconds(1));
  }
  return echoed;
}

class CycloneTest : public ::testing::Test {
 protected:
  CycloneTest()
      : domain_(static_cast<std::uint32_t>(101 + getpid() % 100)),
        peer_(domain_),
        context_(
            Context::create(create_dds_transport({.domain_id = domain_, .localhost_only = true}))),
        node_({.context = context_,
               .executor = &executor_,
               .name = {"/interop", "our_side"},
               .standard_interfaces = false}) {}

  void SetUp() override { ASSERT_TRUE(peer_.wait_for_line("ready")); }

  template <class T>
  std::optional<T> exchange(const std::string& name, const T& message) {
    return pipescout::exchange(node_, executor_, name, message);
  }

  const std::uint32_t domain_;
  CyclonePeer peer_;
  Executor executor_;
  std::shared_ptr<Context> context_;
  Node node_;
};

Image test_image() {
  Image image;
  image.header.stamp.sec = -5;
  image.header.stamp.nanosec = 999'999'999;
  image.header.frame_id = "thermal_optical";
  image.width = 640;
  image.height = 512;
  image.encoding = "mono16";
  image.is_bigendian = 1;
  image.step = 1280;
  image.data.resize(std::size_t{1280} * 512);
  for (std::size_t i = 0; i < image.data.size(); ++i) {
    image.data[i] = static_cast<std::uint8_t>(i * 7 + i / 1280);
  }
  return image;
}

TEST_F(CycloneTest, ImageGoesThereAndComesBack) {
  Image image = test_image();
  const auto echoed = exchange("image", image);
  ASSERT_TRUE(echoed);
  image.header.frame_id = kEchoMark;
  EXPECT_TRUE(*echoed == image);
}

// No secured peer of the other vendor: where Fast DDS 2.9 begins the handshake, the two encode the
// public key of Diffie-Hellman differently (Fast DDS issue 3802).
TEST(CycloneAsStranger, HearsNothingOfSecuredParticipants) {
  const testing::TemporaryFolder folder;
  const auto domain = static_cast<std::uint32_t>(101 + getpid() % 100);
  const auto keystore = folder.path() / "keystore";
  const std::time_t now = std::time(nullptr);
  keystore::create_keystore(keystore, domain, 365, now);
  Executor executor;
  const auto secured = [&](const std::string& name) {
    keystore::create_enclave(keystore, {.name = "/" + name, .domain = domain}, now);
    DdsOptions options{.domain_id = domain, .localhost_only = true, .enclave = "/" + name};
    options.security.enabled = true;
    options.security.enforce = true;
    options.security.keystore = keystore;
    return std::make_unique<Node>(
        NodeOptions{.context = Context::create(create_dds_transport(options)),
                    .executor = &executor,
                    .name = {"/interop", name},
                    .standard_interfaces = false});
  };
  CyclonePeer peer(domain);
  ASSERT_TRUE(peer.wait_for_line("ready"));
  const auto first = secured("first");
  auto publisher = first->create_publisher<Image>("image_in", QoS::reliable());
  int echoed = 0;
  const auto echo = first->create_subscription<Image>("image_out", QoS::reliable(),
                                                      [&](const Image&) { ++echoed; });
  // Comes last, and hears all the same.
  const auto second = secured("second");
  std::optional<Image> received;
  const auto subscription = second->create_subscription<Image>(
      "image_in", QoS::reliable(), [&](const Image& image) { received = image; },
      {.events = {.matched = [](std::size_t) {}}});
  const Image image = test_image();
  for (int attempt = 0; attempt < 30 && !received; ++attempt) {
    publisher.publish(image);
    executor.spin_until([&] { return received.has_value(); }, std::chrono::seconds(1));
  }
  ASSERT_TRUE(received);
  EXPECT_TRUE(*received == image);
  EXPECT_EQ(publisher.subscription_count(), 1U);
  EXPECT_EQ(echo.publisher_count(), 0U);
  EXPECT_EQ(echoed, 0);
}

TEST_F(CycloneTest, OdometryGoesThereAndComesBack) {
  Odometry odometry;
  odometry.header.frame_id = "odom";
  odometry.child_frame_id = "base_link";
  odometry.pose.pose.position.x = 1.5;
  odometry.pose.pose.position.z = -std::numbers::pi;
  odometry.pose.pose.orientation.w = 0.25;
  for (std::size_t i = 0; i < 36; ++i) {
    odometry.pose.covariance[i] = static_cast<double>(i);
    odometry.twist.covariance[i] = -static_cast<double>(i) / 3.0;
  }
  odometry.twist.twist.angular.y = 1e-300;
  const auto echoed = exchange("odometry", odometry);
  ASSERT_TRUE(echoed);
  odometry.header.frame_id = kEchoMark;
  EXPECT_TRUE(*echoed == odometry);
}

TEST_F(CycloneTest, FusedOdometerGoesThereAndComesBack) {
  FusedOdometer fused;
  fused.header.stamp.sec = 12;
  fused.header.frame_id = "base_link";
  fused.distance = 5.51;
  fused.variance = 0.0011;
  fused.name = {"front", "", "rear wheel"};
  fused.in_fusion_set = {true, false, true};
  fused.support = {1, 0, 1, 0, 1, 0, 1, 0, 1};
  fused.confidence_distance = {0.0, 0.99, 0.26, 0.98, 0.0, 0.95, 0.28, 0.96, 0.0};
  fused.rejection_reason = {0, 1, 0};
  fused.status = 1;
  const auto echoed = exchange("fused", fused);
  ASSERT_TRUE(echoed);
  fused.header.frame_id = kEchoMark;
  EXPECT_TRUE(*echoed == fused);
}

TEST_F(CycloneTest, LateJoinerGetsItsLatchedImage) {
  std::optional<Image> received;
  const auto subscription = node_.create_subscription<Image>(
      "latched", QoS::latched(), [&](const Image& image) { received = image; });
  ASSERT_TRUE(executor_.spin_until([&] { return received.has_value(); }, kPatience));
  EXPECT_EQ(received->header.stamp.sec, 7);
  EXPECT_EQ(received->header.frame_id, "latched");
  EXPECT_THAT(received->data, ::testing::ElementsAre(1, 2, 3, 4));
}

TEST(CycloneWithoutMulticast, IsFoundByWhoComesLater) {
  const auto domain = static_cast<std::uint32_t>(101 + getpid() % 100);
  CyclonePeer peer(domain, kWithoutMulticast);
  ASSERT_TRUE(peer.wait_for_line("ready"));
  const auto context =
      Context::create(create_dds_transport({.domain_id = domain, .localhost_only = true}));
  Executor executor;
  Node node({.context = context,
             .executor = &executor,
             .name = {"/interop", "our_side"},
             .standard_interfaces = false});
  std::optional<Image> received;
  const auto subscription = node.create_subscription<Image>(
      "latched", QoS::latched(), [&](const Image& image) { received = image; });
  ASSERT_TRUE(executor.spin_until([&] { return received.has_value(); }, kPatience));
  EXPECT_EQ(received->header.frame_id, "latched");
}

TEST_F(CycloneTest, IncompatibleQosIsReportedHere) {
  std::optional<IncompatibleQos> event;
  const auto publisher = node_.create_publisher<Image>(
      "strict", QoS::sensor_data(),
      {.events = {.incompatible_qos = [&](const IncompatibleQos& told) { event = told; }}});
  ASSERT_TRUE(executor_.spin_until([&] { return event.has_value(); }, kPatience));
  EXPECT_THAT(event->policy, ::testing::AnyOf(QosPolicy::kReliability, QosPolicy::kDurability));
  EXPECT_EQ(publisher.subscription_count(), 0U);
}

TEST_F(CycloneTest, ItsDiscoverySeesOurNamesTypesAndQos) {
  const auto sensor = node_.create_publisher<Image>("names_sensor", QoS::sensor_data());
  const auto latched = node_.create_publisher<FusedOdometer>("names_latched", QoS::latched());
  const auto reader =
      node_.create_subscription<Odometry>("names_reader", QoS::reliable(), [](const Odometry&) {});
  EXPECT_TRUE(
      peer_.wait_for_line("endpoint WRITER rt/interop/names_sensor "
                          "sensor_msgs::msg::dds_::Image_ best_effort volatile"))
      << ::testing::PrintToString(peer_.lines());
  EXPECT_TRUE(
      peer_.wait_for_line("endpoint WRITER rt/interop/names_latched "
                          "pipescout_msgs::msg::dds_::FusedOdometer_ reliable transient_local"));
  EXPECT_TRUE(peer_.wait_for_line(
      "endpoint READER rt/interop/names_reader nav_msgs::msg::dds_::Odometry_ reliable volatile"));
}

TEST_F(CycloneTest, AnActionIsOnTheWireAsRos2HasIt) {
  using example_interfaces::action::Fibonacci;
  std::vector<ServerGoal<Fibonacci>> goals;
  const auto server = node_.create_action_server<Fibonacci>(
      "fibonacci",
      {.accepted = [&](ServerGoal<Fibonacci> goal) { goals.push_back(std::move(goal)); }});
  const auto publishers = node_.publishers();
  // The peer goes on to ask, so the executor looks again.
  ASSERT_TRUE(executor_.spin_until(
      [&] {
        return !goals.empty() &&
               std::all_of(publishers.begin(), publishers.end(), [](const auto& publisher) {
                 return publisher->subscription_count() > 0;
               });
      },
      kPatience));
  EXPECT_EQ(goals[0].goal().order, 3);
  EXPECT_THAT(to_string(goals[0].id()), ::testing::StartsWith("c7c8c9cacbcccdcecfd0d1d2d3d4d5"));
  Fibonacci::Feedback feedback;
  feedback.sequence = {0, 1};
  Fibonacci::Result result;
  result.sequence = {0, 1, 1, 2, 3};
  for (const auto& goal : goals) {
    goal.publish_feedback(feedback);
    goal.succeed(result);
  }
  std::thread spinner([this] { executor_.spin(); });
  for (const char* line : {"goal_reply 1", "feedback c7 0 1", "status 4", "result 4 0 1 1 2 3"}) {
    EXPECT_TRUE(peer_.wait_for_line(line))
        << line << ": " << ::testing::PrintToString(peer_.lines());
  }
  executor_.stop();
  spinner.join();
  const std::string type = " example_interfaces::action::dds_::Fibonacci_";
  const std::string name = "/interop/fibonacci/_action/";
  const std::string reliable = "_ reliable volatile";
  for (const std::string& line :
       {"READER rq" + name + "send_goalRequest" + type + "SendGoal_Request" + reliable,
        "WRITER rr" + name + "send_goalReply" + type + "SendGoal_Response" + reliable,
        "READER rq" + name + "get_resultRequest" + type + "GetResult_Request" + reliable,
        "WRITER rr" + name + "get_resultReply" + type + "GetResult_Response" + reliable,
        "READER rq" + name +
            "cancel_goalRequest action_msgs::srv::dds_::CancelGoal_Request_ reliable volatile",
        "WRITER rr" + name +
            "cancel_goalReply action_msgs::srv::dds_::CancelGoal_Response_ reliable volatile",
        "WRITER rt" + name + "feedback" + type + "FeedbackMessage" + reliable,
        "WRITER rt" + name +
            "status action_msgs::msg::dds_::GoalStatusArray_ reliable transient_local"}) {
    EXPECT_TRUE(peer_.wait_for_line("endpoint " + line))
        << line << ": " << ::testing::PrintToString(peer_.lines());
  }
}

TEST_F(CycloneTest, OurGraphSeesItsNamesTypesAndQos) {
  std::optional<GraphEndpoint> found;
  ASSERT_TRUE(context_->graph().wait_until(
      [&] {
        for (const auto& endpoint : context_->graph().endpoints()) {
          if (endpoint.wire_topic == "rt/interop/latched" && endpoint.is_publisher) {
            found = endpoint;
          }
        }
        return found.has_value();
      },
      kPatience));
  EXPECT_EQ(found->wire_type, "sensor_msgs::msg::dds_::Image_");
  EXPECT_EQ(found->qos.reliability, Reliability::kReliable);
  EXPECT_EQ(found->qos.durability, Durability::kTransientLocal);
  EXPECT_FALSE(found->in_this_process);
  EXPECT_FALSE(found->node) << "a plain DDS program belongs to no node";
}

}  // namespace
}  // namespace pipescout
