// SPDX-License-Identifier: Apache-2.0

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <pipescout_msgs/msg/bend_detection.hpp>
#include <pipescout_msgs/msg/eddy_current_samples.hpp>
#include <pipescout_msgs/msg/fused_odometer.hpp>
#include <pipescout_msgs/msg/pipe_position.hpp>
#include <pipescout_msgs/msg/weld_detection.hpp>
#include <stdexcept>
#include <string>
#include <vector>

#include "pipescout/catalogue/topics.hpp"
#include "pipescout/odometer_readings/readings_csv.hpp"
#include "pipescout/runtime/conversions.hpp"
#include "tables/crawler_lines.hpp"
#include "tables/crawler_report.hpp"
#include "tables/makers.hpp"

namespace pipescout::summary {

namespace {

/// More than any robot has; no file gets so many columns.
constexpr std::size_t kMaximumOdometers = 64;
constexpr std::size_t kMaximumChannels = 64;

CrawlerReport::Position to_report(const pipescout_msgs::msg::PipePosition& message) {
  return {.stamp = from_message(message.header.stamp),
          .locked = message.locked,
          .joint = message.joint,
          .into_joint = message.distance_into_joint,
          .standard_deviation = std::sqrt(message.covariance[0]),
          .odometer_distance = message.odometer_distance};
}

class CrawlerTables final : public TableMaker {
 public:
  CrawlerTables(const Robot& robot, const TableOptions::Crawler& options);

 protected:
  MissionSection section(const std::string& figure_prefix) const override {
    return report_.section(figure_prefix);
  }
  std::string counts() const override {
    return std::to_string(report_.positions()) + " positions and " +
           std::to_string(report_.welds()) + " welds recorded";
  }
  bool has_data() const override { return report_.positions() > 0; }
  bool has_section() const override { return report_.positions() > 0 || report_.welds() > 0; }
  std::string file_names() const override {
    return "fused.csv, welds.csv, bends.csv, positions.csv, truth.csv, eddy_current.csv";
  }

 private:
  using Bend = pipescout_msgs::msg::BendDetection;
  using Fused = pipescout_msgs::msg::FusedOdometer;
  using Samples = pipescout_msgs::msg::EddyCurrentSamples;
  using Weld = pipescout_msgs::msg::WeldDetection;
  using Position = pipescout_msgs::msg::PipePosition;

  void on_fused(const Fused& message);
  void on_samples(const Samples& message);
  void on_weld(const Weld& message);
  void on_position(const Position& message);
  void on_truth(const Position& message);

  bool with_signal_;
  CrawlerReport report_;
  std::vector<std::string> odometers_;  // of the first fused distance
  std::size_t channels_ = 0;            // of the first samples
};

CrawlerTables::CrawlerTables(const Robot& robot, const TableOptions::Crawler& options)
    : TableMaker(robot, "crawler"), with_signal_(options.signal), report_(options.table_rows) {
  record(topics::kOdometerFused, "fused distances", [this](const Fused& m) { on_fused(m); });
  record(topics::kEddyCurrent, "eddy currents", [this](const Samples& m) { on_samples(m); });
  record(topics::kWeld, "welds", [this](const Weld& m) { on_weld(m); });
  record(topics::kBend, "bends",
         [this](const Bend& m) { file("bends.csv", bend_csv_header).write(bend_csv_line(m)); });
  record(topics::kPipePosition, "positions", [this](const Position& m) { on_position(m); });
  record(topics::kTruePipePosition, "truth", [this](const Position& m) { on_truth(m); });
}

void CrawlerTables::on_fused(const Fused& message) {
  const std::size_t odometers = message.name.size();
  const auto fits = [odometers](std::size_t size) { return size == odometers || size == 0; };
  if (odometers == 0 || odometers > kMaximumOdometers ||
      message.rejection_reason.size() != odometers ||
      message.support.size() != odometers * odometers || !fits(message.health.size()) ||
      message.scale.size() != message.health.size() ||
      message.scale_standard_deviation.size() != message.health.size()) {
    throw std::invalid_argument("lists of different lengths");
  }
  if (odometers_.empty()) {
    odometers_ = message.name;
  } else if (odometers_ != message.name) {
    throw std::invalid_argument("other odometers than before");
  }
  file("fused.csv", [this] {
    return fused_csv_header(odometer_column_names(odometers_));
  }).write(fused_csv_line(message));
}

void CrawlerTables::on_samples(const Samples& message) {
  const std::size_t channels = message.channels;
  if (channels == 0 || channels > kMaximumChannels || message.x.size() % channels != 0 ||
      message.y.size() != message.x.size() || !(message.sample_interval > 0.0)) {
    throw std::invalid_argument("lists of inconsistent lengths");
  }
  if (!with_signal_) {
    return;
  }
  if (channels_ == 0) {
    channels_ = channels;
  } else if (channels_ != channels) {
    throw std::invalid_argument("another number of channels than before");
  }
  TableFile& lines = file("eddy_current.csv", [=] { return samples_csv_header(channels); });
  for (std::size_t k = 0; k < message.x.size() / channels; ++k) {
    lines.write(samples_csv_line(message, k));
  }
}

void CrawlerTables::on_weld(const Weld& message) {
  file("welds.csv", weld_csv_header).write(weld_csv_line(message));
  const bool known = message.weld >= 0;
  report_.add_weld({.id = !known                    ? ""
                          : message.weld_id.empty() ? std::to_string(message.weld)
                                                    : message.weld_id,
                    .chainage = message.chainage,
                    .distance = message.distance,
                    .standard_deviation = message.standard_deviation,
                    .confidence = message.confidence,
                    .probability = message.weld_probability});
}

void CrawlerTables::on_position(const Position& message) {
  file("positions.csv", position_csv_header).write(position_csv_line(message));
  report_.add_position(to_report(message));
}

void CrawlerTables::on_truth(const Position& message) {
  file("truth.csv", position_csv_header).write(position_csv_line(message));
  report_.add_truth(to_report(message));
}

}  // namespace

std::unique_ptr<TableMaker> crawler_tables(const Robot& robot,
                                           const TableOptions::Crawler& options) {
  return std::make_unique<CrawlerTables>(robot, options);
}

}  // namespace pipescout::summary
