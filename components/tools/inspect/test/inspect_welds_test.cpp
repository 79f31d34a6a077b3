// SPDX-License-Identifier: Apache-2.0
// `pipescout inspect welds`, on signals made here.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <fstream>
#include <pipescout_msgs/msg/eddy_current_samples.hpp>
#include <pipescout_msgs/msg/fused_odometer.hpp>
#include <string>
#include <vector>

#include "pipescout/bags/bag_writer.hpp"
#include "pipescout/csv/csv_table.hpp"
#include "pipescout/csv/testing/german_excel.hpp"
#include "pipescout/files/testing/temporary_folder.hpp"
#include "pipescout/idl/message_type.hpp"
#include "pipescout/simulation/eddy_current_signal.hpp"
#include "pipescout/testing/program.hpp"

namespace pipescout::inspect {
namespace {

namespace fs = std::filesystem;
using ::pipescout::testing::content;
using ::pipescout::testing::run_program;
using ::testing::HasSubstr;

constexpr double kSpeed = 0.4;    // m/s
constexpr double kRate = 200.0;   // Hz
constexpr double kLength = 60.0;  // m

/// Nine joints of about 6 m, no valves or dents.
std::vector<simulation::EddyCurrentSample> weld_signal() {
  simulation::PipeParameters pipe;
  pipe.length = kLength;
  pipe.joint_length = 6.0;
  pipe.valves_per_km = pipe.bends_per_km = pipe.dents_per_km = 0.0;
  simulation::EddyCurrentParameters probe;
  probe.sample_rate = kRate;
  probe.peak_snr = 24.0;
  simulation::EddyCurrentSignal signal(probe, simulation::draw_features(pipe, 7), 8);
  std::vector<simulation::EddyCurrentSample> samples;
  for (double distance = 0.0; distance < kLength; distance += kSpeed / kRate) {
    samples.push_back(signal.next(distance));
  }
  return samples;
}

std::vector<double> true_welds() {
  simulation::PipeParameters pipe;
  pipe.length = kLength;
  pipe.joint_length = 6.0;
  pipe.valves_per_km = pipe.bends_per_km = pipe.dents_per_km = 0.0;
  std::vector<double> welds;
  for (const auto& feature : simulation::draw_features(pipe, 7)) {
    // The last metre of a signal is not decided.
    if (feature.position > 1.0 && feature.position < kLength - 1.0) {
      welds.push_back(feature.position);
    }
  }
  return welds;
}

class InspectWelds : public ::testing::Test {
 protected:
  void write_table(const std::string& name, const std::string& header, char delimiter,
                   double unit) const {
    std::ofstream file(folder_.path() / name);
    file << header << '\n';
    for (const auto& sample : weld_signal()) {
      if (sample.fault != simulation::SampleFault::kMissing) {
        file << format_csv_number(sample.distance / unit) << delimiter
             << format_csv_number(sample.value.real()) << delimiter
             << format_csv_number(sample.value.imag()) << '\n';
      }
    }
  }
  void write(const std::string& name, const std::string& text) const {
    std::ofstream(folder_.path() / name) << text;
  }
  void write_bag() const {
    bags::BagWriter writer(folder_.path() / "bag", {});
    const auto put = [&](const std::string& topic, const std::string& type_name,
                         const auto& message) {
      using Message = std::decay_t<decltype(message)>;
      const MessageType& type = message_type<Message>();
      std::vector<std::byte> data(type.serialized_size(&message));
      ASSERT_EQ(type.serialize(&message, data), data.size());
      const auto index = writer.add_topic({.name = topic, .type = type_name});
      const std::int64_t time =
          message.header.stamp.sec * 1'000'000'000LL + message.header.stamp.nanosec;
      writer.write({.topic = index, .log_time = time, .publish_time = time, .data = data});
    };
    const auto samples = weld_signal();
    for (std::size_t second = 0; second * 200 < samples.size(); ++second) {
      pipescout_msgs::msg::FusedOdometer fused;
      fused.header.stamp.sec = static_cast<std::int32_t>(1 + second);
      fused.distance = kSpeed * static_cast<double>(second);
      put("/odometer/fused", "pipescout_msgs/msg/FusedOdometer", fused);
      pipescout_msgs::msg::EddyCurrentSamples message;
      message.header.stamp.sec = static_cast<std::int32_t>(1 + second);
      message.sample_interval = 1.0 / kRate;
      message.channels = 1;
      for (std::size_t k = second * 200; k < std::min(samples.size(), second * 200 + 200); ++k) {
        message.x.push_back(samples[k].value.real());
        message.y.push_back(samples[k].value.imag());
      }
      put("/eddy_current", "pipescout_msgs/msg/EddyCurrentSamples", message);
    }
    writer.close();
  }
  [[nodiscard]] auto run(std::vector<std::string> arguments) const {
    arguments.insert(arguments.begin(), "welds");
    return run_program(INSPECT_COMMAND, arguments, folder_.path());
  }
  void check_welds() const {
    const CsvTable csv(content(folder_.path() / "welds.csv"), "welds.csv");
    const std::vector<double> welds = true_welds();
    ASSERT_EQ(csv.rows(), welds.size());
    for (std::size_t k = 0; k < welds.size(); ++k) {
      EXPECT_NEAR(csv.required(k, 0), welds[k], 0.01);
      EXPECT_EQ(csv.cell(k, 1), "Weld");
    }
  }

