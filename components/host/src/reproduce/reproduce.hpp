// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <nlohmann/json.hpp>
#include <ostream>
#include <span>
#include <string_view>

/// Tables of the papers, computed anew. One file per table; tables.cpp lists them.
namespace pipescout::host {

struct Reproduction {
  nlohmann::json figures = nlohmann::json::object();  ///< name to number
  nlohmann::json rows = nlohmann::json::array();
  nlohmann::json seeds = nlohmann::json::array();  ///< of the random numbers used, if any
};

struct ReproducibleTable {
  std::string_view name;
  std::string_view description;  ///< one line
  /// Computes the table and prints it beside the paper's. Throws std::exception when its data is
  /// missing.
  Reproduction (*reproduce)(std::ostream& out);
};

[[nodiscard]] std::span<const ReproducibleTable> reproducible_tables();

// The tables.
Reproduction reproduce_odometry(std::ostream& out);

}  // namespace pipescout::host
