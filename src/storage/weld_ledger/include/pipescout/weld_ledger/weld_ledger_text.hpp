// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <pipescout/odometry/weld_ledger.hpp>
#include <string>

#include "pipescout/csv/csv_table.hpp"

/// A weld ledger as text: docs/weld_ledger.md. Pure functions; thread-safe.
namespace pipescout {

/// CSV with a header, one row per weld and landmark; every double with as many digits as a lossless
/// round trip needs:
///   id, chainage_m, chainage_sd_m, joint_length_m, joint_length_sd_m, seen, passed
///   latitude_deg, longitude_deg, height_m, position_sd_m, or x_m, y_m, z_m, position_sd_m
///   run NAME|DATE chainage_m, run NAME|DATE sd_m, for each run
/// and behind the id, when there are landmarks, kind: weld, marker, valve, tee or bend, and when
/// the angles of bends are known, angle_deg, to a billionth. Empty: not available. `seen` and
/// `passed` are informative.
[[nodiscard]] std::string to_csv(const odometry::WeldLedger& ledger);

/// The exact inverse of `to_csv`, but for runs of blanks in names of runs. A tally may have fewer
/// columns: `id` and one of `chainage_m` and `joint_length_m` are enough; without runs its values
/// become those of the run "tally", without standard deviations they get
/// `default_standard_deviation`. Throws CsvError, message "ledger.csv:7: column 'joint_length_m':
/// -3 is not above 0", for unknown, repeated or missing columns, ids that are empty or repeated,
/// joint lengths or chainages that are missing, negative, zero, repeated, not finite or disagree
/// with each other, and the like.
[[nodiscard]] odometry::WeldLedger ledger_from_csv(const CsvTable& csv,
                                                   double default_standard_deviation = 0.05);

/// RFC 7946: a FeatureCollection of a LineString through the welds (a MultiLineString where it
/// crosses the antimeridian) and a Point for each; geometry null without a geodetic position.
[[nodiscard]] std::string to_geojson(const odometry::WeldLedger& ledger);

}  // namespace pipescout