  ::pipescout::testing::TemporaryFolder folder_;
};

TEST_F(InspectWelds, FindsTheWeldsOfATable) {
  write_table("signal.csv", "distance_m,x,y", ',', 1.0);
  const auto result = run({"signal.csv", "--out", "welds.csv"});
  EXPECT_EQ(result.code(), 0) << result.err;
  EXPECT_THAT(result.out,
              HasSubstr("0 to 60 m, " + std::to_string(true_welds().size()) + " welds"));
  check_welds();
  write("welds.csv", "of another run");
  const auto again = run({"signal.csv", "--out", "welds.csv"});
  EXPECT_EQ(again.code(), 1);
  EXPECT_THAT(again.err, HasSubstr("welds.csv: exists already; results are never overwritten"));
  EXPECT_EQ(::pipescout::testing::content(folder_.path() / "welds.csv"), "of another run");
}

TEST_F(InspectWelds, TakesTheColumnsThatAMappingNames) {
  write_table("signal.csv", "Weg;Real;Imag", ';', 1e-3);
  write("columns.yaml", "distance: Weg\nunit: mm\nx: Real\ny: [Imag]\ndelimiter: ;\n");
  const auto result = run({"signal.csv", "--columns", "columns.yaml", "--out", "welds.csv"});
  EXPECT_EQ(result.code(), 0) << result.err;
  check_welds();
}

TEST_F(InspectWelds, GermanExcelsExportsGiveTheSameWelds) {
  write_table("signal.csv", "distance_m,x,y", ',', 1.0);
  ASSERT_EQ(run({"signal.csv", "--out", "original.csv"}).code(), 0);
  for (const auto as : ::pipescout::testing::kExcelExports) {
    write("excel.csv",
          ::pipescout::testing::german_excel(content(folder_.path() / "signal.csv"), as));
    fs::remove(folder_.path() / "welds.csv");  // results are never overwritten
    const auto result = run({"excel.csv", "--out", "welds.csv"});
    EXPECT_EQ(result.code(), 0) << result.err;
    EXPECT_THAT(result.err, HasSubstr("note: excel.csv: numbers have a decimal comma"));
    // 15 digits of a cell are less than a double has.
    check_welds();
    EXPECT_EQ(CsvTable(content(folder_.path() / "welds.csv"), "").rows(),
              CsvTable(content(folder_.path() / "original.csv"), "").rows());
  }
}

TEST_F(InspectWelds, WhatMayBeThousandsIsAskedAbout) {
  write("signal.csv", "distance_m;x;y\n0;1,234;2\n");
  write("columns.yaml", "distance: distance_m\nunit: m\nx: x\ny: y\n");
  const std::string problem =
      "signal.csv:2: column 'x': '1,234' may be 1.234 or 1234; set 'decimal_mark' in ";
  EXPECT_THAT(run({"signal.csv"}).err, HasSubstr(problem + "the file of --columns"));
  EXPECT_THAT(run({"signal.csv", "--columns", "columns.yaml"}).err,
              HasSubstr(problem + "columns.yaml"));
  write("columns.yaml", "distance: distance_m\nunit: m\nx: x\ny: y\ndecimal_mark: ','\n");
  EXPECT_EQ(run({"signal.csv", "--columns", "columns.yaml"}).code(), 0);
  write("units.csv", "distance_m,x,y\nmm,V,V\n0,1,2\n");
  EXPECT_THAT(run({"units.csv"}).err,
              HasSubstr("column 'distance_m' is in mm, and the unit is m without --columns"));
}

TEST_F(InspectWelds, TakesABag) {
  write_bag();
  const auto result = run({"bag", "--out", "welds.csv"});
  EXPECT_EQ(result.code(), 0) << result.err;
  check_welds();
  EXPECT_THAT(result.out, HasSubstr("199 samples before the first or after the last distance"));
  const auto other = run({"bag", "--topic", "/probe"});
  EXPECT_EQ(other.code(), 1);
  EXPECT_THAT(other.err, HasSubstr("bag: has no topic '/probe' of "
                                   "pipescout_msgs/msg/EddyCurrentSamples; choose one with "
                                   "--topic: /eddy_current"));
}

TEST_F(InspectWelds, UsesADamagedBagAsFarAsItGoes) {
  write_bag();
  for (const auto& entry : fs::directory_iterator(folder_.path() / "bag")) {
    if (entry.path().filename() != "metadata.yaml") {
      fs::resize_file(entry.path(), fs::file_size(entry.path()) * 2 / 3);
    }
  }
  const auto result = run({"bag", "--out", "welds.csv"});
  EXPECT_EQ(result.code(), 1);
  EXPECT_THAT(result.err, HasSubstr("bag cannot be read to its end"));
  const std::size_t found = CsvTable(content(folder_.path() / "welds.csv"), "welds.csv").rows();
  EXPECT_GT(found, 1U);
  EXPECT_LT(found, true_welds().size());
}

TEST_F(InspectWelds, NamesWhatItCannotUse) {
  write("number.csv", "distance_m,x,y\n0,1,2\n0.1,1;5,2\n");
  EXPECT_THAT(run({"number.csv"}).err,
              HasSubstr("number.csv:3: column 'x': '1;5' is not a number"));
  write("distance.csv", "distance_m,x,y\n,1,2\n");
  EXPECT_THAT(run({"distance.csv"}).err,
              HasSubstr("distance.csv:2: column 'distance_m': '' is not a distance"));
  write("header.csv", "s,x,y\n0,1,2\n");
  EXPECT_THAT(run({"header.csv"}).err,
              HasSubstr("header.csv:1: no column 'distance_m'; the file has 's', 'x', 'y' (other "
                        "names need --columns)"));
  write("unit.yaml", "distance: s\nunit: miles\nx: x\ny: y\n");
  EXPECT_THAT(run({"header.csv", "--columns", "unit.yaml"}).err,
              HasSubstr("unit.yaml:2:7: unit must be one of metres (m)"));
  write("pairs.yaml", "distance: s\nunit: m\nx: [x, y]\ny: y\n");
  EXPECT_THAT(run({"header.csv", "--columns", "pairs.yaml"}).err,
              HasSubstr("pairs.yaml:4:4: 1 columns of y for 2 of x"));
  EXPECT_THAT(run({"number.csv", "--smallest-width", "3"}).err, HasSubstr("smallest_width"));
  EXPECT_EQ(run({"nowhere.csv"}).code(), 2);
  for (const char* name : {"number.csv", "distance.csv", "header.csv"}) {
    EXPECT_EQ(run({name}).code(), 1) << name;
  }
}

}  // namespace
}  // namespace pipescout::inspect
