// SPDX-License-Identifier: Apache-2.0
// `pipescout ledger`, on small files made here and on two real inspection runs.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <map>
#include <nlohmann/json.hpp>
#include <random>
#include <string_view>

#include "pipescout/csv/csv_table.hpp"
#include "pipescout/csv/testing/german_excel.hpp"
#include "pipescout/files/testing/temporary_folder.hpp"
#include "pipescout/odometry/weld_ledger.hpp"
#include "pipescout/testing/program.hpp"
#include "pipescout/weld_ledger/weld_ledger_text.hpp"

namespace pipescout::ledger {
namespace {

using ::pipescout::testing::content;
using ::pipescout::testing::Finished;
using ::pipescout::testing::run_program;
using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::StartsWith;
namespace fs = std::filesystem;

constexpr double kFoot = 0.3048;  // m
constexpr std::size_t kWelds = 41;

/// A CSV file as rows by column.
std::vector<std::map<std::string, std::string>> table(const fs::path& path) {
  const std::string bytes = content(path);
  CsvReader reader(bytes, path.string());
  std::vector<std::map<std::string, std::string>> rows;
  while (reader.next()) {
    auto& cells = rows.emplace_back();
    for (std::size_t column = 0; column < reader.columns().size(); ++column) {
      cells[reader.columns()[column]] = reader.cells()[column];
    }
  }
  return rows;
}

/// A pipe of 40 joints, 4 to 16 m, and the lists of two runs through it: in feet with features, and
/// by another odometer.
class LedgerCommand : public ::testing::Test {
 protected:
  LedgerCommand() {
    std::mt19937_64 engine(7);
    pipe_ = {100.0};
    while (pipe_.size() < kWelds) {
      pipe_.push_back(pipe_.back() + 4.0 + static_cast<double>(engine() % 12000) / 1000.0);
    }
    write("m.yaml",
          "distance: log [ft]\nunit: feet\nkind: event\ngirth_weld: Girth Weld\nclock: o'clock\n");
    std::string first = "joint,event,log [ft],o'clock\n";
    std::string second = first;
    for (std::size_t k = 0; k < kWelds; ++k) {
      // The first run lacks weld 30, the second weld 20, and both have a tap 1 m behind weld 10.
      first += k == 30 ? "" : ",Girth Weld," + std::to_string(pipe_[k] / kFoot) + ",\n";
      second += k == 20 ? "" : ",Girth Weld," + std::to_string(other(pipe_[k]) / kFoot) + ",\n";
      if (k == 10) {
        first += ",Tap," + std::to_string((pipe_[k] + 1.0) / kFoot) + ",03:00\n";
        second += ",Tap," + std::to_string(other(pipe_[k] + 1.0) / kFoot) + ",03:00\n";
      }
    }
    write("first.csv", first);
    write("second.csv", second);
  }

  /// By the odometer of the second run.
  static double other(double chainage) { return 1.003 * chainage + 40.0; }

  void write(const std::string& name, const std::string& text) const {
    std::ofstream(path(name), std::ios::binary) << text;
  }
  [[nodiscard]] fs::path path(const std::string& name) const { return folder_.path() / name; }

  [[nodiscard]] Finished run(const std::vector<std::string>& arguments) const {
    return run_program(LEDGER_COMMAND, arguments, folder_.path());
  }
  [[nodiscard]] std::string out(const std::vector<std::string>& arguments) const {
    const auto finished = run(arguments);
    EXPECT_EQ(finished.code(), 0) << finished.err;
    return finished.out;
  }
  [[nodiscard]] std::string error(const std::vector<std::string>& arguments, int code = 1) const {
    const auto finished = run(arguments);
    EXPECT_EQ(finished.code(), code) << finished.out;
    EXPECT_THAT(finished.out, IsEmpty());
    return finished.err;
  }

  void build_first() const {
    EXPECT_THAT(
        out({"build", "first.csv", "--columns", "m.yaml", "--date", "2020", "--out", "ledger.csv"}),
        AllOf(StartsWith("A ledger of 40 girth welds, W00010 at 100.000 m to W00400 at "),
              HasSubstr("single     40 "), HasSubstr("first  2020")));
  }

