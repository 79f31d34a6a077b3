// SPDX-License-Identifier: Apache-2.0
#pragma once

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

/// The weld ledger of a pipe: what all runs so far know about its girth welds. Each run refines it,
/// and a finding inside the pipe gets a place that is found again years later.
///
/// A plain value; every function is pure. Distances and standard deviations in metres.
namespace pipescout::odometry {

/// One run through the pipe, or the tally of its construction.
struct LedgerRun {
  std::string name;  ///< not empty, unique together with the date, neither with '|' nor line breaks
  std::string date{};  ///< for people, may be empty

  friend bool operator==(const LedgerRun&, const LedgerRun&) = default;
};

/// A run's own observation of a weld.
struct LedgerSighting {
  std::size_t run = 0;              ///< index into `WeldLedger::runs`
  double chainage = 0.0;            ///< m, by the run's own odometer
  double standard_deviation = 0.0;  ///< m, of the sighting itself

  friend bool operator==(const LedgerSighting&, const LedgerSighting&) = default;
};

struct LedgerWeld {
  std::string id;  ///< unique; stays with the weld for good
  double chainage = 0.0;
  double standard_deviation = 0.0;  ///< m, of the chainage: grows with the distance from the origin
  double joint_length = std::numeric_limits<double>::quiet_NaN();  ///< to the next; NaN at the last
  double joint_standard_deviation = std::numeric_limits<double>::quiet_NaN();
  std::optional<MapPosition> position;
  std::vector<LedgerSighting> sightings;  ///< at most one per run, by run
};

struct WeldLedger {
  MapFrame frame = MapFrame::kNone;
  std::vector<LedgerRun> runs;
  std::vector<LedgerWeld> welds;  ///< chainage rises strictly
};

/// How far a weld is to be believed.
enum class WeldVerdict : std::uint8_t {
  kConfirmed = 0,  ///< two runs or more saw it
  kSingle = 1,     ///< one run saw it and no other has passed
  kDoubtful = 2,   ///< one run saw it, others passed and did not: spurious, or new
};

struct WeldEvidence {
  std::size_t seen = 0;
  std::size_t passed =
      0;  ///< runs between whose first and last weld it lies, those that saw it too
  WeldVerdict verdict = WeldVerdict::kSingle;
};

struct LedgerParameters {
  WeldAlignmentParameters alignment{};  ///< run against ledger
  double length_noise = 0.01;  ///< m / sqrt(m), random walk of one run's odometer; in (0, 1]
  double scale_sigma = 0.01;   ///< of the scale of each run's odometer; in [0, 0.2]
  /// m, in (0, 10]. A weld that no other is matched with but that lies nearer than this to one in
  /// the ledger is not added: which of the two it is, is open.
  double shortest_joint = 0.3;

  /// Throws std::invalid_argument naming the field, the value and the range.
  void validate() const;
};

struct LedgerUpdate {
  WeldLedger ledger;        ///< unchanged when the run could not be aligned
  WeldAlignment alignment;  ///< of the run (A) against the old ledger (B); kTooFewWelds at first
  bool accepted = false;
  std::size_t added = 0;               ///< welds that the ledger did not have
  std::vector<std::size_t> ambiguous;  ///< welds of the run that were neither matched nor added
  std::vector<std::size_t> unusable;   ///< welds of the run with bad values, see `align_welds`
};

/// The ledger of one run; its ids are W00010, W00020, ... Not accepted with fewer than 3 usable
/// welds. Throws std::invalid_argument when the name or the date is not as `LedgerRun` says, and
/// what `LedgerParameters::validate` throws.
[[nodiscard]] LedgerUpdate build_ledger(const LedgerRun& run, std::span<const WeldPosition> welds,
                                        const LedgerParameters& parameters = {});

/// Aligns the run to the ledger, adds its sightings and the welds that it alone saw (id of the weld
/// before, with ".1", ".2", ...), and adjusts all chainages:
///
/// least squares over the distances between neighbouring sightings of each run, weight 1 over the
/// variance of the two sightings and of the odometer over the distance, reduced for what departs
/// from the others (Huber's weights: a slip counts little). Where most runs disagree by more than 3
/// standard deviations, each is taken to be as uncertain as they are apart. Runs that saw every
/// weld make the equations tridiagonal; each missed weld widens the band. The scale of each run is
/// estimated; the ledger's metre is the mean of the runs' metres. The first weld of the first run
/// keeps its chainage. Sightings are taken as independent between joints, which overstates the
/// uncertainty of long distances a little. Welds that one run saw stay in the order in which it saw
/// them.
/// Map positions are dropped: lay the centre line again.
///
/// Throws what `build_ledger` throws, and std::invalid_argument when the ledger has that run.
[[nodiscard]] LedgerUpdate merge_run(const WeldLedger& ledger, const LedgerRun& run,
                                     std::span<const WeldPosition> welds,
                                     const LedgerParameters& parameters = {});

/// The ledger's welds as a run would have them, which is what `merge_run` aligns to: the standard
/// deviation is that of the place by its sightings, without the way to it.
[[nodiscard]] std::vector<WeldPosition> weld_positions(const WeldLedger& ledger);

/// Entry k is that of weld k.
[[nodiscard]] std::vector<WeldEvidence> evidence(const WeldLedger& ledger);

/// The ledger with a map position for every weld on the line.
[[nodiscard]] WeldLedger lay_along(WeldLedger ledger, const CentreLine& line);

/// From the odometer of a run to the ledger, by the welds that the run saw; of no knots when there
/// are none. Throws std::out_of_range when there is no such run.
[[nodiscard]] ChainageMap run_to_ledger(const WeldLedger& ledger, std::size_t run,
                                        const LedgerParameters& parameters = {});

/// Where in the ledger a finding lies.
struct LedgerPlace {
  double chainage = std::numeric_limits<double>::quiet_NaN();
  double standard_deviation = std::numeric_limits<double>::quiet_NaN();  ///< of the chainage
  std::string weld;  ///< id of the weld before it; empty before the first
  double from_weld = std::numeric_limits<double>::quiet_NaN();  ///< m, beyond that weld
  double from_weld_standard_deviation = std::numeric_limits<double>::quiet_NaN();
  std::optional<MapPosition> position;  ///< when the welds on both sides have one
};

/// `place` as `run_to_ledger(...).map(chainage)` gives it. All NaN and empty for NaN.
[[nodiscard]] LedgerPlace locate(const WeldLedger& ledger, const MappedChainage& place);

/// For people: "confirmed", "single", "doubtful"; "unknown" for a value that is no enumerator.
[[nodiscard]] const char* to_string(WeldVerdict verdict) noexcept;

}  // namespace pipescout::odometry
