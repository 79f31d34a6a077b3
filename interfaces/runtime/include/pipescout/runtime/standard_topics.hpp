// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "pipescout/runtime/topic.hpp"

namespace diagnostic_msgs::msg {
struct DiagnosticArray;
}
namespace pipescout_msgs::msg {
struct MissionStatus;
}
namespace rcl_interfaces::msg {
struct Log;
struct ParameterEvent;
}  // namespace rcl_interfaces::msg
namespace rosgraph_msgs::msg {
struct Clock;
}
namespace tf2_msgs::msg {
struct TFMessage;
}

/// Topics of every node, whatever the domain: those of ROS 2, and the one on which components tell
/// their progress. The types are only declared here; include the message's own header to use them.
namespace pipescout::topics {

/// Progress and completion of components, for the host and the operator. Kept for late joiners: the
/// last word of a component must not be lost because it was said before they were discovered.
inline constexpr Topic<pipescout_msgs::msg::MissionStatus> kMissionStatus{"mission/status",
                                                                          QoS::latched(10)};

/// Simulated time, for nodes with `use_sim_time`. They want the latest, and hold nobody up.
inline constexpr Topic<rosgraph_msgs::msg::Clock> kClock{
    .name = "/clock", .qos = QoS::reliable(10), .requested = QoS::sensor_data(1)};
/// Transforms between frames, from whoever knows them; those that never change kept for late
/// joiners. Each robot has its own, `/ROBOT/tf`, with the same names of frames: `/tf` only without
/// a namespace. A publisher of static ones says all of its transforms in one message; who listens
/// must not lose one of many publishers for another.
inline constexpr Topic<tf2_msgs::msg::TFMessage> kTf{"tf", QoS::reliable(100)};
inline constexpr Topic<tf2_msgs::msg::TFMessage> kTfStatic{
    .name = "tf_static", .qos = QoS::latched(1), .requested = QoS::latched(100)};
inline constexpr Topic<diagnostic_msgs::msg::DiagnosticArray> kDiagnostics{"/diagnostics",
                                                                           QoS::reliable(10)};
/// As rcl: kept for late joiners, forgotten after ten seconds.
inline constexpr Topic<rcl_interfaces::msg::Log> kRosout{
    "/rosout", QoS{.depth = 1000,
                   .durability = Durability::kTransientLocal,
                   .lifespan = std::chrono::seconds(10)}};
inline constexpr Topic<rcl_interfaces::msg::ParameterEvent> kParameterEvents{"/parameter_events",
                                                                             QoS::parameters()};

}  // namespace pipescout::topics
