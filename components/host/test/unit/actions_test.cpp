// SPDX-License-Identifier: Apache-2.0
#include "core/actions.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace pipescout::host {
namespace {

using ::testing::ElementsAre;
using ::testing::IsEmpty;
using ::testing::Pair;

GraphEndpoint feedback(const std::string& action, bool is_publisher, std::optional<NodeName> node,
                       const std::string& type = "Fibonacci") {
  GraphEndpoint endpoint;
  endpoint.is_publisher = is_publisher;
  endpoint.wire_topic = "rt" + action + "/_action/feedback";
  endpoint.wire_type = "example_interfaces::action::dds_::" + type + "_FeedbackMessage_";
  endpoint.node = std::move(node);
  return endpoint;
}

TEST(ActionsInTheGraph, AreKnownByTheirFeedbackTopics) {
  EXPECT_THAT(actions_in({{"/a/fibonacci/_action/feedback",
                           {"example_interfaces/action/Fibonacci_FeedbackMessage", "x/msg/Y"}},
                          {"/a/fibonacci/_action/status", {"action_msgs/msg/GoalStatusArray"}},
                          {"/_action/feedback", {"x/action/Y_FeedbackMessage"}},
                          {"/chatter", {"std_msgs/msg/String"}}}),
              ElementsAre(Pair("/a/fibonacci",
                               ElementsAre("example_interfaces/action/Fibonacci", "x/msg/Y"))));
}

TEST(ActionsInTheGraph, HaveServersAndClients) {
  const NodeName server{"/", "server"};
  const NodeName client{"/ns", "client"};
  GraphEndpoint other = feedback("/fibonacci", true, server);
  other.wire_topic = "rt/fibonacci/_action/status";
  const std::vector<GraphEndpoint> endpoints{feedback("/fibonacci", true, server),
                                             feedback("/fibonacci", false, client),
                                             feedback("/other", true, server, "Other"),
                                             feedback("/fibonacci", false, std::nullopt), other};
  const auto fibonacci = ElementsAre("example_interfaces/action/Fibonacci");
  EXPECT_THAT(nodes_of_action(endpoints, "/fibonacci", true), ElementsAre(Pair(server, fibonacci)));
  EXPECT_THAT(nodes_of_action(endpoints, "/fibonacci", false),
              ElementsAre(Pair(client, fibonacci)));
  EXPECT_THAT(nodes_of_action(endpoints, "/nothing", true), IsEmpty());
  EXPECT_THAT(actions_of_node(endpoints, server, true),
              ElementsAre(Pair("/fibonacci", fibonacci),
                          Pair("/other", ElementsAre("example_interfaces/action/Other"))));
  EXPECT_THAT(actions_of_node(endpoints, server, false), IsEmpty());
}

}  // namespace
}  // namespace pipescout::host
