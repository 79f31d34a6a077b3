// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <span>
#include <string>
#include <vector>

#include "doctor/observation.hpp"

namespace pipescout::host::doctor {

enum class Severity { kWarning, kError };

struct Finding {
  Severity severity = Severity::kWarning;
  std::string what;    ///< one sentence: what is wrong
  std::string advice;  ///< one sentence: what to do
};

/// One kind of fault. Looks at what was observed alone; what was not observed is not found wrong.
struct Check {
  const char* name;  ///< "quality-of-service"
  std::vector<Finding> (*run)(const Observation&);
};

// graph_checks.cpp
[[nodiscard]] std::vector<Finding> check_discovery(const Observation& seen);
[[nodiscard]] std::vector<Finding> check_localhost_only(const Observation& seen);
[[nodiscard]] std::vector<Finding> check_quality_of_service(const Observation& seen);
[[nodiscard]] std::vector<Finding> check_types(const Observation& seen);
[[nodiscard]] std::vector<Finding> check_inputs(const Observation& seen);
[[nodiscard]] std::vector<Finding> check_node_names(const Observation& seen);
[[nodiscard]] std::vector<Finding> check_clock_publishers(const Observation& seen);
[[nodiscard]] std::vector<Finding> check_camera_calibration(const Observation& seen);

// sensor_checks.cpp
[[nodiscard]] std::vector<Finding> check_stamps(const Observation& seen);
[[nodiscard]] std::vector<Finding> check_imu(const Observation& seen);
[[nodiscard]] std::vector<Finding> check_gps(const Observation& seen);
[[nodiscard]] std::vector<Finding> check_datum(const Observation& seen);

// machine_checks.cpp
[[nodiscard]] std::vector<Finding> check_shared_memory(const Observation& seen);
[[nodiscard]] std::vector<Finding> check_network(const Observation& seen);
[[nodiscard]] std::vector<Finding> check_disk(const Observation& seen);

// composition_checks.cpp
[[nodiscard]] std::vector<Finding> check_components(const Observation& seen);
[[nodiscard]] std::vector<Finding> check_parameters(const Observation& seen);

/// All, in the order in which a person mends things: what keeps a composition from starting first.
[[nodiscard]] std::span<const Check> all_checks();

/// The findings of all checks, in their order.
[[nodiscard]] std::vector<Finding> examine(const Observation& seen);

/// "error: WHAT\n  ADVICE\n" for each, then how many there are.
[[nodiscard]] std::string report(const std::vector<Finding>& findings);

/// Whether any is an error.
[[nodiscard]] bool has_errors(const std::vector<Finding>& findings);

}  // namespace pipescout::host::doctor
