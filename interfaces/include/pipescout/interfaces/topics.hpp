// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "pipescout/interfaces/topic.hpp"

namespace diagnostic_msgs::msg {
class DiagnosticArray;
}
namespace pipescout_msgs::msg {
class EddyCurrentSamples;
class FusedOdometer;
class MissionStatus;
class OdometerReadings;
class PipePosition;
class WeldDetection;
}  // namespace pipescout_msgs::msg
namespace rcl_interfaces::msg {
class Log;
class ParameterEvent;
}  // namespace rcl_interfaces::msg
namespace rosgraph_msgs::msg {
class Clock;
}

/// The catalogue: the one place where a topic's name, type and QoS are written down. The types are
/// only declared here; include the message's own header to use them.
namespace pipescout::topics {

/// Raw readings of all odometers of a robot, from the driver.
inline const Topic<pipescout_msgs::msg::OdometerReadings> kOdometerReadings{"odometer/readings",
                                                                            QoS::reliable(100)};
/// One distance from all odometers that agree.
inline const Topic<pipescout_msgs::msg::FusedOdometer> kOdometerFused{"odometer/fused",
                                                                      QoS::reliable(100)};
/// The signal of an eddy-current probe, from the driver.
inline const Topic<pipescout_msgs::msg::EddyCurrentSamples> kEddyCurrent{"eddy_current",
                                                                         QoS::reliable(100)};
/// Girth welds that the probe has passed.
inline const Topic<pipescout_msgs::msg::WeldDetection> kWeld{"weld", QoS::reliable(100)};
/// Where the crawler is in the pipe: joint and distance into it.
inline const Topic<pipescout_msgs::msg::PipePosition> kPipePosition{"pipe/position",
                                                                    QoS::reliable(100)};
/// Where it really is, from a simulator. Never published by a robot.
inline const Topic<pipescout_msgs::msg::PipePosition> kTruePipePosition{
    "ground_truth/pipe_position", QoS::reliable(100)};
/// Progress and completion of components, for the host and the operator. Kept for late joiners: the
/// last word of a component must not be lost because it was said before they were discovered.
inline const Topic<pipescout_msgs::msg::MissionStatus> kMissionStatus{"mission/status",
                                                                      QoS::latched(10)};

/// Simulated time, for nodes with `use_sim_time`.
inline const Topic<rosgraph_msgs::msg::Clock> kClock{"/clock", QoS::reliable(10)};
inline const Topic<diagnostic_msgs::msg::DiagnosticArray> kDiagnostics{"/diagnostics",
                                                                       QoS::reliable(10)};
/// As rcl: kept for late joiners, forgotten after ten seconds.
inline const Topic<rcl_interfaces::msg::Log> kRosout{"/rosout",
                                                     QoS{.depth = 1000,
                                                         .durability = Durability::kTransientLocal,
                                                         .lifespan = std::chrono::seconds(10)}};
inline const Topic<rcl_interfaces::msg::ParameterEvent> kParameterEvents{"/parameter_events",
                                                                         QoS::parameters()};

}  // namespace pipescout::topics
