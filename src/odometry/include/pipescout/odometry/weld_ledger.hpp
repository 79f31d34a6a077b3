// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <optional>
#include <span>
#include <stdexcept>
#include <string>
#include <string_view>
#include <vector>

#include "pipescout/odometry/centre_line.hpp"
#include "pipescout/odometry/chainage_map.hpp"
#include "pipescout/odometry/weld_alignment.hpp"

/// The weld ledger of a pipe: estimates of its girth welds, and of its landmarks besides them, from
/// all runs so far. Each run refines it, and a finding gets a position relative to a weld that can
/// be located years later.
///
/// A plain value; every function is pure. Distances and standard deviations in metres.
namespace pipescout::odometry {

/// One run through the pipe, or the tally of its construction.
struct LedgerRun {
  std::string name;  ///< not empty, unique together with the date, neither with '|' nor line breaks
  std::string date{};  ///< informative, may be empty

  friend bool operator==(const LedgerRun&, const LedgerRun&) = default;
};

/// A run's own observation of a weld.
struct LedgerSighting {
  std::size_t run = 0;              ///< index into `WeldLedger::runs`
  double chainage = 0.0;            ///< m, by the run's own odometer
  double standard_deviation = 0.0;  ///< m, of the detection itself

  friend bool operator==(const LedgerSighting&, const LedgerSighting&) = default;
};

struct LedgerWeld {
  std::string id;  ///< unique and permanent
  double chainage = 0.0;
  double standard_deviation = 0.0;  ///< m, of the chainage: grows with the distance from the origin
  double joint_length = std::numeric_limits<double>::quiet_NaN();  ///< to the next; NaN at the last
  double joint_standard_deviation = std::numeric_limits<double>::quiet_NaN();
  std::optional<MapPosition> position;
  std::vector<LedgerSighting> sightings;  ///< at most one per run, by run
};

/// What can be seen again in later runs, or from above the ground.
enum class LandmarkKind : std::uint8_t {
  kMarker = 0,  ///< above the ground, and registered by the tool that passes below
  kValve = 1,
  kTee = 2,
  kBend = 3,  ///< its middle
};
inline constexpr std::array kLandmarkKinds{LandmarkKind::kMarker, LandmarkKind::kValve,
                                           LandmarkKind::kTee, LandmarkKind::kBend};

/// A landmark as one run has it.
struct LandmarkPosition {
  LandmarkKind kind = LandmarkKind::kMarker;
  double chainage = std::numeric_limits<double>::quiet_NaN();  ///< m, by the run's own odometer
  double standard_deviation = std::numeric_limits<double>::quiet_NaN();  ///< m, of seeing it
};

/// Located by the welds around it: it has no part in the alignment, which has its joint lengths.
struct LedgerLandmark {
  std::string id;  ///< unique and permanent
  LandmarkKind kind = LandmarkKind::kMarker;
  double chainage = 0.0;
  double standard_deviation = 0.0;                          ///< m, from the welds around it
  double angle = std::numeric_limits<double>::quiet_NaN();  ///< rad, (0, pi], of a bend; or NaN
  std::optional<MapPosition> position;
  std::vector<LedgerSighting> sightings;  ///< at most one per run, by run
};

struct WeldLedger {
  MapFrame frame = MapFrame::kNone;
  std::vector<LedgerRun> runs;
  std::vector<LedgerWeld> welds;          ///< chainage increases strictly
  std::vector<LedgerLandmark> landmarks;  ///< by chainage
};

/// Confirmation of a weld by runs.
enum class WeldVerdict : std::uint8_t {
  kConfirmed = 0,  ///< detected by two runs or more
  kSingle = 1,     ///< detected by one run, and no other has passed
  kDoubtful = 2,   ///< detected by one run and missed by others: spurious, or new
};

struct WeldEvidence {
  std::size_t seen = 0;
  /// runs whose first and last weld enclose it, including those that detected it
  std::size_t passed = 0;
  WeldVerdict verdict = WeldVerdict::kSingle;
};

struct LedgerParameters {
  WeldAlignmentParameters alignment{};  ///< run against ledger
  double length_noise = 0.01;  ///< m / sqrt(m), random walk of one run's odometer; in (0, 1]
  double scale_sigma = 0.01;   ///< of the scale of each run's odometer; in [0, 0.2]
  /// m, in (0, 10]. An unmatched weld that is nearer than this to one in the ledger is ambiguous
  /// and not added.
  double shortest_joint = 0.3;

