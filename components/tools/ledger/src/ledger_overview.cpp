// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>

#include "ledger_report.hpp"
#include "pipescout/command_line/text_table.hpp"
#include "pipescout/validation/number_text.hpp"
#include "report_text.hpp"

namespace pipescout::ledger {
namespace {

using odometry::LedgerWeld;
using odometry::MapFrame;
using odometry::WeldLedger;
using odometry::WeldVerdict;

void print_runs(std::ostream& out, const WeldLedger& ledger) {
  TextTable table({"run", "date", "welds", "not seen", "first at m", "last at m", "scale"});
  for (std::size_t run = 0; run < ledger.runs.size(); ++run) {
    const auto knots = run_to_ledger(ledger, run);
    const auto welds = knots.knots();
    if (welds.empty()) {
      table.add_row(
          {ledger.runs[run].name, text(ledger.runs[run].date), number(0), {}, {}, {}, {}});
      continue;
    }
    const auto [from, to] = std::minmax(welds.front().to, welds.back().to);
    const auto passed = std::count_if(
        ledger.welds.begin(), ledger.welds.end(),
        [&](const LedgerWeld& weld) { return weld.chainage >= from && weld.chainage <= to; });
    const double length = welds.back().from - welds.front().from;
    const double scale = length > 0.0 ? (welds.back().to - welds.front().to) / length : 1.0;
    table.add_row({ledger.runs[run].name, text(ledger.runs[run].date), number(welds.size()),
                   number(static_cast<std::size_t>(passed) - welds.size()), metres(from),
                   metres(to), std::round(scale * 1e6) / 1e6});
  }
  table.print(out, "  ");
}

}  // namespace

void print_ledger(std::ostream& out, const WeldLedger& ledger) {
  if (ledger.welds.empty()) {
    out << "A ledger of no welds\n";
    return;
  }
  const auto& first = ledger.welds.front();
  const auto& last = ledger.welds.back();
  const auto believed = evidence(ledger);
  const auto count = [&](WeldVerdict verdict) {
    return static_cast<std::size_t>(
        std::count_if(believed.begin(), believed.end(),
                      [=](const auto& weld) { return weld.verdict == verdict; }));
  };
  const auto mapped = static_cast<std::size_t>(
      std::count_if(ledger.welds.begin(), ledger.welds.end(),
                    [](const auto& weld) { return weld.position.has_value(); }));
  out << "A ledger of " << of(ledger.welds.size(), "girth weld") << ", " << first.id << " at "
      << validation::fixed_text(first.chainage, 3) << " m to " << last.id << " at "
      << validation::fixed_text(last.chainage, 3) << " +- "
      << validation::fixed_text(last.standard_deviation, 3) << " m\n";
  out << "  confirmed  " << count(WeldVerdict::kConfirmed) << " detected by two runs or more\n";
  out << "  single     " << count(WeldVerdict::kSingle)
      << " detected by one run, and no other has passed\n";
  out << "  doubtful   " << count(WeldVerdict::kDoubtful)
      << " detected by one run and missed by others\n";
  out << "  map        "
      << (mapped == 0 ? "none"
                      : std::to_string(mapped) + " welds, " +
                            (ledger.frame == MapFrame::kGeodetic ? "latitude and longitude"
                                                                 : "local coordinates"))
      << '\n';
  if (!ledger.landmarks.empty()) {
    out << "  landmarks  ";
    const char* separator = "";
    for (const odometry::LandmarkKind kind : odometry::kLandmarkKinds) {
      const auto of_kind = static_cast<std::size_t>(
          std::ranges::count(ledger.landmarks, kind, &odometry::LedgerLandmark::kind));
      if (of_kind > 0) {
        out << separator << of(of_kind, to_string(kind));
        separator = ", ";
      }
    }
    out << '\n';
  }
  out << "\nRuns (scale: metres of the ledger per metre of the run's odometer)\n";
  print_runs(out, ledger);
  if (count(WeldVerdict::kDoubtful) == 0) {
    return;
  }
  out << "\nDoubtful welds\n";
  TextTable table({"weld", "at m", "+- m", "joint m", "seen by", "runs that passed"});
  for (std::size_t k = 0; k < ledger.welds.size(); ++k) {
    const auto& weld = ledger.welds[k];
    if (believed[k].verdict == WeldVerdict::kDoubtful) {
      table.add_row({weld.id, metres(weld.chainage), metres(weld.standard_deviation),
                     metres(weld.joint_length),
                     weld.sightings.empty() ? TextTable::Cell()
                                            : ledger.runs[weld.sightings.front().run].name,
                     number(believed[k].passed)});
    }
  }
  table.print(out, "  ");
}

}  // namespace pipescout::ledger
