// SPDX-License-Identifier: Apache-2.0
#include "pipescout/runtime/graph.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <atomic>
#include <memory>
#include <nav_msgs/msg/odometry.hpp>
#include <optional>
#include <rmw_dds_common/msg/participant_entities_info.hpp>
#include <std_msgs/msg/string.hpp>
#include <std_srvs/srv/trigger.hpp>
#include <stdexcept>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "pipescout/runtime/context.hpp"
#include "pipescout/runtime/service.hpp"
#include "pipescout/testing/fake_transport.hpp"

namespace pipescout {
namespace {

using std::chrono::milliseconds;
using std::chrono::seconds;
using ::testing::ElementsAre;
using testing::FakeNetwork;
using ::testing::IsEmpty;
using ::testing::Pair;
using ::testing::UnorderedElementsAre;

using rmw_dds_common::msg::ParticipantEntitiesInfo;

constexpr Duration kLong = seconds(30);

const NodeName kTalker{"/robot", "talker"};
const NodeName kListener{"/", "listener"};

std::shared_ptr<UntypedPublisher> string_publisher(Context& context, const std::string& topic) {
  return context.create_publisher({.topic = {topic, &message_type<std_msgs::msg::String>()}});
}

std::shared_ptr<UntypedSubscription> string_subscription(Context& context,
                                                         const std::string& topic) {
  return context.create_subscription({.topic = {topic, &message_type<std_msgs::msg::String>()},
                                      .callback = [](const auto&, const auto&) {}});
}

std::string numbered(std::string prefix, int number) {
  prefix.append(std::to_string(number));
  return prefix;
}

std::optional<GraphEndpoint> find(const Graph& graph, const Gid& gid) {
  for (const auto& endpoint : graph.endpoints()) {
    if (endpoint.gid == gid) {
      return endpoint;
    }
  }
  return std::nullopt;
}

TEST(GraphInProcess, ListsNodesSortedAndRefusesASecondOfOneName) {
  const auto context = Context::create_in_process();
  Graph& graph = context->graph();
  EXPECT_THAT(graph.nodes(), IsEmpty());
  graph.add_node(kTalker);
  graph.add_node(kListener);
  EXPECT_THROW(graph.add_node(kTalker), std::invalid_argument);
  EXPECT_THAT(graph.nodes(), ElementsAre(kListener, kTalker));
  graph.remove_node(kTalker);
  graph.remove_node(kTalker);
  EXPECT_THAT(graph.nodes(), ElementsAre(kListener));
  graph.add_node(kTalker);
}

TEST(GraphInProcess, ListsEndpointsTopicsAndServices) {
  const auto context = Context::create_in_process();
  Graph& graph = context->graph();
  graph.add_node(kTalker);
  auto publisher = string_publisher(*context, "rt/robot/chatter");
  auto subscription = string_subscription(*context, "rt/robot/chatter");
  const auto plain = string_publisher(*context, "plain_dds");
  graph.add_endpoint(kTalker, publisher);
  graph.add_endpoint(kTalker, subscription);
  graph.add_endpoint(kTalker, plain);

  const auto endpoint = find(graph, publisher->gid());
  ASSERT_TRUE(endpoint);
  EXPECT_TRUE(endpoint->is_publisher);
  EXPECT_TRUE(endpoint->in_this_process);
  EXPECT_EQ(endpoint->wire_topic, "rt/robot/chatter");
  EXPECT_EQ(endpoint->wire_type, "std_msgs::msg::dds_::String_");
  EXPECT_EQ(endpoint->node, kTalker);
  EXPECT_EQ(endpoint->qos, publisher->qos());
  EXPECT_FALSE(find(graph, subscription->gid())->is_publisher);
  EXPECT_THAT(graph.topics(),
              ElementsAre(Pair("/robot/chatter", ElementsAre("std_msgs/msg/String"))));
  EXPECT_THAT(graph.services(), IsEmpty());

  publisher.reset();
  subscription.reset();
  EXPECT_EQ(graph.endpoints().size(), 1U);
  EXPECT_THAT(graph.topics(), IsEmpty());
}

TEST(GraphInProcess, DemanglesServices) {
  Executor executor;
  const auto context = Context::create_in_process();
  Graph& graph = context->graph();
  graph.add_node(kTalker);
  using Trigger = std_srvs::srv::Trigger;
  const auto service = create_untyped_service(*context,
                                              {.name = "/robot/talker/reset",
                                               .request = &message_type<Trigger::Request>(),
                                               .response = &message_type<Trigger::Response>(),
                                               .group = executor.create_callback_group()},
                                              [](const auto&, const auto&) {});
  graph.add_endpoint(kTalker, service->reply_publisher());
  graph.add_endpoint(kTalker, service->request_subscription());
  EXPECT_THAT(graph.services(),
              ElementsAre(Pair("/robot/talker/reset", ElementsAre("std_srvs/srv/Trigger"))));
  EXPECT_THAT(graph.topics(), IsEmpty());
}

TEST(GraphInProcess, AnEndpointNeedsANodeAndHasOnlyOne) {
  const auto context = Context::create_in_process();
  Graph& graph = context->graph();
  const auto publisher = string_publisher(*context, "rt/chatter");
  EXPECT_THROW(graph.add_endpoint(kTalker, publisher), std::invalid_argument);
  graph.add_node(kTalker);
  graph.add_node(kListener);
  graph.add_endpoint(kTalker, publisher);
  EXPECT_THROW(graph.add_endpoint(kListener, publisher), std::invalid_argument);
  graph.remove_node(kTalker);
  EXPECT_EQ(find(graph, publisher->gid())->node, std::nullopt);
}

TEST(GraphInProcess, TellsChangesUntilTheHandleGoes) {
  const auto context = Context::create_in_process();
  Graph& graph = context->graph();
  std::size_t nodes_seen = 0;
  int calls = 0;
  auto handle = graph.on_changed([&] {
    ++calls;
    nodes_seen = graph.nodes().size();
    EXPECT_EQ(graph.topics().size() + graph.services().size(), graph.endpoints().size());
  });
  graph.add_node(kTalker);
  EXPECT_EQ(nodes_seen, 1U);
  auto publisher = string_publisher(*context, "rt/chatter");
  graph.add_endpoint(kTalker, publisher);
  publisher.reset();
  EXPECT_EQ(calls, 3);
  handle.reset();
  graph.add_node(kListener);
  EXPECT_EQ(calls, 3);
}

TEST(GraphInProcess, ACallbackMayDropItsOwnHandle) {
  const auto context = Context::create_in_process();
  int calls = 0;
  std::shared_ptr<void> handle;
  handle = context->graph().on_changed([&] {
    ++calls;
    handle.reset();
  });
  context->graph().add_node(kTalker);
  context->graph().add_node(kListener);
  EXPECT_EQ(calls, 1);
}

TEST(GraphInProcess, WaitsForAChange) {
  const auto context = Context::create_in_process();
  Graph& graph = context->graph();
  EXPECT_TRUE(graph.wait_until([] { return true; }, Duration::zero()));
  EXPECT_FALSE(graph.wait_until([] { return false; }, milliseconds(1)));
  std::thread other([&] {
    graph.add_node(kListener);
    graph.add_node(kTalker);
  });
  EXPECT_TRUE(graph.wait_until([&] { return graph.nodes().size() == 2; }, Duration::max()));
  other.join();
}

/// Two processes that hear of each other through `ros_discovery_info`.
class GraphAcrossProcesses : public ::testing::Test {
 protected:
  FakeNetwork network_;
  std::shared_ptr<Context> here_ = Context::create(network_.create_transport("here"));
  std::shared_ptr<Context> there_ = Context::create(network_.create_transport("there"));
};

TEST_F(GraphAcrossProcesses, NodesAndEndpointsAreSeenByTheOther) {
  here_->graph().add_node(kTalker);
  there_->graph().add_node(kTalker);
  there_->graph().add_node(kListener);
  const auto publisher = string_publisher(*here_, "rt/chatter");
  here_->graph().add_endpoint(kTalker, publisher);
  const auto subscription = string_subscription(*here_, "rt/other");
  here_->graph().add_endpoint(kTalker, subscription);
  const auto unowned = string_publisher(*here_, "rt/unowned");
  network_.deliver();

  EXPECT_THAT(here_->graph().nodes(), ElementsAre(kListener, kTalker, kTalker));
  EXPECT_THAT(there_->graph().nodes(), ElementsAre(kListener, kTalker, kTalker));
  const auto endpoint = find(there_->graph(), publisher->gid());
  ASSERT_TRUE(endpoint);
  EXPECT_EQ(endpoint->node, kTalker);
  EXPECT_FALSE(endpoint->in_this_process);
  EXPECT_TRUE(endpoint->is_publisher);
  EXPECT_EQ(endpoint->qos.depth, 0U);
  EXPECT_EQ(endpoint->wire_type, "std_msgs::msg::dds_::String_");
  EXPECT_EQ(find(there_->graph(), subscription->gid())->node, kTalker);
  EXPECT_EQ(find(there_->graph(), unowned->gid())->node, std::nullopt);
  EXPECT_THAT(there_->graph().topics(),
              ElementsAre(Pair("/chatter", ElementsAre("std_msgs/msg/String")),
                          Pair("/other", ElementsAre("std_msgs/msg/String")),
                          Pair("/unowned", ElementsAre("std_msgs/msg/String"))));
}

TEST_F(GraphAcrossProcesses, TheAnnouncementHasTheFormOfRos2) {
  std::shared_ptr<const ParticipantEntitiesInfo> last;
  const auto listener = there_->create_subscription(
      {.topic = {"ros_discovery_info", &message_type<ParticipantEntitiesInfo>()},
       .qos = QoS::latched(10),
       .callback = [&](const std::shared_ptr<const void>& message, const MessageInfo& info) {
         if (!info.from_this_process) {
           last = std::static_pointer_cast<const ParticipantEntitiesInfo>(message);
         }
       }});
  here_->graph().add_node(kTalker);
  const auto publisher = string_publisher(*here_, "rt/chatter");
  const auto subscription = string_subscription(*here_, "rt/chatter");
  here_->graph().add_endpoint(kTalker, publisher);
  here_->graph().add_endpoint(kTalker, subscription);
  network_.deliver();

  const auto wire = [](const Gid& gid) {
    std::array<std::uint8_t, 24> bytes{};
    std::copy(gid.bytes.begin(), gid.bytes.end(), bytes.begin());
    return bytes;
  };
  ASSERT_TRUE(last);
  EXPECT_EQ(last->gid.data, wire(here_->transport()->participant()));
  ASSERT_EQ(last->node_entities_info_seq.size(), 1U);
  const auto& node = last->node_entities_info_seq.front();
  EXPECT_EQ(node.node_namespace, "/robot");
  EXPECT_EQ(node.node_name, "talker");
  ASSERT_EQ(node.writer_gid_seq.size(), 1U);
  EXPECT_EQ(node.writer_gid_seq.front().data, wire(publisher->gid()));
  ASSERT_EQ(node.reader_gid_seq.size(), 1U);
  EXPECT_EQ(node.reader_gid_seq.front().data, wire(subscription->gid()));
  EXPECT_EQ(message_type<ParticipantEntitiesInfo>().dds_name,
            "rmw_dds_common::msg::dds_::ParticipantEntitiesInfo_");
}

TEST_F(GraphAcrossProcesses, ABurstOfChangesIsAnnouncedOnce) {
  std::vector<std::size_t> announced_writers;
  const auto listener = there_->create_subscription(
      {.topic = {"ros_discovery_info", &message_type<ParticipantEntitiesInfo>()},
       .qos = QoS::latched(10),
       .callback = [&](const std::shared_ptr<const void>& message, const MessageInfo& info) {
         if (info.from_this_process) {
           return;
         }
         std::size_t writers = 0;
         const auto& told = *static_cast<const ParticipantEntitiesInfo*>(message.get());
         for (const auto& node : told.node_entities_info_seq()) {
           writers += node.writer_gid_seq().size();
         }
         announced_writers.push_back(writers);
       }});
  network_.deliver();
  announced_writers.clear();
  std::vector<std::shared_ptr<UntypedPublisher>> publishers;
  for (int node = 0; node < 50; ++node) {
    const NodeName name{"/", numbered("node_", node)};
    here_->graph().add_node(name);
    for (int i = 0; i < 4; ++i) {
      publishers.push_back(string_publisher(*here_, numbered("rt/topic_", i)));
      here_->graph().add_endpoint(name, publishers.back());
    }
  }
  network_.deliver();
  EXPECT_THAT(announced_writers, ElementsAre(200));
  publishers.resize(100);
  network_.deliver();
  EXPECT_THAT(announced_writers, ElementsAre(200, 100));
}

TEST_F(GraphAcrossProcesses, NodesThatShareAReaderAreBothShownWithIt) {
  here_->graph().add_node(kTalker);
  here_->graph().add_node(kListener);
  const auto first = string_subscription(*here_, "rt/chatter");
  auto second = string_subscription(*here_, "rt/chatter");
  auto third = string_subscription(*here_, "rt/chatter");
  ASSERT_EQ(first->gid(), second->gid());
  here_->graph().add_endpoint(kTalker, first);
  here_->graph().add_endpoint(kListener, second);
  here_->graph().add_endpoint(kListener, third);
  network_.deliver();
  const auto owners = [&](const Graph& graph) {
    std::vector<NodeName> nodes;
    for (const auto& endpoint : graph.endpoints()) {
      if (endpoint.gid == first->gid() && endpoint.node) {
        nodes.push_back(*endpoint.node);
      }
    }
    return nodes;
  };
  EXPECT_THAT(owners(here_->graph()), ElementsAre(kListener, kListener, kTalker));
  EXPECT_THAT(owners(there_->graph()), UnorderedElementsAre(kListener, kTalker));
  second.reset();
  network_.deliver();
  EXPECT_THAT(owners(there_->graph()), UnorderedElementsAre(kListener, kTalker));
  third.reset();
  network_.deliver();
  EXPECT_THAT(owners(there_->graph()), ElementsAre(kTalker));
}

TEST_F(GraphAcrossProcesses, ALateProcessHearsOfWhatWasThereBefore) {
  here_->graph().add_node(kTalker);
  network_.deliver();
  const auto late = Context::create(network_.create_transport("late"));
  network_.deliver();
  EXPECT_THAT(late->graph().nodes(), ElementsAre(kTalker));
}

TEST_F(GraphAcrossProcesses, AProcessThatEndsOrCrashesTakesItsNodesAlong) {
  here_->graph().add_node(kTalker);
  there_->graph().add_node(kListener);
  auto third = Context::create(network_.create_transport("third"));
  third->graph().add_node({"/", "third"});
  network_.deliver();
  EXPECT_EQ(there_->graph().nodes().size(), 3U);
  third.reset();
  network_.deliver();
  EXPECT_EQ(there_->graph().nodes().size(), 2U);
  network_.crash(here_->transport()->participant());
  network_.deliver();
  EXPECT_THAT(there_->graph().nodes(), ElementsAre(kListener));
  EXPECT_THAT(there_->graph().topics(), IsEmpty());
}

TEST_F(GraphAcrossProcesses, RemoteChangesAreToldAndMayBeAskedFor) {
  std::vector<std::size_t> nodes_seen;
  const auto handle = there_->graph().on_changed([&] {
    nodes_seen.push_back(there_->graph().nodes().size());
    EXPECT_GE(there_->graph().endpoints().size(), 1U);
  });
  here_->graph().add_node(kTalker);
  network_.deliver();
  ASSERT_FALSE(nodes_seen.empty());
  EXPECT_EQ(nodes_seen.back(), 1U);
}

TEST_F(GraphAcrossProcesses, NobodySpeaksForAnother) {
  const auto liar = there_->create_publisher(
      {.topic = {"ros_discovery_info", &message_type<ParticipantEntitiesInfo>()},
       .qos = QoS::latched(1)});
  auto lie = std::make_shared<ParticipantEntitiesInfo>();
  lie->gid.data[0] = 1;
  lie->node_entities_info_seq.resize(1);
  lie->node_entities_info_seq[0].node_name = "ghost";
  liar->publish(lie, {});
  network_.deliver();
  EXPECT_THAT(here_->graph().nodes(), IsEmpty());
}

TEST_F(GraphAcrossProcesses, TheLastStateIsNeverLostHoweverManyThreadsChangeIt) {
  constexpr int kThreads = 4;
  constexpr int kNodes = 20;
  std::vector<std::thread> threads;
  std::atomic<int> running{kThreads};
  for (int t = 0; t < kThreads; ++t) {
    threads.emplace_back([&, t] {
      for (int i = 0; i < kNodes; ++i) {
        const NodeName node{"/", numbered(numbered("n", t) + "_", i)};
        here_->graph().add_node(node);
        auto publisher = string_publisher(*here_, numbered("rt/t", t));
        here_->graph().add_endpoint(node, publisher);
        if (i % 2 == 0) {
          publisher.reset();
          here_->graph().remove_node(node);
        }
      }
      --running;
    });
  }
  while (running > 0) {
    network_.deliver();
    there_->graph().endpoints();
  }
  for (auto& thread : threads) {
    thread.join();
  }
  network_.deliver();
  EXPECT_EQ(there_->graph().nodes(), here_->graph().nodes());
  EXPECT_EQ(there_->graph().nodes().size(), static_cast<std::size_t>(kThreads * kNodes / 2));
}

TEST_F(GraphAcrossProcesses, ManyNodesWithManyEndpoints) {
  constexpr int kNodes = 20;
  constexpr int kEndpoints = 25;
  std::vector<std::shared_ptr<UntypedPublisher>> publishers;
  for (int n = 0; n < kNodes; ++n) {
    const NodeName node{"/", numbered("node_", n)};
    here_->graph().add_node(node);
    for (int e = 0; e < kEndpoints; ++e) {
      publishers.push_back(string_publisher(*here_, numbered(numbered("rt/n", n) + "/t", e)));
      here_->graph().add_endpoint(node, publishers.back());
    }
  }
  network_.deliver();
  EXPECT_EQ(there_->graph().nodes().size(), 20U);
  EXPECT_EQ(there_->graph().topics().size(), 500U);
  const auto endpoints = there_->graph().endpoints();
  EXPECT_EQ(std::count_if(endpoints.begin(), endpoints.end(),
                          [](const GraphEndpoint& endpoint) { return endpoint.node.has_value(); }),
            kNodes * kEndpoints);
}

TEST(GraphLifetime, EndpointsOutliveTheGraph) {
  FakeNetwork network;
  auto context = Context::create(network.create_transport());
  context->graph().add_node(kTalker);
  auto publisher = string_publisher(*context, "rt/chatter");
  context->graph().add_endpoint(kTalker, publisher);
  context.reset();
  publisher.reset();
  network.deliver();
}

}  // namespace
}  // namespace pipescout