  /// Throws std::invalid_argument naming the field, the value and the range.
  void validate() const;
};

struct LedgerUpdate {
  WeldLedger ledger;        ///< unchanged when the run could not be aligned
  WeldAlignment alignment;  ///< of the run (A) against the old ledger (B); kTooFewWelds at first
  bool accepted = false;
  std::size_t added = 0;               ///< new welds
  std::vector<std::size_t> ambiguous;  ///< welds of the run that were neither matched nor added
  std::vector<std::size_t> unusable;   ///< welds of the run with invalid values, see `align_welds`
};

/// The ledger of one run; its ids are W00010, W00020, ... Not accepted with fewer than 3 usable
/// welds. Throws std::invalid_argument when the name or the date is not valid for `LedgerRun`, and
/// what `LedgerParameters::validate` throws.
[[nodiscard]] LedgerUpdate build_ledger(const LedgerRun& run, std::span<const WeldPosition> welds,
                                        const LedgerParameters& parameters = {});

/// Aligns the run to the ledger, adds its detections and its new welds (id of the preceding weld,
/// with ".1", ".2", ...), and adjusts all chainages:
///
/// least squares over the distances between neighbouring sightings of each run, weight 1 over the
/// variance of the two sightings and of the odometer over the distance, with Huber weights for
/// outliers such as slips. Where most runs disagree by more than 3 standard deviations, their
/// standard deviations are inflated to the spread. The equations are tridiagonal if every run
/// detected every weld; each missed weld widens the band. The scale of each run is estimated; the
/// ledger's scale is the mean of the runs' scales. The first weld of the first run keeps its
/// chainage. Detections are treated as independent between joints, which slightly overestimates the
/// uncertainty of long distances. Welds detected by one run only stay in its order. Landmarks go
/// with the welds around them (`add_landmarks` adds those of this run). Map positions
/// are removed: apply the centre line again.
///
/// Throws what `build_ledger` throws, and std::invalid_argument when the ledger has that run.
[[nodiscard]] LedgerUpdate merge_run(const WeldLedger& ledger, const LedgerRun& run,
                                     std::span<const WeldPosition> welds,
                                     const LedgerParameters& parameters = {});

/// The ledger with the landmarks that a run of it saw: each is the nearest of its kind that this
/// run has not seen yet and that is not farther than 4 standard deviations of the distance, or a
/// new one (ids M00010, V00010, T00010, B00010, ... by kind). The position of a landmark is the
/// mean over its sightings, each mapped between the welds of its run, by their information.
/// Landmarks whose values are not usable are passed over. Throws std::out_of_range when there is no
/// such run, and what `LedgerParameters::validate` throws.
[[nodiscard]] WeldLedger add_landmarks(WeldLedger ledger, std::size_t run,
                                       std::span<const LandmarkPosition> landmarks,
                                       const LedgerParameters& parameters = {});

/// The ledger's welds in the form of a run, to which `merge_run` aligns: the standard deviation is
/// that of the position from its detections, without the accumulated error of the distance.
[[nodiscard]] std::vector<WeldPosition> weld_positions(const WeldLedger& ledger);

/// Entry k is that of weld k.
[[nodiscard]] std::vector<WeldEvidence> evidence(const WeldLedger& ledger);

/// The ledger with a map position for every weld and landmark on the line.
[[nodiscard]] WeldLedger lay_along(WeldLedger ledger, const CentreLine& line);

/// Map from the odometer of a run to the ledger, by the welds that the run detected; without knots
/// when there are none. Throws std::out_of_range when there is no such run.
[[nodiscard]] ChainageMap run_to_ledger(const WeldLedger& ledger, std::size_t run,
                                        const LedgerParameters& parameters = {});

/// Position of a finding in the ledger.
struct LedgerPlace {
  double chainage = std::numeric_limits<double>::quiet_NaN();
  double standard_deviation = std::numeric_limits<double>::quiet_NaN();  ///< of the chainage
  std::string weld;  ///< id of the preceding weld; empty before the first
  double from_weld = std::numeric_limits<double>::quiet_NaN();  ///< m, beyond that weld
  double from_weld_standard_deviation = std::numeric_limits<double>::quiet_NaN();
  std::optional<MapPosition> position;  ///< if the welds on both sides have one
};

/// `place` from `run_to_ledger(...).map(chainage)`. All NaN and empty for NaN.
[[nodiscard]] LedgerPlace locate(const WeldLedger& ledger, const MappedChainage& place);

/// "marker", "valve", "tee", "bend"; "unknown" for any other value.
[[nodiscard]] const char* to_string(LandmarkKind kind) noexcept;

/// For messages: "confirmed", "single", "doubtful"; "unknown" for any other value.
[[nodiscard]] const char* to_string(WeldVerdict verdict) noexcept;

}  // namespace pipescout::odometry