  std::vector<double> pipe_;
  ::pipescout::testing::TemporaryFolder folder_;
};

TEST_F(LedgerCommand, GermanExcelsExportsGiveTheSameLedger) {
  build_first();
  const auto shown = out({"show", "ledger.csv"});
  for (const auto as : ::pipescout::testing::kExcelExports) {
    fs::remove(path("excel_ledger.csv"));  // results are never overwritten
    write("excel.csv", ::pipescout::testing::german_excel(content(path("first.csv")), as));
    const auto built = run({"build", "excel.csv", "--columns", "m.yaml", "--name", "first",
                            "--date", "2020", "--out", "excel_ledger.csv"});
    EXPECT_EQ(built.code(), 0) << built.err;
    EXPECT_THAT(built.err, HasSubstr("note: excel.csv: numbers have a decimal comma"));
    EXPECT_EQ(content(path("excel_ledger.csv")), content(path("ledger.csv")));
    // The ledger itself may have been in Excel too; that keeps 15 digits.
    write("excel.csv", ::pipescout::testing::german_excel(content(path("ledger.csv")), as));
    EXPECT_EQ(out({"show", "excel.csv"}), shown);
  }
}

TEST_F(LedgerCommand, WhatMayBeThousandsIsAskedAbout) {
  write("tally.csv", "id;joint_length_m\nA;12,125\nB;9,250\nC;11,875\nD;\n");
  EXPECT_THAT(
      error({"build", "tally.csv", "--out", "l.csv"}),
      HasSubstr("tally.csv:2: column 'joint_length_m': '12,125' may be 12.125 or 12125; give "
                "--decimal-mark"));
  EXPECT_THAT(out({"build", "tally.csv", "--decimal-mark", ",", "--out", "l.csv"}),
              HasSubstr("A at 0.000 m to D at 33.250 +- "));
  EXPECT_THAT(error({"build", "tally.csv", "--decimal-mark", ";", "--out", "l.csv"}, 2),
              HasSubstr("decimal_mark must be '.' or ',', not ';'"));
}

TEST_F(LedgerCommand, SeparatorLinesAreUnderstood) {
  build_first();
  write("sep.csv", "sep=,\n" + content(path("first.csv")));
  EXPECT_EQ(run({"build", "sep.csv", "--columns", "m.yaml", "--name", "first", "--date", "2020",
                 "--out", "sep_ledger.csv"})
                .err,
            "");
  EXPECT_EQ(content(path("sep_ledger.csv")), content(path("ledger.csv")));
}

TEST_F(LedgerCommand, AlignsARunAndPlacesItsFeatures) {
  build_first();
  const auto text =
      out({"align", "second.csv", "ledger.csv", "--columns", "m.yaml", "--out", "ledger.csv",
           "--features", "features.csv", "--report", "report.csv", "--json", "figures.json"});
  EXPECT_THAT(text, AllOf(HasSubstr("matched       39 of the run's 40 welds"),
                          HasSubstr("missing       1 in"), HasSubstr("new           1 in"),
                          HasSubstr("ambiguous     0 in"), HasSubstr("after W00300"),
                          HasSubstr("W00210"), HasSubstr("1 feature on the ledger")));

  const auto features = table(path("features.csv"));
  ASSERT_EQ(features.size(), 1U);
  EXPECT_EQ(features[0].at("line"), "13");
  EXPECT_EQ(features[0].at("kind"), "Tap");
  EXPECT_EQ(features[0].at("clock"), "03:00");
  EXPECT_EQ(features[0].at("weld"), "W00110");
  EXPECT_NEAR(std::stod(features[0].at("from_weld_m")), 1.0, 1e-3);
  EXPECT_NEAR(std::stod(features[0].at("chainage_m")), pipe_[10] + 1.0, 1e-3);
  EXPECT_GT(std::stod(features[0].at("chainage_sd_m")), 0.0);
  EXPECT_EQ(features[0].at("between_welds"), "1");

  EXPECT_THAT(content(path("report.csv")),
              StartsWith("run_chainage,ledger_chainage,ledger_id,difference,standard_deviation,"
                         "probability\n"));
  const auto report = table(path("report.csv"));
  ASSERT_EQ(report.size(), 39U);
  for (const auto& match : report) {
    EXPECT_NEAR(std::stod(match.at("run_chainage")), other(std::stod(match.at("ledger_chainage"))),
                1e-3);
    EXPECT_NEAR(std::stod(match.at("difference")),
                std::stod(match.at("ledger_chainage")) - std::stod(match.at("run_chainage")), 1e-9);
    EXPECT_GT(std::stod(match.at("probability")), 0.9);
  }

  const auto json = nlohmann::json::parse(content(path("figures.json")));
  EXPECT_EQ(json["figures"]["matched"], 39);
  EXPECT_EQ(json["figures"]["missing"], 1);
  EXPECT_EQ(json["figures"]["new"], 1);
  EXPECT_EQ(json["figures"]["features"], 1);
  EXPECT_NEAR(json["figures"]["scale"].get<double>(), 1.0 / 1.003, 1e-6);
  EXPECT_EQ(json["reversed"], false);

  EXPECT_THAT(out({"show", "ledger.csv"}),
              AllOf(StartsWith("A ledger of 41 girth welds"), HasSubstr("confirmed  39 "),
                    HasSubstr("doubtful   2 "), HasSubstr("W00300.1"), HasSubstr("map        none"),
                    HasSubstr("second")));
  EXPECT_THAT(error({"align", "second.csv", "ledger.csv", "--columns", "m.yaml", "--out", "x.csv"}),
              StartsWith("ledger.csv has the run 'second' of '' already"));
  EXPECT_FALSE(fs::exists(path("x.csv")));
  // Without a new ledger a run may be compared with what it has become a part of.
  EXPECT_THAT(out({"align", "second.csv", "ledger.csv", "--columns", "m.yaml"}),
              AllOf(HasSubstr("matched       40 of the run's 40 welds"), HasSubstr("03:00")));
}

TEST_F(LedgerCommand, FindsTheRunFromTheOtherEnd) {
  build_first();
  std::string back = "event,log [ft],o'clock\n";
  for (std::size_t k = kWelds; k-- > 0;) {
    back += "Girth Weld," + std::to_string((pipe_.back() - pipe_[k]) / kFoot) + ",\n";
  }
  write("back.csv", back);
  EXPECT_THAT(out({"align", "back.csv", "ledger.csv", "--columns", "m.yaml", "--json", "f.json"}),
              AllOf(HasSubstr("the run has the opposite direction of the ledger"),
                    HasSubstr("matched       40 of the run's 41"), HasSubstr("chainage plus")));
  EXPECT_EQ(nlohmann::json::parse(content(path("f.json")))["reversed"], true);
}

TEST_F(LedgerCommand, PartOfThePipeMissesNothingElsewhere) {
  build_first();
  std::string part = "event,log [ft],o'clock\nAnode,-9,\n";
  for (std::size_t k = 5; k < 28; ++k) {
    part += k == 12 ? "" : "Girth Weld," + std::to_string((pipe_[k] - pipe_[5]) / kFoot) + ",\n";
  }
  write("part.csv", part);
  EXPECT_THAT(out({"align", "part.csv", "ledger.csv", "--columns", "m.yaml", "--json", "f.json",
                   "--features", "features.csv"}),
              AllOf(HasSubstr("matched       22 of the run's 22"), HasSubstr("missing       1 in"),
                    HasSubstr("beyond        0 of the run and 17 of the ledger")));
  EXPECT_EQ(nlohmann::json::parse(content(path("f.json")))["figures"]["ledger_welds_beyond_run"],
            17);
  EXPECT_EQ(table(path("features.csv"))[0].at("between_welds"), "0");
}

TEST_F(LedgerCommand, TallyKeepsItsIdsAndASurveyGivesAMap) {
  std::string tally = "id,joint_length_m\n";
  for (std::size_t k = 0; k + 1 < kWelds; ++k) {
    tally += "J" + std::to_string(k) + "," + std::to_string(pipe_[k + 1] - pipe_[k]) + "\n";
  }
  write("tally.csv", tally + "end,\n");
  write("survey.csv",
        "latitude_deg,longitude_deg,height_m,chainage_m\n59,5,0,0\n59.01,5,10,1000\n");
  EXPECT_THAT(out({"build", "tally.csv", "--name", "as laid", "--survey", "survey.csv", "--out",
                   "ledger.csv", "--geojson", "map.json"}),
              AllOf(StartsWith("A ledger of 41 girth welds, J0 at 0.000 m to end at "),
                    HasSubstr("as laid"), HasSubstr("41 welds, latitude and longitude")));
  const auto map = nlohmann::json::parse(content(path("map.json")));
  EXPECT_EQ(map["type"], "FeatureCollection");
  EXPECT_EQ(map["features"].size(), 42U);

  // The map stays where it was, and a feature of a run is on it.
  EXPECT_THAT(out({"align", "second.csv", "ledger.csv", "--columns", "m.yaml", "--out", "new.csv",
                   "--features", "features.csv"}),
              HasSubstr("matched       40 of"));
  const auto before = table(path("ledger.csv"));
  const auto after = table(path("new.csv"));
  ASSERT_EQ(after.size(), before.size());
  for (std::size_t k = 0; k < before.size(); ++k) {
    EXPECT_EQ(after[k].at("id"), before[k].at("id"));
    EXPECT_NEAR(std::stod(after[k].at("latitude_deg")), std::stod(before[k].at("latitude_deg")),
                1e-12);
  }
  const auto feature = table(path("features.csv"))[0];
  EXPECT_EQ(feature.at("weld"), "J10");
  EXPECT_NEAR(std::stod(feature.at("latitude_deg")), 59.0 + 1e-5 * (pipe_[10] + 1.0 - pipe_[0]),
              1e-7);

  // A ledger is a run too; its map can be laid anew.
  EXPECT_THAT(out({"align", "new.csv", "ledger.csv"}), HasSubstr("matched       41 of"));
  EXPECT_THAT(out({"build", "new.csv", "--survey", "survey.csv", "--out", "again.csv"}),
              HasSubstr("second"));
  EXPECT_THAT(error({"build", "new.csv", "--name", "x", "--out", "more.csv"}),
              HasSubstr("names its runs"));
}

TEST_F(LedgerCommand, PositionsInTheListBecomeTheMap) {
  write("gps.yaml",
        "{distance: d, unit: metres, kind: k, girth_weld: w, latitude: lat, longitude: lon}");
  std::string list = "k,d,lat,lon\n";
  for (std::size_t k = 0; k < kWelds; ++k) {
    list += "w," + std::to_string(pipe_[k]) + "," +
            (k % 10 == 0 ? std::to_string(59.0 + 0.001 * static_cast<double>(k)) + ",5\n" : ",\n");
  }
  write("gps.csv", list);
  EXPECT_THAT(out({"build", "gps.csv", "--columns", "gps.yaml", "--out", "ledger.csv"}),
              HasSubstr("map        41 welds"));
  EXPECT_EQ(table(path("ledger.csv"))[20].at("latitude_deg"), "59.02");
  fs::remove(path("ledger.csv"));
  build_first();
  (void)out({"align", "gps.csv", "ledger.csv", "--columns", "gps.yaml", "--out", "ledger.csv"});
  EXPECT_EQ(table(path("ledger.csv"))[20].at("latitude_deg"), "59.02");
  EXPECT_THAT(run({"show", "ledger.csv", "--geojson", "map.json"}).err, IsEmpty());
}

TEST_F(LedgerCommand, SaysWhyItCannotAlign) {
  build_first();
  write("metres.yaml", "distance: log [ft]\nunit: metres\nkind: event\ngirth_weld: Girth Weld\n");
  EXPECT_THAT(error({"align", "second.csv", "ledger.csv", "--columns", "metres.yaml"}),
              HasSubstr("unit is 'metres', and the column 'log [ft]' says ft"));
  write("metres.yaml", "distance: log\nunit: metres\nkind: event\ngirth_weld: Girth Weld\n");
  std::string unnamed = content(path("second.csv"));
  unnamed.erase(unnamed.find(" [ft]"), std::string_view(" [ft]").size());
  write("second.csv", unnamed);
  EXPECT_THAT(error({"align", "second.csv", "ledger.csv", "--columns", "metres.yaml", "--out",
                     "new.csv", "--json", "f.json"}),
              AllOf(StartsWith("second.csv cannot be aligned to ledger.csv: "),
                    HasSubstr("is the unit of the distances right?"),
                    HasSubstr("second.csv: 39 joints, the middle one of "),
                    HasSubstr("ledger.csv: 39 joints, the middle one of ")));
  EXPECT_FALSE(fs::exists(path("new.csv")) || fs::exists(path("f.json")));
  write("short.csv", "id,joint_length_m\nA,12\nB,\n");
  EXPECT_THAT(error({"align", "short.csv", "ledger.csv"}), HasSubstr("each needs 3 girth welds"));
  EXPECT_THAT(error({"build", "short.csv", "--out", "new.csv"}),
              "short.csv: 2 girth welds are too few for a ledger, which takes 3\n");
}

TEST_F(LedgerCommand, RefusesTheListOfAnotherPipe) {
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    std::mt19937_64 engine(seed);
    const auto list = [&] {
      double chainage = 0.0;
      std::string text = "Log distance [m],Feature type\n";
      for (std::size_t k = 0; k < 300; ++k) {
        text += std::to_string(chainage) + ",Weld\n";
        // Most cut to one length, as pipes are.
        chainage += engine() % 4 == 0 ? 4.0 + static_cast<double>(engine() % 8000) / 1000.0
                                      : 12.0 + static_cast<double>(engine() % 400) / 1000.0;
      }
      return text;
    };
    write("one.csv", list());
    write("other.csv", list());
    fs::remove(path("one_ledger.csv"));
    (void)out({"build", "one.csv", "--out", "one_ledger.csv"});
    EXPECT_THAT(error({"align", "other.csv", "one_ledger.csv"}),
                StartsWith("other.csv cannot be aligned to one_ledger.csv"))
        << seed;
  }
}

TEST_F(LedgerCommand, KnowsTheColumnsOfThePipelineOperatorsForum) {
  std::string first = "Log distance [m];Feature type;Feature identification;Clock position\n";
  std::string second = first;
  const auto add = [&](double chainage, const std::string& kind) {
    first += std::to_string(chainage) + ";" + kind + ";;\n";
    second += std::to_string(other(chainage)) + ";" + kind + ";;\n";
  };
  for (std::size_t k = 0; k < kWelds; ++k) {
    add(pipe_[k], "Weld");
    if (k == 5) {
      add(pipe_[k] + 2.0, "Valve");
    }
    if (k == 20) {
      add(pipe_[k] + 1.5, "Marker");
      add(pipe_[k] + 3.0, "Anomaly");
    }
  }
  second += std::to_string(other(pipe_.back() - 1.0)) + ";Tee;;\n";
  write("first_pof.csv", first);
  write("second_pof.csv", second);
  EXPECT_THAT(out({"build", "first_pof.csv", "--out", "ledger.csv"}),
              HasSubstr("landmarks  1 marker, 1 valve"));
  EXPECT_THAT(out({"align", "second_pof.csv", "ledger.csv", "--out", "ledger.csv"}),
              HasSubstr("matched       41 of the run's 41 welds"));
  EXPECT_THAT(out({"show", "ledger.csv"}), HasSubstr("landmarks  1 marker, 1 valve, 1 tee"));
  std::map<std::string, std::map<std::string, std::string>> landmarks;
  for (const auto& row : table(path("ledger.csv"))) {
    if (row.at("kind") != "weld") {
      landmarks[row.at("id")] = row;
    }
  }
  ASSERT_EQ(landmarks.size(), 3U);
  EXPECT_EQ(landmarks["V00010"].at("seen"), "2");
  EXPECT_EQ(landmarks["M00010"].at("seen"), "2");
  EXPECT_EQ(landmarks["T00010"].at("seen"), "1");
  const auto ledger = ledger_from_csv(CsvTable(content(path("ledger.csv")), "ledger.csv"));
  EXPECT_NEAR(std::stod(landmarks["V00010"].at("chainage_m")), ledger.welds[5].chainage + 2.0,
              0.02);
}

TEST_F(LedgerCommand, TellsAReplacedSection) {
  build_first();
  // Four joints are cut out and three others, together 20 mm longer, are welded in.
  std::string list = "event,log [ft],o'clock\n";
  const double begin = pipe_[10];
  const double length = pipe_[14] - begin;
  for (std::size_t k = 0; k < kWelds; ++k) {
    const double at = k <= 10 ? pipe_[k] : pipe_[k] + 0.02;
    if (k <= 10 || k >= 14) {
      list += "Girth Weld," + std::to_string(at / kFoot) + ",\n";
    }
    if (k == 10) {
      for (const double part : {0.31, 0.57}) {
        list += "Girth Weld," + std::to_string((begin + part * length) / kFoot) + ",\n";
      }
    }
  }
  write("later.csv", list);
  const auto text = out({"align", "later.csv", "ledger.csv", "--columns", "m.yaml", "--json",
                         "figures.json", "--out", "new.csv"});
  EXPECT_THAT(text, AllOf(HasSubstr("Replaced sections"), HasSubstr("missing       3 in"),
                          HasSubstr("new           3 in")));
  const auto figures = nlohmann::json::parse(content(path("figures.json")));
  ASSERT_EQ(figures["replaced_sections"].size(), 1U);
  const auto& section = figures["replaced_sections"][0];
  EXPECT_EQ(section["from_weld"], "W00110");
  EXPECT_EQ(section["to_weld"], "W00150");
  EXPECT_EQ(section["ledger_joints"], 4);
  EXPECT_EQ(section["run_joints"], 3);
}

TEST_F(LedgerCommand, BadFilesAreNamedWithTheirLine) {
  build_first();
  write("bad.yaml", "distance: d\ncolour: red\n");
  EXPECT_THAT(error({"build", "first.csv", "--columns", "bad.yaml", "--out", "x.csv"}),
              StartsWith("error: bad.yaml:2:1: unknown key 'colour'"));
  EXPECT_THAT(error({"build", "first.csv", "--columns", "none.yaml", "--out", "x.csv"}),
              StartsWith("error: none.yaml: "));
  EXPECT_THAT(error({"build", "first.csv", "--out", "x.csv"}),
              StartsWith("error: first.csv:1: column 'joint': is not a column of a ledger"));
  EXPECT_THAT(error({"show", "none.csv"}), "error: none.csv: No such file or directory\n");
  EXPECT_THAT(error({"show", "."}), "error: .: is not a regular file\n");
  write("empty.csv", "");
  EXPECT_THAT(error({"show", "empty.csv"}), StartsWith("error: empty.csv: is empty"));
  write("twice.csv", "id,chainage_m\nA,5\nB,5\n");
  EXPECT_THAT(error({"show", "twice.csv"}),
              "error: twice.csv:3: column 'chainage_m': 5 is not above 5\n");
  EXPECT_THAT(error({"build", "first.csv", "--columns", "m.yaml", "--out", "none/x.csv"}),
              HasSubstr("none/x.csv"));
  const auto plain = run({"show", "ledger.csv", "--geojson", "map.json"});
  EXPECT_EQ(plain.code(), 0);
  EXPECT_THAT(plain.err, StartsWith("note: map.json has no positions"));
}

TEST_F(LedgerCommand, OnlyTheLedgerOfARunIsReplaced) {
  build_first();
  write("other.csv", "mine");
  const auto refused = HasSubstr("other.csv: exists already; results are never overwritten");
  EXPECT_THAT(error({"build", "first.csv", "--columns", "m.yaml", "--out", "other.csv"}), refused);
  EXPECT_THAT(error({"show", "ledger.csv", "--geojson", "other.csv"}), refused);
  for (const char* option : {"--out", "--features", "--report", "--json"}) {
    EXPECT_THAT(
        error({"align", "first.csv", "ledger.csv", "--columns", "m.yaml", option, "other.csv"}),
        refused)
        << option;
  }
  EXPECT_EQ(content(path("other.csv")), "mine");
}

TEST_F(LedgerCommand, WrongCommandLinesAreTold) {
  build_first();
  const auto usage = [&](const std::vector<std::string>& arguments) { return error(arguments, 2); };
  EXPECT_THAT(usage({}), HasSubstr("--help"));
  EXPECT_THAT(usage({"bild"}), StartsWith("unknown command 'bild'; did you mean 'build'?"));
  EXPECT_THAT(usage({"build", "first.csv"}), StartsWith("--out is required"));
  EXPECT_THAT(usage({"align", "first.csv"}), StartsWith("ledger is required"));
  EXPECT_THAT(usage({"show", "ledger.csv", "--rout", "x"}), HasSubstr("--rout"));
  EXPECT_THAT(usage({"build", "first.csv", "--out", "x.csv", "--name", "a|b"}),
              StartsWith("--name: 'a|b' is empty or holds '|'"));
  EXPECT_THAT(usage({"build", "first.csv", "--out", "first.csv"}),
              StartsWith("first.csv is read and would be overwritten"));
  EXPECT_THAT(usage({"align", "first.csv", "ledger.csv", "--json", "./ledger.csv"}),
              StartsWith("./ledger.csv is read and would be overwritten"));
  EXPECT_THAT(usage({"build", "first.csv", "--out", "x", "--geojson", "./x"}),
              StartsWith("two results cannot go to one file"));
  for (const char* command : {"build", "align", "show"}) {
    EXPECT_THAT(out({command, "--help"}), HasSubstr("Usage: "));
  }
}

/// Two runs of one 17.5 km pipeline, eight years apart, by different tools.
TEST_F(LedgerCommand, RealRunsShareALedger) {
  const char* shared = std::getenv("PIPESCOUT_SHARED_DATA");
  const auto data = fs::path(shared == nullptr ? "" : shared) / "ili_pipeline";
  if (!fs::exists(data / "2007.csv") || !fs::exists(data / "2015.csv")) {
    GTEST_SKIP() << "NOT TESTED on real inspection runs: PIPESCOUT_SHARED_DATA names no folder "
                    "with ili_pipeline/2007.csv and 2015.csv";
  }
  const std::string columns = COLUMNS_FOLDER;
  EXPECT_THAT(out({"build", (data / "2007.csv").string(), "--columns", columns + "/ili_2007.yaml",
                   "--out", "ledger.csv"}),
              StartsWith("A ledger of 1603 girth welds"));
  EXPECT_THAT(out({"align", (data / "2015.csv").string(), "ledger.csv", "--columns",
                   columns + "/ili_2015.yaml", "--out", "both.csv", "--features", "features.csv",
                   "--report", "report.csv", "--json", "figures.json"}),
              HasSubstr("welds where the two overlap"));
  const auto figures = nlohmann::json::parse(content(path("figures.json")))["figures"];
  EXPECT_GE(figures["matched"], 1595);  // 99.5 % of the 1603 that both saw
  EXPECT_EQ(figures["features"], 2071);
  EXPECT_EQ(table(path("features.csv")).size(), 2071U);
  EXPECT_EQ(table(path("report.csv")).size(), figures["matched"]);
  const auto text = content(path("both.csv"));
  EXPECT_EQ(to_csv(ledger_from_csv(CsvTable(text, "ledger.csv"))), text);
  EXPECT_THAT(out({"show", "both.csv"}), HasSubstr("confirmed  " + figures["matched"].dump()));
}

}  // namespace
}  // namespace pipescout::ledger
