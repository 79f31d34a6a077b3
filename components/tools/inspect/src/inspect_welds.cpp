// SPDX-License-Identifier: Apache-2.0
#include "inspect_welds.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <filesystem>
#include <iostream>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "pipescout/bags/topic_choice.hpp"
#include "pipescout/command_line/results.hpp"
#include "pipescout/command_line/text_table.hpp"
#include "pipescout/csv/csv_cell.hpp"
#include "pipescout/files/whole_file.hpp"
#include "weld_signal.hpp"

namespace pipescout::inspect {
namespace {

using command_line::kExitError;
using command_line::kExitOk;
using command_line::TextTable;
using odometry::WeldDetector;
using odometry::WeldDetectorCounts;
using odometry::WeldEvent;

constexpr std::size_t kWeldsShown = 40;  // the file has all

struct WeldArguments {
  std::string signal;
  std::string out;
  std::string columns;
  std::string topic;
  std::string odometer_topic;
  odometry::WeldDetectorParameters detector;
};

bool is_table(const std::string& path) {
  return std::filesystem::is_regular_file(path) && !bags::storage_by_name(path);
}

/// A list that `pipescout ledger` reads as it is.
std::string welds_csv(const std::vector<WeldEvent>& welds) {
  std::string text =
      "Log distance [m],Feature type,standard_deviation_m,confidence,amplitude,width_m,phase_rad,"
      "strength,match\n";
  for (const WeldEvent& weld : welds) {
    text += format_csv_number(weld.distance) + ",Weld";
    for (const double value : {weld.standard_deviation, weld.confidence, weld.amplitude, weld.width,
                               weld.phase, weld.strength, weld.match}) {
      text += ',' + format_csv_number(value);
    }
    text += '\n';
  }
  return text;
}

/// To the decimetre: "12.5".
std::string metres_text(double value) {
  return format_csv_number(std::round(value * 10.0) / 10.0);
}

TextTable::Cell rounded(double value) {
  return std::round(value * 1000.0) / 1000.0;
}

void print_welds(const std::vector<WeldEvent>& welds) {
  TextTable table({"weld", "at m", "+- m", "joint m", "confidence", "width m"});
  for (std::size_t k = 0; k < std::min(welds.size(), kWeldsShown); ++k) {
    table.add_row({static_cast<std::int64_t>(k + 1), rounded(welds[k].distance),
                   rounded(welds[k].standard_deviation),
                   k == 0 ? TextTable::Cell() : rounded(welds[k].distance - welds[k - 1].distance),
                   rounded(welds[k].confidence), rounded(welds[k].width)});
  }
  table.print(std::cout, "  ");
  if (welds.size() > kWeldsShown) {
    std::cout << "  ... and " << welds.size() - kWeldsShown << " more\n";
  }
}

/// Why there may be fewer welds than the pipe has: of the samples and of the peaks.
void print_counts(const WeldDetectorCounts& counts) {
  const auto tell = [](std::uint64_t count, const char* what) {
    if (count > 0) {
      std::cout << "  " << count << ' ' << what << '\n';
    }
  };
  tell(counts.bad_distances + counts.bad_values, "samples without a value");
  tell(counts.frozen, "samples of a frozen signal");
  tell(counts.spikes, "spikes in single samples");
  tell(counts.outliers, "samples at a distance that was not confirmed");
  tell(counts.gaps, "gaps of the signal");
  tell(counts.too_narrow + counts.too_wide, "peaks of another width than a weld's");
  tell(counts.wrong_shape + counts.wrong_phase + counts.crowded,
       "peaks of another shape than a weld's");
  tell(counts.incomplete, "peaks with a gap in them");
}

int inspect_welds(const WeldArguments& arguments) {
  command_line::require_new_file(arguments.out);
  std::optional<WeldDetector> detector;
  std::vector<WeldEvent> welds;
  double first = 0.0;
  double last = 0.0;
  const SignalSink sink{.begin =
                            [&](std::size_t channels) {
                              odometry::WeldDetectorParameters parameters = arguments.detector;
                              parameters.channels = channels;
                              detector.emplace(parameters);
                            },
                        .sample =
                            [&](double distance, std::span<const odometry::Impedance> channels) {
                              if (detector->counts().samples == 0) {
                                first = distance;
                              }
                              last = distance;
                              const auto found = detector->update(distance, channels);
                              welds.insert(welds.end(), found.begin(), found.end());
                            }};
  BagRemainder remainder;
  if (is_table(arguments.signal)) {
    const SignalColumns columns =
        arguments.columns.empty() ? SignalColumns{} : load_signal_columns(arguments.columns);
    for (const std::string& note : read_signal_table(arguments.signal, columns, sink)) {
      std::cerr << "note: " << note << '\n';
    }
  } else {
    if (!arguments.columns.empty()) {
      throw command_line::CommandError(arguments.signal +
                                       " is a bag, which has no columns: --columns is for CSV");
    }
    remainder = read_signal_bag(arguments.signal, arguments.topic, arguments.odometer_topic, sink);
  }
  const auto found = detector->finish();
  welds.insert(welds.end(), found.begin(), found.end());
  std::sort(welds.begin(), welds.end(), [](const WeldEvent& one, const WeldEvent& next) {
    return one.distance < next.distance;
  });
  if (!arguments.out.empty()) {
    replace_file(arguments.out, welds_csv(welds));
  }
  std::cout << arguments.signal << ": " << detector->counts().samples << " samples, "
            << metres_text(first) << " to " << metres_text(last) << " m, " << welds.size()
            << (welds.size() == 1 ? " weld" : " welds") << '\n';
  print_counts(detector->counts());
  if (remainder.passed_over > 0) {
    std::cout << "  " << remainder.passed_over
              << " samples before the first or after the last distance\n";
  }
  if (!welds.empty()) {
    print_welds(welds);
  }
  if (!remainder.damage.empty()) {
    std::cerr << arguments.signal << " cannot be read to its end: " << remainder.damage << '\n';
    return kExitError;
  }
  return kExitOk;
}

}  // namespace

void add_welds_command(CLI::App& app, command_line::Action& action) {
  auto arguments = std::make_shared<WeldArguments>();
  auto* welds = app.add_subcommand(
      "welds", "Detect girth welds in the signal of an eddy-current probe, a CSV file or a bag");
  welds
      ->add_option("signal", arguments->signal,
                   "CSV with the columns distance_m, x, y (of several coils x1, y1, x2, y2, ...), "
                   "or others with --columns; or a bag with the probe's samples and the fused "
                   "distance")
      ->required()
      ->check(CLI::ExistingPath);
  welds->add_option("--out", arguments->out, "The welds, CSV; `pipescout ledger` reads it");
  welds->add_option("--columns", arguments->columns, "Names of the columns, YAML")
      ->check(CLI::ExistingFile);
  welds->add_option("--topic", arguments->topic, "Topic of the samples, of a bag with several");
  welds->add_option("--odometer-topic", arguments->odometer_topic,
                    "Topic of the fused distance, of a bag with several");
  welds->add_option("--smallest-width", arguments->detector.smallest_width,
                    "m, between the two lobes of a weld's pulse, at least; default 0.025");
  welds->add_option("--largest-width", arguments->detector.largest_width,
                    "m, the same, at most; default 0.06");
  welds->add_option("--false-alarms-per-km", arguments->detector.false_alarms_per_km,
                    "Expected number by noise; sets the threshold; default 0.05");
  welds->callback([=, &action] { action = [=] { return inspect_welds(*arguments); }; });
}

}  // namespace pipescout::inspect
