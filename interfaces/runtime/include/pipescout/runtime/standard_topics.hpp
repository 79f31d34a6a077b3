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

/// Topics common to all nodes: those of ROS 2, and the mission status of components. The types are
/// only declared here; include the message's own header to use them.
namespace pipescout::topics {

/// Progress and completion of components, for the host and the operator. Kept for late joiners, so
/// that a status from before their discovery is not lost.
inline constexpr Topic<pipescout_msgs::msg::MissionStatus> kMissionStatus{"mission/status",
                                                                          QoS::latched(10)};

/// Simulated time, for nodes with `use_sim_time`. Best effort: only the latest matters, and a slow
/// reader must not block the publisher.
inline constexpr Topic<rosgraph_msgs::msg::Clock> kClock{
    .name = "/clock", .qos = QoS::reliable(10), .requested = QoS::sensor_data(1)};
/// Transforms between frames; static ones are kept for late joiners. Each robot has its own,
/// `/ROBOT/tf`, with the same names of frames: `/tf` only without a namespace. A publisher of
/// static ones says all of its transforms in one message; who listens must not lose one of many
/// publishers for another.
inline constexpr Topic<tf2_msgs::msg::TFMessage> kTf{"tf", QoS::reliable(100)};
inline constexpr Topic<tf2_msgs::msg::TFMessage> kTfStatic{
    .name = "tf_static", .qos = QoS::latched(1), .requested = QoS::latched(100)};
inline constexpr Topic<diagnostic_msgs::msg::DiagnosticArray> kDiagnostics{"/diagnostics",
                                                                           QoS::reliable(10)};
/// As in rcl: kept for late joiners, with a lifespan of ten seconds.
inline constexpr Topic<rcl_interfaces::msg::Log> kRosout{
    "/rosout", QoS{.depth = 1000,
                   .durability = Durability::kTransientLocal,
                   .lifespan = std::chrono::seconds(10)}};
inline constexpr Topic<rcl_interfaces::msg::ParameterEvent> kParameterEvents{"/parameter_events",
                                                                             QoS::parameters()};

}  // namespace pipescout::topics
