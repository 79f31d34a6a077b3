// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <optional>
#include <vector>

#include "tables/table_maker.hpp"
#include "tables/table_options.hpp"

/// The makers of tables, a subject each. Their files: docs/tables.md.
namespace pipescout::summary {

/// A run of a crawler: `odometer/fused`, `eddy_current`, `weld`, `pipe/position` and, from a
/// simulation, `ground_truth/pipe_position`.
[[nodiscard]] std::unique_ptr<TableMaker> crawler_tables(const Robot& robot,
                                                         const TableOptions::Crawler& options);
/// Readings of several odometers at once and their consensus: `odometer/readings`,
/// `odometer/fused`. `offsets`: m, that were added to the readings of each; empty: none; nothing:
/// not known. Throws CsvError when the reference cannot be read.
[[nodiscard]] std::unique_ptr<TableMaker> odometry_tables(
    const Robot& robot, const TableOptions::Odometry& options,
    const std::optional<std::vector<double>>& offsets);
/// A flight over a pipe rack: `rack/pose`, `rack/state`, `cmd_vel_stamped`, `camera/...`, from a
/// simulation `ground_truth/rack_pose`.
[[nodiscard]] std::unique_ptr<TableMaker> rack_tables(const Robot& robot,
                                                      const TableOptions::Rack& options);
/// `leak/detections`, `leak/events`, from a simulation `ground_truth/leaks`.
[[nodiscard]] std::unique_ptr<TableMaker> leak_tables(const Robot& robot);
/// The tracked pipe and the arm: `track/...`, `arm/state`, `joint_states`, `thermal/image_raw`,
/// from a simulation `ground_truth/pipe_track`.
[[nodiscard]] std::unique_ptr<TableMaker> tracking_tables(const Robot& robot,
                                                          const TableOptions::Tracking& options);
/// A state estimator: `odometry/filtered`, `estimator/state`, `gps/fix`, from a simulation
/// `ground_truth/odometry`. Throws std::invalid_argument when the datum is none.
[[nodiscard]] std::unique_ptr<TableMaker> estimator_tables(const Robot& robot,
                                                           const TableOptions::Estimator& options);
/// A robot that is navigated: `navigator/state`, `plan`, `odometry/filtered`, from a simulation
/// `ground_truth/odometry`.
[[nodiscard]] std::unique_ptr<TableMaker> navigation_tables(const Robot& robot);

}  // namespace pipescout::summary
