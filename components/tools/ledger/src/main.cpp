// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <filesystem>
#include <functional>
#include <iostream>
#include <map>
#include <memory>
#include <stdexcept>
#include <system_error>
#include <utility>
#include <vector>

#include "ledger_report.hpp"
#include "pipescout/command_line/command.hpp"
#include "pipescout/command_line/results.hpp"
#include "pipescout/csv/csv_words.hpp"
#include "pipescout/csv/utf8.hpp"
#include "pipescout/files/whole_file.hpp"
#include "pipescout/statistics/median.hpp"
#include "pipescout/validation/number_text.hpp"
#include "pipescout/weld_ledger/weld_ledger_text.hpp"
#include "run_file.hpp"

namespace pipescout::ledger {
namespace {

using command_line::Action;
using command_line::CommandError;
using command_line::kExitOk;
using odometry::LedgerParameters;
using odometry::LedgerRun;
using odometry::LedgerUpdate;
using odometry::MapFrame;
using odometry::MapPosition;
using odometry::SurveyedPoint;
using odometry::WeldLedger;

/// Rows of a table on the terminal; files hold all.
constexpr std::size_t kRowsShown = 40;

struct Options {
  std::string run;
  std::string ledger;
  std::string columns;
  std::string name;
  std::string date;
  std::string survey;
  std::string out;
  std::string geojson;
  std::string features;
  std::string report;
  std::string json;
  CsvFormat format{.settings = "--"};  // of files without --columns
};

void tell(const std::vector<std::string>& notes) {
  for (const std::string& note : notes) {
    std::cerr << "note: " << note << '\n';
  }
}

RunFile read_run_of(const Options& options) {
  RunFile run = options.columns.empty()
                    ? read_run(options.run, options.format)
                    : read_run(options.run, load_column_mapping(options.columns));
  tell(run.notes);
  return run;
}

WeldLedger read_ledger_of(const Options& options) {
  LedgerFile file = read_ledger(options.ledger, options.format);
  tell(file.notes);
  return std::move(file.ledger);
}

LedgerRun run_of(const Options& options) {
  // Headers have no runs of blanks.
  LedgerRun run{
      .name = folded(options.name.empty() ? std::filesystem::path(options.run).stem().string()
                                          : options.name),
      .date = folded(options.date)};
  for (const std::string& text : {run.name, run.date}) {
    if (first_byte_not_utf8(text) != std::string_view::npos) {
      throw CommandError("the name or the date of the run, '" + text +
                         "', is not UTF-8: give others with --name and --date");
    }
  }
  return run;
}

LedgerParameters parameters_of(const RunFile& run) {
  LedgerParameters parameters;
  parameters.length_noise = run.length_noise;
  parameters.alignment.length_noise = run.length_noise;
  // A crawler may have been driven from the other end, and the file does not say.
  parameters.alignment.direction = odometry::AlignmentDirection::kEither;
  return parameters;
}

/// Lays the ledger along the welds whose position is known: these keep it.
void lay_along_welds(WeldLedger& ledger, MapFrame frame,
                     const std::vector<std::optional<MapPosition>>& known) {
  std::vector<SurveyedPoint> points;
  for (std::size_t k = 0; k < known.size(); ++k) {
    // A line has no length where two welds share a position.
    if (known[k] && (points.empty() || map_distance(frame, points.back().position.coordinates,
                                                    known[k]->coordinates) > 0.0)) {
      points.push_back({.position = *known[k], .chainage = ledger.welds[k].chainage});
    }
  }
  if (points.size() >= 2) {
    ledger = lay_along(std::move(ledger), odometry::CentreLine(frame, std::move(points)));
  }
}

/// Positions by the list of the run, if it has any, for the welds that it saw.
void lay_along_run(WeldLedger& ledger, std::size_t run, const RunFile& file) {
  std::map<double, MapPosition> by_chainage;
  for (std::size_t k = 0; k < file.welds.size(); ++k) {
    if (file.positions[k]) {
      by_chainage.emplace(file.welds[k].chainage, *file.positions[k]);
    }
  }
  std::vector<std::optional<MapPosition>> known(ledger.welds.size());
  for (std::size_t k = 0; k < known.size(); ++k) {
    for (const auto& sighting : ledger.welds[k].sightings) {
      const auto found = by_chainage.find(sighting.chainage);
      if (sighting.run == run && found != by_chainage.end()) {
        known[k] = found->second;
      }
    }
  }
  lay_along_welds(ledger, MapFrame::kGeodetic, known);
}

/// The new ledger gets the map of the old one.
void keep_map(WeldLedger& ledger, const WeldLedger& old) {
  std::map<std::string, MapPosition> by_id;
  for (const auto& weld : old.welds) {
    if (weld.position) {
      by_id.emplace(weld.id, *weld.position);
    }
  }
  std::vector<std::optional<MapPosition>> known(ledger.welds.size());
  for (std::size_t k = 0; k < known.size(); ++k) {
    if (const auto found = by_id.find(ledger.welds[k].id); found != by_id.end()) {
      known[k] = found->second;
    }
  }
  lay_along_welds(ledger, old.frame, known);
}

void write_geojson(const std::string& path, const WeldLedger& ledger) {
  replace_file(path, to_geojson(ledger));
  if (ledger.frame != MapFrame::kGeodetic) {
    std::cerr << "note: " << path
              << " has no positions: the ledger has no latitude and longitude\n";
  }
}

/// A ledger of the run, with the ids and the map of a tally.
WeldLedger ledger_of(const RunFile& run, const Options& options) {
  const bool is_tally = run.ledger && run.ledger->runs == std::vector{LedgerRun{.name = "tally"}};
  if (run.ledger && !is_tally) {
    if (!options.name.empty() || !options.date.empty()) {
      throw CommandError(options.run +
                         " is a ledger that names its runs: --name and --date are for one run");
    }
    return *run.ledger;
  }
  LedgerUpdate update = build_ledger(run_of(options), run.welds, parameters_of(run));
  if (!update.accepted) {
    throw CommandError(options.run + ": " + std::to_string(run.welds.size()) +
                       " girth welds are too few for a ledger, which takes 3");
  }
  if (is_tally) {
    for (std::size_t k = 0; k < update.ledger.welds.size(); ++k) {
      update.ledger.welds[k].id = run.ledger->welds[k].id;
      update.ledger.welds[k].position = run.ledger->welds[k].position;
    }
    update.ledger.frame = run.ledger->frame;
    update.ledger.landmarks = run.ledger->landmarks;
  } else {
    update.ledger = add_landmarks(std::move(update.ledger), 0, run.landmarks, parameters_of(run));
    lay_along_run(update.ledger, 0, run);
  }
  return update.ledger;
}

bool same_file(const std::string& one, const std::string& other) {
  std::error_code ignored;
  return !one.empty() && !other.empty() &&
         std::filesystem::weakly_canonical(std::filesystem::absolute(one), ignored) ==
             std::filesystem::weakly_canonical(std::filesystem::absolute(other), ignored);
}

int build(const Options& options) {
  command_line::require_new_file(options.out);
  command_line::require_new_file(options.geojson);
  const RunFile run = read_run_of(options);
  WeldLedger ledger = ledger_of(run, options);
  if (!options.survey.empty()) {
    const SurveyFile survey = read_survey(options.survey, options.format);
    tell(survey.notes);
    ledger = lay_along(std::move(ledger), survey.line);
  }
  replace_file(options.out, to_csv(ledger));
  if (!options.geojson.empty()) {
    write_geojson(options.geojson, ledger);
  }
  print_ledger(std::cout, ledger);
  return kExitOk;
}

/// The joint half of which are shorter, to tell feet from metres and one pipe from another.
std::string middle_joint(const std::vector<odometry::WeldPosition>& welds) {
  std::vector<double> joints;
  for (std::size_t k = 1; k < welds.size(); ++k) {
    joints.push_back(welds[k].chainage - welds[k - 1].chainage);
  }
  if (joints.empty()) {
    return "no joints";
  }
  return std::to_string(joints.size()) + " joints, the middle one of " +
         validation::fixed_text(statistics::median_in_place(joints), 2) + " m";
}

[[noreturn]] void refuse_alignment(const Options& options, const RunFile& run,
                                   const WeldLedger& ledger, odometry::AlignmentStatus status) {
  const std::string why =
      status == odometry::AlignmentStatus::kTooFewWelds
          ? "each needs 3 girth welds"
          : "their joint lengths agree nowhere better than by chance. Is it the same pipe, are "
            "there enough welds, is the unit of the distances right?";
  throw CommandError(options.run + " cannot be aligned to " + options.ledger + ": " + why + "\n  " +
                     options.run + ": " + middle_joint(run.welds) + "\n  " + options.ledger + ": " +
                     middle_joint(weld_positions(ledger)));
}

int align(const Options& options) {
  for (const std::string& result : {options.features, options.report, options.json}) {
    command_line::require_new_file(result);
  }
  // A ledger grows run by run.
  if (!same_file(options.out, options.ledger)) {
    command_line::require_new_file(options.out);
  }
  const RunFile run = read_run_of(options);
  const WeldLedger ledger = read_ledger_of(options);
  LedgerRun name = run_of(options);
  const auto is_taken = [&] {
    return std::find(ledger.runs.begin(), ledger.runs.end(), name) != ledger.runs.end();
  };
  if (is_taken() && !options.out.empty()) {
    throw CommandError(options.ledger + " has the run '" + name.name + "' of '" + name.date +
                       "' already; another one needs another --name or --date");
  }
  while (is_taken()) {
    name.name += '+';  // not kept: a run may be laid against a ledger that it is part of
  }
  LedgerUpdate update = merge_run(ledger, name, run.welds, parameters_of(run));
  if (!update.accepted) {
    refuse_alignment(options, run, ledger, update.alignment.status);
  }
  update.ledger = add_landmarks(std::move(update.ledger), update.ledger.runs.size() - 1,
                                run.landmarks, parameters_of(run));
  if (ledger.frame != MapFrame::kNone) {
    keep_map(update.ledger, ledger);
  } else {
    lay_along_run(update.ledger, update.ledger.runs.size() - 1, run);
  }
  const AlignmentReport report(run, ledger, update);
  const std::vector<std::pair<std::string, std::function<std::string()>>> files{
      {options.report, [&] { return report.matches_csv(); }},
      {options.features, [&] { return report.features_csv(); }},
      // Names of files may be no UTF-8.
      {options.json,
       [&] {
         return report.to_json().dump(2, ' ', false, nlohmann::json::error_handler_t::replace) +
                "\n";
       }},
      {options.out, [&] { return to_csv(update.ledger); }}};
  for (const auto& [path, content] : files) {
    if (!path.empty()) {
      replace_file(path, content());
    }
  }
  report.print(std::cout, kRowsShown, options.features.empty());
  return kExitOk;
}

int show(const Options& options) {
  command_line::require_new_file(options.geojson);
  const WeldLedger ledger = read_ledger_of(options);
  if (!options.geojson.empty()) {
    write_geojson(options.geojson, ledger);
  }
  print_ledger(std::cout, ledger);
  return kExitOk;
}

/// What the header of a ledger can hold.
CLI::Validator header_text() {
  return {[](const std::string& text) {
            const bool fits = std::none_of(text.begin(), text.end(), [](char c) {
              return c == '|' || static_cast<unsigned char>(c) < 0x20U;
            });
            return fits && !text.empty()
                       ? std::string()
                       : "'" + text + "' is empty or holds '|' or control characters";
          },
          ""};
}

void add_format_options(CLI::App& command, Options& options) {
  for (const char* key : {"delimiter", "decimal_mark"}) {
    std::string option = std::string("--") + key;
    std::ranges::replace(option, '_', '-');
    command.add_option_function<std::string>(
        option,
        [key, &options](const std::string& word) {
          try {
            options.format.set(key, word);
          } catch (const std::invalid_argument& error) {
            throw CLI::ValidationError(error.what());
          }
        },
        std::string(key == std::string("delimiter") ? "Between columns: ',', ';', '|', tab or blank"
                                                    : "Of numbers: '.' or ','") +
            ", of files without --columns; recognised without it");
  }
}

void add_run_options(CLI::App& command, Options& options) {
  command.add_option("run", options.run, "List of the run's girth welds and features, or a tally")
      ->required();
  command.add_option("--columns", options.columns,
                     "YAML file that maps the columns of the list; not needed for a ledger or a "
                     "tally in the ledger's format");
  command.add_option("--name", options.name, "Name of the run; default: name of the file")
      ->check(header_text());
  command.add_option("--date", options.date, "Date of the run, informative")->check(header_text());
  add_format_options(command, options);
}

/// Two results in one file would leave the last of them, and one in place of an input would leave
/// nothing to look up when in doubt. Only the ledger may be replaced by the one that follows it.
void check_files(const std::vector<std::string>& inputs, const std::vector<std::string>& outputs) {
  for (std::size_t k = 0; k < outputs.size(); ++k) {
    const auto is_this = [&](const std::string& file) { return same_file(file, outputs[k]); };
    if (std::any_of(inputs.begin(), inputs.end(), is_this)) {
      throw CLI::ValidationError(outputs[k] + " is read and would be overwritten");
    }
    if (std::any_of(outputs.begin(), outputs.begin() + static_cast<std::ptrdiff_t>(k), is_this)) {
      throw CLI::ValidationError("two results cannot go to one file, " + outputs[k]);
    }
  }
}

void add_commands(CLI::App& app, Action& action) {
  app.require_subcommand(1);
  auto options = std::make_shared<Options>();

  auto* build_command = app.add_subcommand("build", "Make a ledger of one run or a tally");
  add_run_options(*build_command, *options);
  build_command->add_option("--survey", options->survey, "Surveyed points along the pipe, CSV");
  build_command->add_option("--out", options->out, "The ledger, CSV")->required();
  build_command->add_option("--geojson", options->geojson, "Write the ledger as a map too");
  build_command->callback([=, &action] {
    check_files({options->run, options->columns, options->survey},
                {options->out, options->geojson});
    action = [=] { return build(*options); };
  });

  auto* align_command = app.add_subcommand(
      "align",
      "Align the welds of a run with a ledger by their joint lengths, and locate its features");
  add_run_options(*align_command, *options);
  align_command->add_option("ledger", options->ledger, "The ledger, CSV")->required();
  align_command->add_option("--out", options->out, "The ledger with this run in it, CSV");
  align_command->add_option("--features", options->features,
                            "The run's features with their positions in LEDGER, CSV");
  align_command->add_option("--report", options->report, "The matched welds, CSV");
  align_command->add_option("--json", options->json, "The figures of the summary");
  align_command->callback([=, &action] {
    check_files({options->run, options->columns},
                {options->out, options->features, options->report, options->json});
    check_files({options->ledger}, {options->features, options->report, options->json});
    action = [=] { return align(*options); };
  });

  auto* show_command = app.add_subcommand("show", "Print the content of a ledger");
  show_command->add_option("ledger", options->ledger, "The ledger, CSV")->required();
  add_format_options(*show_command, *options);
  show_command->add_option("--geojson", options->geojson, "Write the ledger as a map too");
  show_command->callback([=, &action] {
    check_files({options->ledger}, {options->geojson});
    action = [=] { return show(*options); };
  });
}

}  // namespace
}  // namespace pipescout::ledger

int main(int argc, char** argv) {
  return pipescout::command_line::command_main(PIPESCOUT_SUMMARY, "pipescout ledger",
                                               pipescout::ledger::add_commands, argc, argv);
}
