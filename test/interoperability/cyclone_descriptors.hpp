// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <dds/dds.h>

#include <span>
#include <string_view>

namespace pipescout::testing {

struct CycloneType {
  std::string_view name;  ///< of ROS: "sensor_msgs/msg/Image"
  const dds_topic_descriptor_t* descriptor;
};

/// What idlc made of every type that pipescout_idl holds.
[[nodiscard]] std::span<const CycloneType> cyclone_types();

}  // namespace pipescout::testing
