// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "pipescout/runtime/names.hpp"

namespace pipescout {

/// The ROS name of the topic of a publisher or subscription; its DDS name where that is not of ROS.
template <class Endpoint>
std::string ros_name(const Endpoint& endpoint) {
  const auto demangled = demangle_topic_name(endpoint.topic().name);
  return demangled ? demangled->name : endpoint.topic().name;
}

}  // namespace pipescout
