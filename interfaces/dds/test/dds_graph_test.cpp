// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <cstddef>
#include <memory>
#include <rmw_dds_common/msg/participant_entities_info.hpp>
#include <std_msgs/msg/string.hpp>
#include <string>
#include <vector>

#include "dds_profile.hpp"
#include "dds_test_support.hpp"
#include "pipescout/runtime/context.hpp"
#include "pipescout/runtime/graph.hpp"

namespace pipescout {
namespace {

using rmw_dds_common::msg::ParticipantEntitiesInfo;

TEST(DdsGraphTest, ABurstOfChangesIsAnnouncedFarLessOftenThanItHasChanges) {
  constexpr int kNodes = 50;
  constexpr int kTopicsOfEach = 4;
  const auto here = Context::create(create_dds_transport(dds_test::local_options()));
  const auto there = Context::create(create_dds_transport(dds_test::local_options()));
  const MessageType& type = message_type<ParticipantEntitiesInfo>();
  dds_test::Monitor monitor;
  std::size_t bytes = 0;
  std::size_t last_bytes = 0;
  std::size_t last_writers = 0;
  const auto listener = there->create_subscription(
      {.topic = {"ros_discovery_info", &type},
       .qos = QoS::latched(1000),
       .callback = [&](const std::shared_ptr<const void>& message, const MessageInfo& info) {
         if (info.from_this_process) {
           return;
         }
         monitor.change([&] {
           last_bytes = type.serialized_size(message.get());
           bytes += last_bytes;
           last_writers = 0;
           const auto& told = *static_cast<const ParticipantEntitiesInfo*>(message.get());
           for (const auto& node : told.node_entities_info_seq) {
             last_writers += node.writer_gid_seq.size();
           }
         });
       }});
  std::vector<std::shared_ptr<UntypedPublisher>> publishers;
  for (int node = 0; node < kNodes; ++node) {
    const NodeName name{"/", "node_" + std::to_string(node)};
    here->graph().add_node(name);
    for (int i = 0; i < kTopicsOfEach; ++i) {
      publishers.push_back(
          here->create_publisher({.topic = dds_test::text_topic("burst_" + std::to_string(i))}));
      here->graph().add_endpoint(name, publishers.back());
    }
  }
  ASSERT_TRUE(monitor.await([&] { return last_writers == publishers.size(); }));
  // Loosely: how many announcements there are depends on how long the machine takes.
  constexpr std::size_t kChanges = kNodes * (1 + kTopicsOfEach);
  EXPECT_LT(monitor.copy(bytes), kChanges / 5 * monitor.copy(last_bytes));
}

}  // namespace
}  // namespace pipescout
